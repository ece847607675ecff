"""The command line in a fork of this process: a run of its own, without the seconds that loading libraries takes."""

from __future__ import annotations

import os
import resource
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from sym2real.cli import main
from sym2real.cli.unforeseen import OFF

SECONDS = 60


@dataclass(frozen=True)
class Ran:
    """What a run left: its exit status (negative: the signal that ended it) and what it said."""

    status: int
    out: str
    err: str


def forked(
    arguments: Sequence[str],
    folder: Path,
    *,
    most_bytes: int | None = None,
    seconds: int = SECONDS,
    net: bool = True,
    encoding: str = "utf-8",
) -> Ran:
    """Run the command line in a folder.

    Args:
        arguments: what is typed after the program's name.
        folder: where it runs.
        most_bytes: that a file may have, as on a full disk.
        seconds: after which it is ended by SIGALRM.
        net: whether an error that nobody foresaw becomes one line.
        encoding: of standard output.
    """

    def work() -> None:
        sys.stdout = open(1, "w", encoding=encoding, closefd=False)  # noqa: SIM115
        os.environ[OFF] = "" if net else "1"
        if most_bytes is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
        main(arguments)

    return in_fork(work, folder, seconds)


def in_fork(work: Callable[[], None], folder: Path, seconds: int = SECONDS) -> Ran:
    """Do something in a fork and say how it ended."""
    with tempfile.TemporaryDirectory() as said:
        process = os.fork()
        if process == 0:
            _child(work, folder, Path(said), seconds)
        _, status = os.waitpid(process, 0)
        out, err = (Path(said, name).read_bytes().decode(errors="replace") for name in ("out", "err"))
    return Ran(os.waitstatus_to_exitcode(status), out, err)


def _child(work: Callable[[], None], folder: Path, said: Path, seconds: int) -> None:
    status = 99
    try:
        for number, name in ((1, "out"), (2, "err")):
            os.dup2(os.open(said / name, os.O_WRONLY | os.O_CREAT), number)
        sys.stdout, sys.stderr = (open(number, "w", encoding="utf-8", closefd=False) for number in (1, 2))  # noqa: SIM115
        os.chdir(folder)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(seconds)
        work()
        status = 0
    except SystemExit as stopped:
        status = int(stopped.code or 0)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
