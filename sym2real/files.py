"""Files that appear whole or not at all: written beside their place, then moved there."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sym2real.errors import DataError


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Where to write a file of that name; it takes its place in the end, and is gone where writing fails.

    Args:
        path: the file's place; its folder is made where it is missing.

    Raises:
        DataError: when there is no writing there.
    """
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=".writing-") as folder:
            beside = Path(folder) / target.name
            yield beside
            beside.replace(target)
    except OSError as error:
        raise DataError(target, "a file that can be written", error.strerror or type(error).__name__) from error


def write_text(path: str | Path, text: str) -> None:
    """Write a text in UTF-8, whole or not at all; arguments and errors as of :func:`whole`."""
    with whole(path) as beside:
        beside.write_text(text, encoding="utf-8")
