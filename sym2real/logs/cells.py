"""Cells of a column as numbers: decimals, dates, and what stands where there is none."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np

from sym2real.logs.csv_head import is_number
from sym2real.trajectory import Array

if TYPE_CHECKING:
    from sym2real.logs.table import Table

SHOWN = 40  # letters of a cell in an error
NO_NUMBER = frozenset({"", "nan", "na", "null", "none"})


def numbers(table: Table, name: str, cells: Array | Sequence[str]) -> Array | None:
    """Cells as numbers ``# (rows,)``, dates as seconds; None where the column holds text throughout.

    Raises:
        DataError: naming the first cell that is no number in a column of numbers.
    """
    if isinstance(cells, np.ndarray):
        return cells
    with suppress(ValueError):
        if not any("_" in cell for cell in cells):  # float() reads to the nearest float64, so that nothing is lost
            return np.array(list(map(float, cells)), dtype=np.float64)
    values = np.full(len(cells), np.nan)
    bad = []
    for position, cell in enumerate(cells):
        try:
            values[position] = np.nan if cell.strip().lower() in NO_NUMBER else _number(cell)
        except ValueError:
            bad.append(position)
    if bad and all(_has_decimal_comma(cells[position]) for position in bad):
        raise table.error("a number with a decimal point", f"{_short(cells[bad[0]])}, a decimal comma", bad[0], name)
    if len(bad) > len(cells) // 2:
        return _dates(cells)
    if bad:
        raise table.error("a number", _short(cells[bad[0]]), bad[0], name)
    return values


def _dates(cells: Sequence[str]) -> Array | None:
    """Dates with times by ISO 8601 in s since 1970, of Greenwich where they name no zone; None where one is none."""
    with suppress(ValueError):
        return np.array([_moment(cell.strip()) for cell in cells])
    return None


def _moment(cell: str) -> float:
    if cell.lower() in NO_NUMBER:
        return np.nan
    if ":" not in cell:  # a day alone, or a week, is a name
        raise ValueError(cell)
    date = datetime.fromisoformat(cell)
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()


def _number(cell: str) -> float:
    if "_" in cell:  # Python takes 1_0 for ten, which no other program writes or reads
        raise ValueError(cell)
    return float(cell)


def _has_decimal_comma(cell: str) -> bool:
    return "," in cell and is_number(cell.replace(",", ".", 1))


def _short(cell: str) -> str:
    return repr(cell) if len(cell) <= SHOWN else f"{cell[:SHOWN]!r} … ({len(cell)} letters)"
