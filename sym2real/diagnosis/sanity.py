"""Faults of the data that are settled before any search: signs of rates, time step, saturation."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch

from sym2real import rotation
from sym2real.effects import effect
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Dataset, Trajectory

RATES = ("wx", "wy", "wz")
# Rows over which a rate and the attitude's derivative are averaged before they are compared.
SMOOTHING = 5
# Correlation that shows a wrong sign, and the rate (rad/s) that must be there to look at it.
WRONG_SIGN, LEAST_RATE = -0.5, 0.05
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
    faults = []
    for column in RATES:
        if column not in data.layouts.state:
            continue
        pairs = [_rate_and_derivative(trajectory, column) for trajectory in data]
        logged, turned = (np.concatenate([pair[i] for pair in pairs]) for i in (0, 1))
        if min(logged.std(), turned.std()) < LEAST_RATE:
            continue
        correlation = float(np.corrcoef(logged, turned)[0, 1])
        if correlation < WRONG_SIGN:
            evidence = f"the logged {column} and the attitude's derivative correlate by {correlation:.3f}"
            faults.append(Fault(f"sensor_sign:{column}", evidence))
    return tuple(faults)


def _rate_and_derivative(trajectory: Trajectory, column: str) -> tuple[Array, Array]:
    layout = trajectory.layouts.state
    kernel = np.ones(SMOOTHING) / SMOOTHING
    rate = trajectory.column(column)
    middle = (rate[1:] + rate[:-1]) / 2
    if layout.has_field("attitude"):
        attitude = torch.as_tensor(trajectory.state[:, layout.slice("attitude")])
        turns = rotation.logarithm(rotation.multiply(rotation.conjugate(attitude[:-1]), attitude[1:])).numpy()
        turn = turns[:, RATES.index(column)]
    elif layout.has_field("heading") and column == "wz":
        sine, cosine = (trajectory.column(name) for name in ("sin_yaw", "cos_yaw"))
        turn = np.diff(np.unwrap(np.arctan2(sine, cosine)))
    else:
        return np.zeros(0), np.zeros(0)
    return np.convolve(middle, kernel, "valid"), np.convolve(turn / np.diff(trajectory.time), kernel, "valid")


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
