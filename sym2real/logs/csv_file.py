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
BLACKBOX, BLACKBOX_HEADER = "Product,Blackbox", "loopIteration,"
SHOWN = 60  # letters of a line in an error
LONGEST_NAME = 200  # letters of a column's name


def read(path: Path) -> tuple[list[str], list[Array | Sequence[str]], int, None]:
    """Column names, cells by column, the line of the first row, and no metadata.

    A column of numbers comes as an array, one that holds anything else as its texts.

    Raises:
        DataError: when the file is binary, empty, has no header, another delimiter or lines of unequal length.
    """
    lines = _lines(path)
    ahead = _preamble(lines)
    lines, first = lines[ahead:], FIRST_ROW + ahead
    names = _header(path, lines[0])
    rows = [_cells(path, line, first + i) for i, line in enumerate(lines[1:])]
    _check_lengths(path, lines, rows, len(names), first)
    cells = [list(column) for column in zip(*rows, strict=True)] if rows else [[] for _ in names]
    # Python takes 1_0 for ten, which no other program writes or reads.
    underscored = any("_" in line for line in lines[1:])
    return names, [_as_numbers(column, underscored) for column in cells], first, None


def _preamble(lines: Sequence[str]) -> int:
    """Lines ahead of the header: Betaflight's Blackbox Explorer writes the flight controller's settings there."""
    if not lines[0].replace('"', "").startswith(BLACKBOX):
        return 0
    headers = (i for i, line in enumerate(lines) if line.replace('"', "").startswith(BLACKBOX_HEADER))
    return next(headers, 0)


def _cells(path: Path, line: str, row: int, *, skip_spaces: bool = False) -> list[str]:
    if '"' not in line:
        return line.split(",")
    try:
        return next(csv.reader([line], strict=True, skipinitialspace=skip_spaces), [])
    except csv.Error as error:
        words = f"{error} ({line[:SHOWN]!r})"
        raise DataError(path, "quotes that are closed in the same line, and short cells", words, row) from None


def _as_numbers(cells: list[str], underscored: bool) -> Array | list[str]:
    try:
        # float() reads to the nearest float64, so that nothing is lost.
        values = np.array(list(map(float, cells)), dtype=np.float64)
    except ValueError:
        return cells
    return cells if underscored and any("_" in cell for cell in cells) else values


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
    names = [name.strip() for name in _cells(path, line.lstrip("%# "), 1, skip_spaces=True)]
    if len(names) < 2:
        for delimiter, title in OTHER_DELIMITERS.items():
            if delimiter in line:
                raise DataError(path, "columns separated by commas", title, row=1)
        raise DataError(path, "two or more columns separated by commas", repr(line[:SHOWN]), row=1)
    if too_long := next((name for name in names if len(name) > LONGEST_NAME), ""):
        found = f"{len(too_long)} ({too_long[:SHOWN]!r} …)"
        raise DataError(path, f"column names of at most {LONGEST_NAME} letters", found, row=1)
    if all(_is_number(name) for name in names):
        raise DataError(path, "column names in the first line", f"numbers ({line[:SHOWN]!r})", row=1)
    return names


def _check_lengths(path: Path, lines: Sequence[str], rows: Sequence[list[str]], wanted: int, first: int) -> None:
    for position, cells in enumerate(rows):
        empty = not lines[position + 1].strip()
        if len(cells) != wanted or empty:
            last = " (the last line: the file may be cut off)" if position == len(rows) - 1 else ""
            found = "an empty line" if empty else f"{len(cells)} values"
            raise DataError(path, f"{wanted} values, one per column", found + last, first + position)


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
