"""What a person would say of a moment in a flight or drive: how fast, how high, how tilted, how late in the log."""

from collections.abc import Mapping

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from sym2real import rotation
from sym2real.layout import Layout
from sym2real.logs import derive
from sym2real.logs.pose import attitude, attitudes
from sym2real.logs.standard import INVERSE
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import (
    ATTITUDE,
    BATTERY,
    HEADING,
    HEIGHT,
    POSITION,
    RATE,
    SPEED_COLUMN,
    STEER_COLUMN,
    THRUST,
    THRUST_COLUMN,
    VELOCITY,
)

HOW_FAST = "speed"  # how fast the robot is, whatever is commanded
WHERE = "position "  # with the axis: where it is, which on a path that repeats goes with all else
CHANGE_OF = "change of "  # with the command: how fast it changes
UNITS = {
    "height": "m",
    HOW_FAST: "m/s",
    "tilt": "rad",
    "body rate": "rad/s",
    THRUST.name: THRUST.unit,
    "steering": "rad",
    "speed command": "m/s",
    "distance from the reference": "m",
    "time": "s",
    "battery": "V",
}
DIRECT = {
    HEIGHT: "height",
    THRUST_COLUMN: THRUST.name,
    STEER_COLUMN: "steering",
    SPEED_COLUMN: "speed command",
    BATTERY.columns[0]: "battery",
}
NORMS = {HOW_FAST: VELOCITY.columns, "body rate": RATE.columns}
TILTED = ATTITUDE.columns[1:3]
Region = Mapping[str, tuple[float, float]]


def units_of(layout: Layout) -> dict[str, str]:
    """Unit of every feature that logs with this state may have; of two that say the same, the first one is named.

    Beside those of :data:`UNITS` where a joint is, by its name, and how fast it moves, ``|J_rate|``.
    """
    places = {joint: layout.units[joint] for joint in layout.joints}
    paces = {_pace(layout.rates[joint]): layout.units[layout.rates[joint]] for joint in layout.joints}
    return {**places, **paces, **UNITS}


def _pace(rate: str) -> str:
    return f"|{rate}|"


def features(trajectory: Trajectory) -> dict[str, Array]:
    """Features of every row by name, in the units of :func:`units_of`, ``# (rows,)`` each."""
    layouts = trajectory.layouts
    known = {*layouts.state, *layouts.action, *layouts.inputs, *trajectory.extra}
    values = {name: trajectory.column(column) for column, name in DIRECT.items() if column in known}
    for name, columns in NORMS.items():
        there = [trajectory.column(column) for column in columns if column in layouts.state]
        if there:
            values[name] = np.linalg.norm(there, axis=0)
    if layouts.state.has_field("attitude"):
        values["tilt"] = rotation.tilt(attitude(trajectory)).numpy()
    for joint in layouts.state.joints:
        values[joint], rate = trajectory.column(joint), layouts.state.rates[joint]
        values[_pace(rate)] = np.abs(trajectory.column(rate))
    place = layouts.state.field("position").columns if layouts.state.has_field("position") else ()
    if place and all(f"ref_{column}" in trajectory.extra for column in place):
        apart = [trajectory.column(column) - trajectory.extra[f"ref_{column}"] for column in place]
        values["distance from the reference"] = np.linalg.norm(apart, axis=0)
    values["time"] = trajectory.time - trajectory.time[0]
    return values


def signed_features(trajectory: Trajectory) -> dict[str, Array]:
    """What a disturbance may depend on, by name ``# (rows,)`` each; what a derivative is in is smoothed."""
    layout = trajectory.layouts.state
    known = {*layout, *trajectory.layouts.inputs, *trajectory.extra}
    values: dict[str, Array] = {"time": trajectory.time - trajectory.time[0]}
    if HEIGHT in layout:
        values["height"] = trajectory.column(HEIGHT)
    values |= {f"{WHERE}{axis}": trajectory.column(axis) for axis in POSITION.columns[:2] if axis in layout}
    along = [_smooth(trajectory.column(c)) for c in VELOCITY.columns if c in layout]
    velocity = np.stack(along, axis=1) if along else np.zeros((len(trajectory), 0))
    if along:
        values[HOW_FAST] = np.linalg.norm(velocity, axis=1)
        values |= {f"velocity {axis}": column for axis, column in zip("xyz", velocity.T, strict=False)}
    values |= {c: _smooth(trajectory.column(c)) for joint in layout.joints for c in (joint, layout.rates[joint])}
    if along and layout.has_field("heading"):
        sine, cosine = (trajectory.column(name) for name in HEADING.columns)
        values["forward speed"] = velocity[:, 0] * cosine + velocity[:, 1] * sine
    if len(along) == 3 and layout.has_field("attitude"):
        facing = attitudes(layout, trajectory.state)
        body = derive.to_world(facing * INVERSE, velocity)
        values |= {f"body velocity {axis}": column for axis, column in zip("xyz", body.T, strict=True)}
        values["tilt"] = rotation.tilt(torch.as_tensor(facing)).numpy()
        if set(RATE.columns) <= known:
            # Coriolis' and Magnus' forces are along the rate's cross product with the velocity.
            rate = np.stack([_smooth(trajectory.column(name)) for name in RATE.columns], axis=1)
            turned = derive.to_world(facing, np.cross(rate, body))
            values |= {f"rate × velocity {axis}": column for axis, column in zip("xyz", turned.T, strict=True)}
        values |= {f"lean {axis}": column for axis, column in zip("xy", derive.up(facing).T, strict=False)}
    values |= {name: trajectory.column(name) for name in (*RATE.columns, *BATTERY.columns) if name in known}
    for name in trajectory.layouts.action:
        command = trajectory.column(name)
        values[name] = command
        values[f"{CHANGE_OF}{name}"] = np.gradient(_smooth(command))
    return values


def _smooth(column: Array) -> Array:
    return np.asarray(uniform_filter1d(column, 5, mode="nearest"))


def over_windows(values: Array, rows: NDArray[np.int64], steps: int) -> Array:
    """Mean of a feature over windows of ``steps`` rows that start at ``rows`` ``# (windows,)``."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray((sums[rows + steps] - sums[rows]) / steps)


def training_range(feature: str, region: Region) -> tuple[float, float] | None:
    """Range of a feature in training, from the ranges of the columns; None where they do not tell.

    Args:
        feature: its name.
        region: smallest and largest value of every column in the training rows (``training.json``).
    """
    for column, name in DIRECT.items():
        if name == feature and column in region:
            return region[column]
    # Before columns of the same name: a car's command is a column "speed" too.
    if feature in NORMS:
        largest = [max(map(abs, region[column])) for column in NORMS[feature] if column in region]
        return (0.0, float(np.linalg.norm(largest))) if largest else None
    if feature in region:
        return region[feature]
    if feature in map(_pace, region):
        return 0.0, max(map(abs, region[feature.strip("|")]))
    if feature == "tilt" and all(column in region for column in TILTED):
        sine = float(np.linalg.norm([max(map(abs, region[column])) for column in TILTED]))
        return 0.0, 2.0 * float(np.arcsin(min(1.0, sine)))
    return None
