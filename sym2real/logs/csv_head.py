"""What stands above the rows of a text file, and its decimal marks."""

import csv
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate

from sym2real.logs.units import UNITS

# What parts cells, the likeliest last: a comma beside semicolons is a decimal one, beside tabs a letter of a name.
DELIMITERS = (";", "\t", "|", ",")
ROWS = 3  # lines of numbers in succession are rows
MARKS = "%# "  # of a comment, as which ROS and NumPy write the names
# Between semicolons, tabs or bars; the ends of a line are some only where there are others in it.
WITH_COMMA = re.compile(r"(?P<before>^|[;\t|]) *(?P<number>[+-]?\d+,\d+(?:[eE][+-]?\d+)?)(?= *(?:[;\t|]|$))")
WITH_POINT = re.compile(r"(?:^|[;\t|]) *[+-]?\d*\.\d+(?:[eE][+-]?\d+)? *(?:[;\t|]|$)")
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")


@dataclass(frozen=True)
class Head:
    """Names that stand in several lines, or below settings.

    Args:
        names: of the columns.
        lines: of the file above its first row.
        delimiter: what parts the cells of a row; None for blanks.
    """

    names: tuple[str, ...]
    lines: int
    delimiter: str | None


def is_number(text: str) -> bool:
    """Whether a cell holds a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def with_points(lines: list[str]) -> list[str]:
    """Lines with decimal points, where numbers that semicolons, tabs or bars part have commas and none has a point.

    Where all of these commas could part thousands they stay, and nobody takes such a cell for a number.
    """
    if not any(delimiter in lines[-1] for delimiter in DELIMITERS[:-1]):
        return lines
    numbers = [match["number"] for line in lines for match in WITH_COMMA.finditer(line)]
    if all(map(THOUSANDS.fullmatch, numbers)) or any(map(WITH_POINT.search, lines)):
        return lines
    return [
        WITH_COMMA.sub(lambda match: f"{match['before']}{match['number'].replace(',', '.')}", line) for line in lines
    ]


def head_of(lines: Sequence[str]) -> Head | None:
    """The names above the rows, where the first line alone does not have them.

    Motion capture, Betaflight's Explorer and data loggers write settings ahead of the names, and these in several
    lines: bodies, quantities, axes, units. The names are then the line above the first row, and as many lines above
    that as give each column a name of its own. No line of names has a number, and none has more cells than a row.
    """
    if len(lines) <= ROWS:
        return None
    delimiter = _delimiter_of_rows(lines[-2:])
    width = len(_cells(lines[-2], delimiter))
    if _are_names(_words(lines[0], delimiter), width) and not _are_units(_words(lines[1], delimiter)):
        return None  # the usual file
    places = range(len(lines) - ROWS + 1)
    first = next((i for i in places if all(_is_row(line, width, delimiter) for line in lines[i : i + ROWS])), 0)
    names, head = list[str](), None
    for line in reversed(lines[:first] if first > 1 else []):
        words = _words(line, delimiter)
        if any(words[width:]) or any(map(is_number, words)):
            break
        names = _joined(words, names) if names or len(words) == width else []
        if _are_names(names, width):
            head = Head(tuple(names), first, delimiter)
            if all(names):
                break
    return head


def _delimiter_of_rows(lines: Sequence[str]) -> str | None:
    """What parts these rows into most numbers."""
    return max(
        (*DELIMITERS, None), key=lambda mark: sum(is_number(cell) for line in lines for cell in _cells(line, mark))
    )


def _cells(line: str, delimiter: str | None) -> list[str]:
    """Cells of a line that may be no row, whatever its quotes."""
    try:
        return next(csv.reader([line], delimiter=delimiter), []) if delimiter and '"' in line else line.split(delimiter)
    except csv.Error:
        return line.split(delimiter)


def _words(line: str, delimiter: str | None) -> list[str]:
    """Cells of a line above the rows."""
    return [cell.strip() for cell in _cells(line.lstrip(MARKS), delimiter)]


def _is_row(line: str, width: int, delimiter: str | None) -> bool:
    cells = _cells(line, delimiter)
    return len(cells) == width and any(map(is_number, cells))


def _are_units(words: Sequence[str]) -> bool:
    """Whether a line has units and nothing else."""
    return any(words) and {*words} <= {"", *UNITS} and not any(map(is_number, words))


def _are_names(words: Sequence[str], width: int) -> bool:
    """Whether a line has a name for every column, all different and not all units; one may be without."""
    return len(words) == len({*words}) == width and not any(map(is_number, words)) and not _are_units(words)


def _joined(words: Sequence[str], names: Sequence[str]) -> list[str]:
    """Names with words of a line above them ahead, where an empty one goes by the last before it."""
    if not names:
        return list(words)
    last: Callable[[str, str], str] = lambda before, word: word or before  # noqa: E731
    carried = accumulate([*words, *[""] * len(names)], last)
    return [f"{word}.{name}".strip(".") for word, name in zip(carried, names, strict=False)]
