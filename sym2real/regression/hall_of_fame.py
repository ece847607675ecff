"""PySR's hall of fame: the best equation found at every complexity, and which of them to take."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import sympy

from sym2real.errors import DataError, ModelError, UnknownNameError
from sym2real.layout import Layouts
from sym2real.symbolic import Equations, complexity, parse_expression

HEADER = ("Complexity", "Loss", "Equation")
# PySR's rule "best": among the equations whose loss is at most 1.5 times the smallest, the one that gained most
# −ln(loss) per node over the next simpler one.
CLOSE_TO_BEST = 1.5
# Julia writes single precision numbers as 1.0f-5.
JULIA_FLOAT = re.compile(r"\b(\d+\.?\d*)[fF]([+-]?\d+)\b")


@dataclass(frozen=True)
class Entry:
    """One equation of a hall of fame: PySR's count of nodes, its loss, its text."""

    complexity: int
    loss: float
    equation: str


def best_entry(entries: Sequence[Entry]) -> Entry:
    """The equation that PySR's rule "best" selects.

    Raises:
        ModelError: when there is none with a finite loss.
    """
    ordered = sorted((entry for entry in entries if math.isfinite(entry.loss)), key=lambda entry: entry.complexity)
    if not ordered:
        raise ModelError("expected a hall of fame with at least one equation of finite loss, found none")
    limit = CLOSE_TO_BEST * min(entry.loss for entry in ordered)
    gains = [0.0, *(_gain(simpler, entry) for simpler, entry in pairwise(ordered))]
    return max(
        ((gain, entry) for gain, entry in zip(gains, ordered, strict=True) if entry.loss <= limit),
        key=lambda pair: pair[0],
    )[1]


def _gain(simpler: Entry, entry: Entry) -> float:
    if entry.loss <= 0.0:
        return math.inf
    if simpler.loss <= 0.0:
        return -math.inf
    return math.log(simpler.loss / entry.loss) / max(entry.complexity - simpler.complexity, 1)


def expression_of(entry: Entry, names: Sequence[str], nodes: int) -> sympy.Expr:
    """The equation as an expression over these names.

    Raises:
        UnknownNameError: when it uses another name.
        ModelError: when the text is not such an expression or has more than ``nodes`` nodes.
    """
    expression = parse_expression(JULIA_FLOAT.sub(r"\1e\2", entry.equation).replace("^", "**"), names)
    if complexity(expression) > nodes:
        raise ModelError(f"expected at most {nodes} nodes, found {complexity(expression)} in {entry.equation[:60]!r}")
    return expression


def read_hall_of_fame(path: str | Path) -> list[Entry]:
    """The entries of a CSV file that PySR wrote (``hall_of_fame.csv``, columns Complexity, Loss, Equation).

    Raises:
        DataError: when the file is not one.
    """
    path = Path(path)
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataError(path, "a readable CSV file", str(error)) from error
    if not rows:
        raise DataError(path, f"a header {','.join(HEADER)} and at least one equation", "no rows")
    return [_entry(path, number, row) for number, row in enumerate(rows, start=2)]


def _entry(path: Path, number: int, row: dict[str, str]) -> Entry:
    for column in HEADER:
        if row.get(column) is None:
            raise DataError(path, f"columns {', '.join(HEADER)}", ", ".join(map(str, row)), number, column)
    try:
        return Entry(int(row["Complexity"]), float(row["Loss"]), row["Equation"])
    except ValueError as error:
        raise DataError(path, "a whole number, a number and an equation", str(error), number) from error


def load_hall_of_fame(
    files: str | Path | Mapping[str, str | Path], layouts: Layouts, dt: float, nodes: int = 85
) -> Equations:
    """Equations of a PySR run made elsewhere, for the next value of every state column.

    Args:
        files: one file per state column, or the folder that holds ``<state column>.csv``.
        layouts: the columns that the equations may use, by name.
        dt: time step in s that they were fitted to.
        nodes: most nodes in an equation.

    Raises:
        DataError: when a file cannot be read.
        ModelError: when a column has no file, or an equation cannot be used.
    """
    if not isinstance(files, Mapping):
        files = {column: Path(files) / f"{column}.csv" for column in layouts.state}
    missing = [column for column in layouts.state if column not in files]
    if missing:
        raise ModelError(f"expected a hall of fame for every state column, found none for {', '.join(missing)}")
    names = (*layouts.state, *layouts.action, *layouts.inputs)
    expressions = {}
    for column in layouts.state:
        entry = best_entry(read_hall_of_fame(files[column]))
        try:
            expressions[column] = expression_of(entry, names, nodes)
        except (ModelError, UnknownNameError) as error:
            raise ModelError(f"{files[column]}, equation of {column!r}: {error}") from error
    notes = ("loaded from a PySR hall of fame; wrench effects on it are approximate",)
    return Equations(next=expressions, layouts=layouts, dt=dt, notes=notes)
