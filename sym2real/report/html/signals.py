"""States as people read them in a chart: angles instead of quaternions and points on a circle."""

import numpy as np
import torch

from sym2real import rotation
from sym2real.field import Field
from sym2real.layout import Layout
from sym2real.trajectory import Array
from sym2real.vocabulary import EULER_ANGLES


def signal_units(layout: Layout) -> dict[str, str]:
    """Name and unit of every signal, in the order of the state's fields."""
    return {name: unit for field in layout.fields for name, unit in _units(field).items()}


def _units(field: Field) -> dict[str, str]:
    if field.kind == "quaternion":
        return dict.fromkeys(EULER_ANGLES, "rad")
    if field.kind == "circle":
        return {"yaw": "rad"}
    return dict.fromkeys(field.columns, field.unit)


def signals(layout: Layout, states: Array) -> Array:
    """Values ``# (..., signals)`` of states ``# (..., state)``; angles lie within ± π."""
    return np.concatenate([_values(field, states[..., layout.slice(field.name)]) for field in layout.fields], axis=-1)


def _values(field: Field, columns: Array) -> Array:
    if field.kind == "quaternion":
        return rotation.to_euler(torch.as_tensor(columns)).numpy()
    if field.kind == "circle":
        return np.arctan2(columns[..., :1], columns[..., 1:])
    return columns


def unwrapped(layout: Layout, measured: Array, predicted: Array) -> tuple[Array, Array]:
    """Signals along a log without jumps of a whole turn, and predicted ones on the turn of the measured.

    Args:
        layout: of the states.
        measured: signals ``# (rows, signals)``.
        predicted: signals of the same rows ``# (..., rows, signals)``.
    """
    turning = [place for place, name in enumerate(signal_units(layout)) if name in EULER_ANGLES]
    measured, predicted = measured.copy(), predicted.copy()
    away = predicted[..., turning] - measured[:, turning]
    measured[:, turning] = np.unwrap(measured[:, turning], axis=0)
    predicted[..., turning] = measured[:, turning] + np.arctan2(np.sin(away), np.cos(away))
    return measured, predicted
