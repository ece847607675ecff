"""Strict reading of CSV files, and writing that keeps every bit of a float64."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

from sym2real.errors import DataError
from sym2real.logs.csv_head import DELIMITERS, MARKS, head_of, is_number, with_points
from sym2real.trajectory import Array

SHOWN = 60  # letters of a line in an error
LONGEST_NAME = 200  # letters of a column's name


def read(path: Path, header: Sequence[str] = ()) -> tuple[list[str], list[Array | Sequence[str]], int, dict[str, str]]:
    """Column names, cells by column, the line of the first row, and no metadata.

    Commas, semicolons, tabs, bars or blanks part the cells.

    Args:
        path: of the file.
        header: names of the columns of a file that has none.

    Raises:
        DataError: when the file is binary, empty, has no header or one too many, or lines of unequal length.
    """
    lines = with_points(_lines(path))
    head = None if header else head_of(lines)
    if head is None:
        delimiter, ahead = _delimiter(lines), int(not header)
        names = _header(path, lines[0], delimiter, named=bool(header))
        if header:
            _check_header(path, names, header)
            names = list(header)
    else:
        names, delimiter, ahead = list(head.names), head.delimiter, head.lines
    lines, first = lines[ahead:], 1 + ahead
    rows = [_cells(path, line, first + i, delimiter) for i, line in enumerate(lines)]
    _check_lengths(path, lines, rows, len(names), first)
    cells = [list(column) for column in zip(*rows, strict=True)] if rows else [[] for _ in names]
    # The index that pandas writes counts rows from 0.
    if rows and not names[0] and all(is_number(cell) and float(cell) == row for row, cell in enumerate(cells[0])):
        names, cells = names[1:], cells[1:]
    if not names[-1] and not any(cells[-1]):  # every line ends with a delimiter
        names, cells = names[:-1], cells[:-1]
    return names, [*cells], first, {}


def first_cells(path: Path) -> list[str]:
    """The names of the columns, or numbers where the file names none.

    Raises:
        DataError: as of :func:`read`.
    """
    lines = with_points(_lines(path))
    head = head_of(lines)
    return list(head.names) if head else _header(path, lines[0], _delimiter(lines), named=True)


def _delimiter(lines: Sequence[str]) -> str | None:
    """What parts the first line into as many cells as the second; None for blanks."""
    first, second = (line.strip() for line in (lines[0], lines[min(1, len(lines) - 1)]))
    for delimiter in DELIMITERS:
        if first.count(delimiter) == second.count(delimiter) > 0:
            return delimiter
    there = next((delimiter for delimiter in DELIMITERS[::-1] if delimiter in first), None)
    return there if there or len(first.split()) > 1 else ","


def _cells(path: Path, line: str, row: int, delimiter: str | None, *, skip_spaces: bool = False) -> list[str]:
    if delimiter is None or '"' not in line:
        return line.split(delimiter)
    try:
        reader = csv.reader([line], delimiter=delimiter, strict=True, skipinitialspace=skip_spaces)
        return next(reader, [])
    except csv.Error as error:
        words = f"{error} ({line[:SHOWN]!r})"
        raise DataError(path, "quotes that are closed in the same line, and short cells", words, row) from None


def _lines(path: Path) -> list[str]:
    content = path.read_bytes()
    if not content.strip():
        raise DataError(path, "comma-separated values", "an empty file")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = content[: error.start].count(b"\n") + 1
        actual = f"bytes that are no UTF-8 (0x{content[error.start]:02x}): save the file as UTF-8"
        raise DataError(path, "text", actual, row) from None
    if (position := text.find("\0")) >= 0:
        raise DataError(path, "text", "a zero byte", text[:position].count("\n") + 1)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    while lines and not lines[-1].strip():
        lines.pop()
    return lines


def _header(path: Path, line: str, delimiter: str | None, *, named: bool) -> list[str]:
    """Cells of the first line; ``named`` is whether they need not be names."""
    names = [name.strip() for name in _cells(path, line.lstrip(MARKS), 1, delimiter, skip_spaces=True)]
    if len(names) < 2:
        raise DataError(path, "two or more columns, parted by commas", repr(line[:SHOWN]), row=1)
    if too_long := next((name for name in names if len(name) > LONGEST_NAME), ""):
        actual = f"{len(too_long)} ({too_long[:SHOWN]!r} …)"
        raise DataError(path, f"column names of at most {LONGEST_NAME} letters", actual, row=1)
    if not named and all(is_number(name) for name in names):
        expected = "column names in the first line (--columns names those of a file without)"
        raise DataError(path, expected, f"numbers ({line[:SHOWN]!r})", row=1)
    return names


def _check_header(path: Path, first: Sequence[str], header: Sequence[str]) -> None:
    if not all(is_number(cell) or not cell for cell in first):
        raise DataError(path, "numbers in the first line, where names of the columns are given", repr(first), row=1)
    if len(first) != len(header):
        actual = f"{len(header)} ({', '.join(header)})"
        raise DataError(path, f"names of its {len(first)} columns", actual, row=1)


def _check_lengths(path: Path, lines: Sequence[str], rows: Sequence[list[str]], wanted: int, first: int) -> None:
    for position, cells in enumerate(rows):
        empty = not lines[position].strip()
        if len(cells) != wanted or empty:
            last = " (the last line: the file may be cut off)" if position == len(rows) - 1 else ""
            actual = "an empty line" if empty else f"{len(cells)} values"
            raise DataError(path, f"{wanted} values, one per column", actual + last, first + position)


def write(path: Path, columns: Mapping[str, Array]) -> None:
    """Write columns ``# (rows,)`` with the shortest decimals that read back as the same float64."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*(map(repr, values.tolist()) for values in columns.values()), strict=True))
