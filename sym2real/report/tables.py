"""Tables for the terminal."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import sympy
from rich import box
from rich.markup import escape
from rich.table import Column, Table

from sym2real.layout import unit_of_place
from sym2real.symbolic import Equations

if TYPE_CHECKING:
    from sym2real.adaptation import EpisodeReport
    from sym2real.experiments.flying import Flight
    from sym2real.logs import Inspection
    from sym2real.regression import Dependence
    from sym2real.robots import Robot

MOST_NAMED = 6  # columns in a row of an inspection; a message has dozens of covariances
CONFIDENCE = {"certain": "green", "likely": "cyan", "guess": "yellow", "unknown": "red"}


def number(value: float, digits: int = 3) -> str:
    """A figure with so many significant digits, a dash where there is none."""
    return "–" if math.isnan(value) else f"{value:.{digits}g}"


def decimals(value: float, places: int) -> str:
    """A figure with so many decimals, a dash where there is none."""
    return "–" if math.isnan(value) else f"{value:.{places}f}"


def table_of(
    title: str, headings: Sequence[str], rows: Iterable[Sequence[str]], left: Collection[str] = (), **options: Any
) -> Table:
    """A table of figures, but for the columns of words, which stand on the left; options as of rich's own."""
    columns = (Column(heading, justify="left" if heading in left else "right", overflow="fold") for heading in headings)
    table = Table(*columns, title=title, title_justify="left", **options)
    for row in rows:
        table.add_row(*row)
    return table


def compact_table(
    title: str, headings: Sequence[str] = (), rows: Iterable[Sequence[str]] = (), left: Collection[str] = ()
) -> Table:
    """Without rules between columns: four channels with two figures each stay within 80 columns."""
    return table_of(title, headings, rows, left, box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))


def equation_table(equations: Equations) -> Table:
    """One row per next-state component: its nodes, and its text with numbers to four digits."""
    nodes, headings = equations.complexity(), ("state", "nodes", "equation")
    rows = [(name, "", readable(expression)) for name, expression in equations.quantities.items()]
    rows += [(f"{name}′", str(nodes[name]), readable(expression)) for name, expression in equations.next.items()]
    title = f"next state after {equations.dt:g} s"
    return table_of(title, headings, rows, left=("state", "equation"), show_lines=True)


def interface_lines(equations: Equations) -> list[str]:
    """What equations predict from what, every how many seconds, and with which numbers, a line each."""
    layouts = equations.layouts
    groups = (("predicts", layouts.state), ("from", layouts.action), ("takes, where a log has them,", layouts.inputs))
    lines = [f"every {equations.dt:g} s"]
    lines += [f"{what} {', '.join(layout)}" for what, layout in groups if layout.size]
    numbers = ", ".join(f"{name} {number(value, 4)}" for name, value in equations.numbers.items())
    return [*lines, f"numbers (SI): {numbers}"] if numbers else lines


def columns_table(robot: Robot) -> Table:
    """What a log of a robot holds beside the time, and the limits of its commands."""
    rows = [(column, unit, "measured") for column, unit in robot.layouts.state.units.items()]
    for (column, unit), low, high in zip(robot.layouts.action.units.items(), robot.low, robot.high, strict=True):
        rows.append((column, unit, f"commanded, from {number(low)} to {number(high)}"))
    return compact_table("", ("column", "unit", ""), rows, left=("column", "unit", ""))


def rounded(expression: sympy.Expr) -> sympy.Expr:
    """An expression with its numbers to four digits."""
    with sympy.evaluate(False):
        return expression.xreplace({value: sympy.Float(value, 4) for value in expression.atoms(sympy.Float)})


def readable(expression: sympy.Expr) -> str:
    """An expression with its numbers rounded to four digits."""
    with sympy.evaluate(False):
        return str(sympy.sstr(rounded(expression), full_prec=False))


def inspection_table(inspection: Inspection) -> Table:
    """What logs seem to hold: a row for neighbouring columns that share unit and evidence, and rows on the whole."""
    headings = ("column", "what it seems to be", "unit", "evidence", "confidence")
    rows = []
    for (unit, evidence, confidence), same in groupby(
        inspection.rows, lambda row: (row.unit, row.evidence, row.confidence)
    ):
        columns, meanings = zip(*((row.column, row.meaning) for row in same), strict=True)
        named = columns if len(columns) <= MOST_NAMED else (columns[0], "…", f"{columns[-1]} ({len(columns)} columns)")
        texts = (", ".join(filter(None, named)), ", ".join(dict.fromkeys(meanings)), unit, evidence)
        rows.append((*map(escape, texts), f"[{CONFIDENCE[confidence]}]{confidence}[/]"))
    title = ", ".join(path.name for path in inspection.paths)
    return table_of(title, headings, rows, left=headings, show_lines=True)


def dependence_table(rows: Sequence[Dependence]) -> Table:
    """How strongly each action reaches the states that it must reach."""
    headings = ("action", "state", "strength", "bar", "", "strength is")
    cells = []
    for row in rows:
        verdict = "[green]yes[/]" if row.holds else "[red]no[/]"
        names = (escape(row.action), f"{escape(row.state)}′")
        cells.append((*names, number(row.score), number(row.bar), verdict, escape(row.meaning)))
    title = "does each action reach the states it must?"
    return table_of(title, headings, cells, left=("action", "state", "", "strength is"))


def episode_table(reports: Sequence[EpisodeReport]) -> Table:
    """One row per episode of Stage I."""
    tracking = f"tracking {reports[0].unit if reports else ''}"
    headings = ("episode", "flown", "rows", "crashes", tracking, "one-step error", "after fit", "fit s")
    rows = []
    for report in reports:
        sizes = (report.tracking, report.prediction, report.fitted, report.seconds)
        rows.append((str(report.number + 1), report.task, str(report.rows), str(report.crashes), *map(number, sizes)))
    return table_of("episodes in the plain simulator", headings, rows, left=("flown",))


def flight_table(flight: Flight, plant: str) -> Table:
    """How well a flight or drive in a plant tracked, and how long choosing an action took."""
    unit = unit_of_place(flight.trajectory.layouts.state)
    headings = ("task", "ended", f"mean error {unit}", f"last second {unit}", "action median ms", "p99 ms")
    sizes = (flight.tracking, flight.final, 1e3 * flight.act_median, 1e3 * flight.act_p99)
    row = (flight.trajectory.name, "by a crash" if flight.crashed else "in time", *map(number, sizes))
    return table_of(f"flown in the {plant}", headings, [row], left=("task", "ended"))
