"""Where a verb's words go: tables and progress to the terminal, figures as JSON to a file or to standard output."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

from rich.console import Console

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
    """
    if getattr(verb, "out", None) is not None:
        require_place(verb.out, folder=not getattr(verb, "OUT_IS_FILE", False))
    if verb.json not in (None, STANDARD_OUTPUT):
        require_place(verb.json, folder=False)


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
