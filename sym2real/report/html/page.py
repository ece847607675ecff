"""A page as data: sections of parts."""

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup
from rich.table import Table

from sym2real.report.charts import Chart
from sym2real.report.html.variants import Switch
from sym2real.trajectory import Array


@dataclass(frozen=True)
class Errors:
    """Errors of the switched model, which the page's script fills in: channel, unit, its own, floor and "hold".

    Its own are those of every combination of switches ``# (B, horizons)``, of which one horizon is shown.
    """

    title: str
    rows: Sequence[tuple[str, str, Array, float, float]]
    horizon: int


@dataclass(frozen=True)
class Figures:
    """Charts; with a log to choose and a slider through time where they are of one log."""

    title: str
    charts: Sequence[Chart]
    reading: str = ""


@dataclass(frozen=True)
class Lines:
    """Sentences."""

    title: str
    lines: Sequence[str]


@dataclass(frozen=True)
class Card:
    """One effect: its name, what it is, label and text of what is known of it, and the part of the error it removes."""

    name: str
    about: str
    facts: Sequence[tuple[str, str]]
    share: float


@dataclass(frozen=True)
class Cards:
    """Effects that the model lacks."""

    cards: Sequence[Card]


@dataclass(frozen=True)
class Formula:
    """An equation: what it gives, and its text before and after; either may be empty."""

    name: str
    before: Markup
    after: Markup


@dataclass(frozen=True)
class Formulas:
    """Equations; folded away where ``folded``."""

    title: str
    formulas: Sequence[Formula]
    reading: str = ""
    folded: bool = False


Part = Table | Errors | Figures | Lines | Cards | Formulas


@dataclass(frozen=True)
class Section:
    """The answer to one question."""

    key: str
    question: str
    parts: Sequence[Part]


@dataclass(frozen=True, eq=False)
class Page:
    """All of a report.

    Args:
        title: heading.
        verdict: one word; "" where there is none.
        summary: the answer in a sentence.
        facts: label and text of what was looked at.
        sections: in the order in which people ask.
        switches: what can be added.
        logs: names and lengths in s, where charts are of one log.
    """

    title: str
    summary: str
    sections: Sequence[Section]
    verdict: str = ""
    facts: Sequence[tuple[str, str]] = ()
    switches: Sequence[Switch] = ()
    logs: Sequence[tuple[str, float]] = ()
