"""What an experiment comes to: a table and the panels of a figure, beside what the paper says."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from sym2real.trajectory import Array


@dataclass(frozen=True)
class Line:
    """A curve with its spread.

    Args:
        x: ``# (points,)``.
        mean, spread: mean and standard deviation over seeds ``# (points,)``.
    """

    x: Array
    mean: Array
    spread: Array


@dataclass(frozen=True)
class Panel:
    """One case of the figure.

    Args:
        title: of the case.
        lines: by what they are called.
        level: of what a perfect model reaches; None where nobody asked.
        paper: what the paper says of it.
    """

    title: str
    lines: Mapping[str, Line]
    level: float | None = None
    paper: str = ""


@dataclass(frozen=True)
class Outcome:
    """The result of an experiment.

    Args:
        title: of the experiment.
        columns: of the table.
        rows: texts, one per column; empty strings repeat what stands above.
        notes: what the paper says, what the budget leaves undecided, what was not asked.
        x, y: what the panels show, with units.
        panels: of the figure.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()
    x: str = ""
    y: str = ""
    panels: tuple[Panel, ...] = field(default=())
