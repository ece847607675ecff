"""Where a verb's words go: tables and progress to the terminal, figures as JSON to a file or to standard output."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

from rich.console import Console

from sym2real.errors import ModelError
from sym2real.files import require_place, write_text

STANDARD_OUTPUT = Path("-")


def console_for(json_file: Path | None) -> Console:
    """The terminal; standard error when standard output belongs to JSON."""
    return Console(stderr=json_file == STANDARD_OUTPUT, highlight=False)


def write_json(result: dict[str, Any], json_file: Path | None) -> None:
    """Write a verb's result where ``--json`` says; numbers that JSON lacks (NaN, infinity) become null."""
    if json_file is None:
        return
    text = json.dumps(_plain(result), indent=1, ensure_ascii=False)
    if json_file == STANDARD_OUTPUT:
        sys.stdout.write(text + "\n")
        return
    write_text(json_file, text + "\n")


def require_places(verb: Any) -> None:
    """Refuse ``--out`` and ``--json`` before the work where nothing can be written there.

    Args:
        verb: with ``json`` and perhaps ``out``, a folder unless ``OUT_IS_FILE``.

    Raises:
        DataError: naming the place.
        ModelError: for a file that a saved model consists of.
    """
    files = {} if verb.json in (None, STANDARD_OUTPUT) else {"--json": verb.json}
    if getattr(verb, "out", None) is not None:
        if getattr(verb, "OUT_IS_FILE", False):
            files["--out"] = verb.out
        else:
            require_place(verb.out, folder=True)
    for option, file in files.items():
        require_place(file, folder=False)
        if file.exists():
            _require_no_part_of_a_model(option, file)


def _require_no_part_of_a_model(option: str, file: Path) -> None:
    from sym2real.symbolic.storage import is_part_of_model

    if is_part_of_model(file):
        raise ModelError(f"{option}: {file} is a part of a model, which would be lost; name another file")


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
