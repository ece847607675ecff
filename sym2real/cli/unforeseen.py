"""The last net: an error that nobody foresaw becomes one line, and a file for whoever mends it."""

import os
import platform
import shlex
import sys
import tempfile
import traceback
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from sym2real import __version__

OFF = "SYM2REAL_TRACEBACK"  # set to 1, errors come as tracebacks
LIBRARIES = ("torch", "numpy", "scipy", "sympy", "mujoco", "pyarrow", "rich", "tyro")


def net_is_off() -> bool:
    """Whether whoever runs this, such as a test, wants the traceback itself."""
    return os.environ.get(OFF, "") not in ("", "0")


def told_of(error: BaseException, arguments: Sequence[str]) -> str:
    """Write the traceback, the versions and the command to a file; a line that names it and asks for a report.

    Args:
        error: what nobody foresaw.
        arguments: what was typed after the program's name.
    """
    what = " ".join(f"{type(error).__name__}: {error}".split())[:200]
    text = "\n".join((*_about(arguments), "", "".join(traceback.format_exception(error))))
    try:
        number, name = tempfile.mkstemp(prefix="sym2real-error-", suffix=".txt")
        os.close(number)
        Path(name).write_text(text, encoding="utf-8", errors="backslashreplace")
    except OSError:
        last = traceback.extract_tb(error.__traceback__)[-1]
        return f"{what} ({Path(last.filename).name}, line {last.lineno}), a fault of sym2real: please report it"
    return f"{what}, a fault of sym2real: please report it with {name}, which holds what happened and the command"


def _about(arguments: Sequence[str]) -> list[str]:
    system = f"sym2real {__version__}, Python {sys.version.split()[0]}, {platform.platform()}"
    return [system, *(f"{library} {version(library)}" for library in LIBRARIES), f"sym2real {shlex.join(arguments)}"]
