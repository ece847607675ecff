"""Faults of the data that are settled before any search: signs of rates, time step, saturation."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch

from sym2real.diagnosis.agreement import REVERSED, rate_agreement
from sym2real.effects import effect
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset, Trajectory

SATURATED = 0.05
DT_TOLERANCE = 0.02


@dataclass(frozen=True)
class Fault:
    """Something wrong with the data.

    Args:
        effect: key of the measurement effect that describes it; "" where none does.
        evidence: what shows it, one sentence.
    """

    effect: str
    evidence: str

    def to_dict(self) -> dict[str, str]:
        return {"effect": self.effect, "evidence": self.evidence}


@dataclass(frozen=True, eq=False)
class Checked:
    """Data with its faults undone, and remarks.

    Args:
        data: corrected logs.
        faults: what was undone.
        notes: what was seen and left as it is.
    """

    data: Dataset
    faults: tuple[Fault, ...]
    notes: tuple[str, ...]


def check(model: Equations, data: Dataset) -> Checked:
    """Find and undo what no model can explain."""
    faults = rate_signs(data)
    for fault in faults:
        wrong = effect(fault.effect, replace_layouts(model, data))
        data = Dataset(_corrected(trajectory, wrong) for trajectory in data)
    return Checked(data, faults, (*_time_step(model, data), *_saturation(data)))


def replace_layouts(model: Equations, data: Dataset) -> Equations:
    """The model itself: its state columns are the data's."""
    return model if model.layouts.state == data.layouts.state else replace(model, layouts=data.layouts)


def _corrected(trajectory: Trajectory, wrong) -> Trajectory:  # type: ignore[no-untyped-def]
    state = wrong.correct(torch.as_tensor(trajectory.state), {"value": -1.0}).numpy()
    return replace(trajectory, state=state)


def rate_signs(data: Dataset) -> tuple[Fault, ...]:
    """Body rates whose sign contradicts the attitude's derivative."""
    return tuple(
        Fault(f"sensor_sign:{column}", f"the logged {column} and the attitude's derivative correlate by {found:.3f}")
        for column, agreement in rate_agreement(list(data)).items()
        if (found := agreement.correlation) is not None and found < REVERSED
    )


def _time_step(model: Equations, data: Dataset) -> tuple[str, ...]:
    if abs(data.dt - model.dt) <= DT_TOLERANCE * model.dt:
        return ()
    return (f"the model's time step is {model.dt:g} s, the logs have {data.dt:g} s",)


def _saturation(data: Dataset) -> tuple[str, ...]:
    notes = []
    for column in data.layouts.action:
        values = np.concatenate([trajectory.column(column) for trajectory in data])
        for edge, name in ((values.max(), "largest"), (values.min(), "smallest")):
            share = float((values == edge).mean())
            if share > SATURATED and values.std() > 0:
                notes.append(f"{column} is at its {name} value {edge:g} in {100 * share:.0f} % of the rows")
    return tuple(notes)
