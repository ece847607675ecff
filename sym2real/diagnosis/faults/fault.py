"""Something wrong with the data: a transformation of its columns, its description, and sensors that report so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.mistakes.transformation import Transformation, mended
from sym2real.effects import compose, effect
from sym2real.effects.readings import SENSOR_SIGN
from sym2real.logs.sources import AsRead
from sym2real.symbolic import Equations


@dataclass(frozen=True)
class Fault:
    """Something wrong with the data: an entry of ``faults`` in docs/method.md, "Answers as files".

    Args:
        effect: key of the measurement effect that describes it; "" where none does.
        evidence: what shows it, one sentence; without an effect "what is wrong: what shows it".
        fix: what to change in the log, the driver or the sensor.
        value: of the effect's parameter, or of ``columns``; else None.
        sensor: whether a sensor is so, which a model of the robot has too; false for how a log is written, or when.
        columns: commands in no unit that is known; ``value`` is then what is logged over what is meant.
    """

    effect: str
    evidence: str
    fix: str = ""
    value: float | None = None
    sensor: bool = False
    columns: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """For a sentence: without an effect, what is reported before its figures."""
        if not self.effect:
            return self.evidence.partition(":")[0]
        without_value = self.value is None or self.effect.startswith(SENSOR_SIGN.name)
        return self.effect if without_value else f"{self.effect} ({self.value:.3g})"

    @property
    def sentence(self) -> str:
        """With the key of the effect that describes it."""
        return f"{self.effect}: {self.evidence}" if self.effect else self.evidence


@dataclass(frozen=True)
class Breach:
    """A transformation that logs ask for.

    Args:
        transformation: what was done.
        shown: what shows it, one clause.
        others: names of what would mend the logs as well, of other columns.
        log: place and name of the one log in which it is so; None where it is so in all.
    """

    transformation: Transformation
    shown: str
    others: tuple[str, ...] = ()
    log: tuple[int, str] | None = None

    @property
    def evidence(self) -> str:
        """What is wrong: what shows it."""
        where = "" if self.log is None else f" in {self.log[1]}, other than in other logs"
        return f"{', or '.join((self.transformation.name, *self.others))}{where}: {self.shown}"

    def fix(self, read: AsRead) -> str:
        """What to change, in the columns of the log."""
        return self.transformation.fix(read)

    def undone(self, data: Dataset) -> Dataset:
        """The logs as they are meant."""
        here = range(len(data)) if self.log is None else self.log[:1]
        return Dataset(mended(self.transformation, log) if place in here else log for place, log in enumerate(data))

    def in_log(self, data: Dataset, place: int) -> Breach:
        """As found in the log at this place alone."""
        return replace(self, log=(place, data[place].name))


Settled = tuple[Sequence[Fault], Dataset]  # what was wrong, and the logs without it


def with_sensors_of(equations: Equations, faults: Sequence[Fault]) -> Equations:
    """The equations with the sensors that were found wrong: they predict what these report.

    Args:
        equations: whose sensors are right, or report what the data were corrected to.
        faults: in the order in which they were undone.
    """
    for fault in reversed(faults):
        if fault.sensor and fault.value is not None:
            equations = compose(equations, [(effect(fault.effect, equations), {"value": fault.value})])
    return equations
