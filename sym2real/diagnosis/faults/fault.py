"""Something wrong with the data, and the equations that predict what such sensors report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sym2real.dataset import Dataset
from sym2real.effects import compose, effect
from sym2real.effects.sensor_sign import SENSOR_SIGN
from sym2real.symbolic import Equations


@dataclass(frozen=True)
class Fault:
    """Something wrong with the data.

    Args:
        effect: key of the measurement effect that describes it; "" where none does.
        evidence: what shows it, one sentence; without an effect "what is wrong: what shows it".
        fix: what to change in the log, the driver or the sensor.
        value: of the effect's parameter; None where there is no effect.
        sensor: whether a sensor is so, which a model of the robot has too; false for how a log is written, or when.
    """

    effect: str
    evidence: str
    fix: str = ""
    value: float | None = None
    sensor: bool = False

    @property
    def name(self) -> str:
        """For a sentence: without an effect, what is told before its figures."""
        if not self.effect:
            return self.evidence.partition(":")[0]
        without_value = self.value is None or self.effect.startswith(SENSOR_SIGN.name)
        return self.effect if without_value else f"{self.effect} ({self.value:.3g})"

    @property
    def sentence(self) -> str:
        """With the key of the effect that describes it."""
        return f"{self.effect}: {self.evidence}" if self.effect else self.evidence

    def to_dict(self) -> dict[str, str | float | bool | None]:
        """The entry of ``faults`` in docs/method.md, "Answers as files"."""
        return dict(vars(self))


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
