"""A proposal in the making: the logs, what has been found out so far, and the evidence for it."""

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from sym2real.logs.assignment import Assignment
from sym2real.logs.evidence import Rows
from sym2real.logs.parts import Attitude, Derived, Frames, Source, TimeBase, VelocityFrame
from sym2real.logs.specification import LogSpec
from sym2real.logs.table import Table
from sym2real.logs.units import factor, standard_unit
from sym2real.trajectory import Array
from sym2real.vocabulary import RATE

Confidence = Literal["certain", "likely", "guess", "unknown"]


@dataclass(frozen=True)
class Finding:
    """One line of an inspection.

    Args:
        column: column of the log, or "" for what concerns the whole log.
        meaning: standard column or what else it is.
        unit: unit in the log, "?" where it cannot be known.
        evidence: how one sees that.
        confidence: "certain", "likely", "guess" or "unknown".
    """

    column: str
    meaning: str
    unit: str
    evidence: str
    confidence: Confidence


@dataclass
class Draft:
    """What the inspection knows; each of its steps reads and adds.

    Args:
        tables: the logs, without the rows at their ends that are to be dropped.
        assignment: what the names say.
        rows: those that evidence is taken from, which all arrays below are of.
        time: the time base.
        drop_first: rows to drop.
        units: standard column → unit in the log.
        attitudes: attitudes found.
        heading: of one that stands alone, rad, turned as the path does ``# (rows,)``; None without one.
        world: measured attitude w x y z, body→world, z up, as far as it is known ``# (rows, 4)``.
        body_rates: angular velocity of that attitude ``# (rows, 3)``.
        acceleration: world acceleration by numeric differences ``# (rows, 2 or 3)``.
        held: columns that are slower than the others, whose last number stands until the next.
        kept: part of the rows that have a position of their own.
        reversed: columns whose sign is turned.
        flips: columns whose sign is suspected, with the evidence.
        comments: lines for the TOML text by the key that they follow.
    """

    tables: list[Table]
    assignment: Assignment
    held: tuple[str, ...]
    rows: Rows = field(init=False)
    kept: float = 1.0
    time: TimeBase = field(default_factory=TimeBase)
    drop_first: int = 0
    units: dict[str, str] = field(default_factory=dict)
    attitudes: dict[str, Attitude] = field(default_factory=dict)
    frames: Frames = "z_up"
    velocity_frame: VelocityFrame = "world"
    derived: list[Derived] = field(default_factory=list)
    heading: Array | None = None
    world: Array | None = None
    body_rates: Array | None = None
    acceleration: Array | None = None
    reversed: tuple[str, ...] = ()
    flips: dict[str, str] = field(default_factory=dict)
    left_out: set[str] = field(default_factory=set)
    findings: list[Finding] = field(default_factory=list)
    comments: dict[str, list[str]] = field(default_factory=dict)

    def raw(self, *columns: str) -> Array:
        """A column of the logs as it stands there ``# (rows,)``, or several side by side ``# (rows, k)``."""
        values = [self.rows.of([table.column(name, "in every log") for table in self.tables]) for name in columns]
        return values[0] if len(columns) == 1 else np.stack(values, axis=1)

    def reverse(self, *columns: str) -> None:
        """Turn the sign of columns, here and in the specification."""
        self.reversed += columns
        self.tables = [table.with_columns({name: -table.columns[name] for name in columns}) for table in self.tables]

    def has(self, *standard: str) -> bool:
        """Whether every one of these standard columns has been found."""
        return all(name in self.assignment.columns and name not in self.left_out for name in standard)

    def column(self, standard: str) -> str:
        """The log's column for a standard one."""
        return self.assignment.columns[standard]

    def values(self, *standard: str) -> Array:
        """Standard columns in the log's own unit, axes and signs, shaped as :meth:`raw`."""
        return self.raw(*map(self.column, standard))

    def named_unit(self, *names: str) -> str:
        """The unit that the name of one of these states, standard columns or columns of the log, or ""."""
        columns = (self.assignment.columns.get(name, name) for name in names)
        return next(filter(None, map(self.assignment.unit, columns)), "")

    def series(self, standard: str) -> Array:
        """A standard column in its SI unit as far as that is known, axes and signs as in the log."""
        return factor(self.units.get(standard, ""), standard) * self.values(standard)

    @property
    def turning(self) -> dict[str, Array]:
        """Body rates in rad/s ``# (rows,)`` by their columns, as attitude or heading have them; none without these."""
        if self.body_rates is not None:
            return dict(zip(RATE.columns, self.body_rates.T, strict=True))
        return {} if self.heading is None else {RATE.columns[2]: self.rows.slopes(np.unwrap(self.heading))}

    def add(self, column: str, meaning: str, unit: str, evidence: str, confidence: Confidence) -> None:
        """File one finding."""
        self.findings.append(Finding(column, meaning, unit, evidence, confidence))

    def settle(self, standard: str, unit: str, evidence: str, confidence: Confidence) -> None:
        """File what a standard column holds; the specification names its unit where it is not the usual one."""
        self.units[standard] = "" if unit == standard_unit(standard) else unit
        self.add(self.column(standard), standard, unit, evidence, confidence)

    def leave_open(self, standard: str, meaning: str, evidence: str, worth: str) -> None:
        """File a standard column whose unit the log cannot know; the text has a line with its worth to fill in."""
        column = self.column(standard)
        self.left_out.add(standard)
        self.add(column, meaning, "?", evidence, "unknown")
        self.comment("columns", f'{standard} = {{ column = "{column}", {worth}')

    def suspect(self, column: str, evidence: str) -> None:
        """File a column whose sign looks reversed; it stays as recorded."""
        self.flips[column] = evidence
        self.add(column, "sign suspected to be reversed", "", evidence, "likely")

    def comment(self, key: str, *lines: str) -> None:
        """Lines that follow a key of the TOML text, commented out."""
        self.comments.setdefault(key, []).extend(lines)

    def specification(self) -> LogSpec:
        """What is known, as a specification, its columns in the order of the log."""
        place = {column: i for i, column in enumerate(self.tables[0].columns)}
        ordered = sorted(self.assignment.columns.items(), key=lambda item: place[item[1]])
        columns = {name: Source(c, self.units.get(name, "")) for name, c in ordered if name not in self.left_out}
        attitudes: dict[str, Any] = {**self.attitudes}
        spec = LogSpec(
            "proposed",
            time=self.time,
            columns=columns,
            drop_first=self.drop_first,
            flip=self.reversed,
            derive=tuple(self.derived),
            velocity_frame=self.velocity_frame,
            frames=self.frames,
            **attitudes,
        )
        # A column whose unit cannot be known stands in no line, or in one that is still to be taken.
        return replace(spec, hold=tuple(name for name in self.held if name in spec.sources))

    @property
    def waiting(self) -> list[str]:
        """Columns to be held once the lines that have them are taken."""
        return sorted(self.column(name) for name in self.left_out if self.column(name) in self.held)
