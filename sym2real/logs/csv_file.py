"""Strict reading of CSV files, and writing that keeps every bit of a float64."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from sym2real.errors import DataError
from sym2real.trajectory import Array

OTHER_DELIMITERS = {";": "semicolons", "\t": "tabs", "|": "bars"}
FIRST_ROW = 2  # the header is line 1


def read(path: Path) -> tuple[list[str], list[Array | Sequence[str]], int, None]:
    """Column names, cells by column, the line of the first row, and no metadata.

    A column of numbers comes as an array, one that holds anything else as its texts.

    Raises:
        DataError: when the file is binary, empty, has no header, another delimiter or lines of unequal length.
    """
    lines = _lines(path)
    names = _header(path, lines[0])
    _check_lengths(path, lines, len(names))
    rows = [line.split(",") if '"' not in line else next(csv.reader([line])) for line in lines[1:]]
    cells = [list(column) for column in zip(*rows, strict=True)] if rows else [[] for _ in names]
    return names, [_as_numbers(column) for column in cells], FIRST_ROW, None


def _as_numbers(cells: list[str]) -> Array | list[str]:
    try:
        # float() reads to the nearest float64, so that nothing is lost.
        return np.array(list(map(float, cells)), dtype=np.float64)
    except ValueError:
        return cells


def _lines(path: Path) -> list[str]:
    content = path.read_bytes()
    if not content.strip():
        raise DataError(path, "comma-separated values", "an empty file")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = content[: error.start].count(b"\n") + 1
        raise DataError(path, "text", f"bytes that are no UTF-8 (0x{content[error.start]:02x})", row) from None
    if (position := text.find("\0")) >= 0:
        raise DataError(path, "text", "a zero byte", text[:position].count("\n") + 1)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    while lines and not lines[-1].strip():
        lines.pop()
    return lines


def _header(path: Path, line: str) -> list[str]:
    # ROS and NumPy mark the header as a comment.
    names = [name.strip() for name in next(csv.reader([line.lstrip("%# ")], skipinitialspace=True), [])]
    if len(names) < 2:
        for delimiter, title in OTHER_DELIMITERS.items():
            if delimiter in line:
                raise DataError(path, "columns separated by commas", title, row=1)
        raise DataError(path, "two or more columns separated by commas", repr(line[:60]), row=1)
    if all(_is_number(name) for name in names):
        raise DataError(path, "column names in the first line", f"numbers ({line[:60]!r})", row=1)
    return names


def _check_lengths(path: Path, lines: Sequence[str], wanted: int) -> None:
    for position, line in enumerate(lines[1:]):
        count = line.count(",") + 1
        if count != wanted and '"' in line:
            count = len(next(csv.reader([line])))
        if count != wanted or not line.strip():
            last = " (the last line: the file may be cut off)" if position == len(lines) - 2 else ""
            found = f"{count} values" if line.strip() else "an empty line"
            raise DataError(path, f"{wanted} values, one per column", found + last, FIRST_ROW + position)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def write(path: Path, columns: Mapping[str, Array]) -> None:
    """Write columns ``# (rows,)`` with the shortest decimals that read back as the same float64."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*(map(repr, values.tolist()) for values in columns.values()), strict=True))
