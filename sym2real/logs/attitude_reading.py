"""An attitude read from a log in one of the ways that it may be meant."""

from __future__ import annotations

import numpy as np

from sym2real.logs import derive, signals
from sym2real.logs.draft import Draft
from sym2real.logs.parts import Attitude, Order
from sym2real.logs.signals import Series
from sym2real.logs.units import GRAVITY, UNITS
from sym2real.trajectory import Array

ORDERS: tuple[Order, Order] = ("wxyz", "xyzw")
TILTING = 0.01  # rad, standard deviation of the tilt that makes accelerations speak
TURNING = 0.02  # rad/s, of a body rate
CREEPING = 0.1  # m/s, below which a car's way has no direction
FACING = 0.3  # what the first component's size counts beside the vertical: robots often start facing along x


def up(quaternion: Array) -> Array:
    """Body z axis in the world ``# (rows, 3)``."""
    return derive.to_world(quaternion, np.broadcast_to([0.0, 0.0, 1.0], (len(quaternion), 3)).copy())


def values_of(draft: Draft, columns: tuple[str, ...]) -> Series:
    """Several columns side by side, one array per log."""
    parts = [draft.raw(column) for column in columns]
    return [np.stack([part[log] for part in parts], axis=1) for log in range(len(draft.looked_at))]


def scalar_first(values: Array, order: Order) -> Array:
    """Quaternions ``# (rows, 4)`` in the log's order as unit w x y z with continuous signs."""
    turned = np.roll(values, 1, axis=1) if order == "xyzw" else values
    return derive.continuous(turned / np.linalg.norm(turned, axis=1, keepdims=True))


def uprightness(values: Series, order: Order) -> float:
    """Mean of the body z axis's vertical part: robots stand or fly upright most of the time."""
    return float(np.mean([up(scalar_first(part, order))[:, 2].mean() for part in values]))


def usual_order(values: Series) -> Order:
    """The order that stands upright and, where both do, the one with the larger scalar part."""
    scores = {
        order: uprightness(values, order)
        + FACING * float(np.mean([np.abs(scalar_first(part, order)[:, 0]).mean() for part in values]))
        for order in ORDERS
    }
    return max(ORDERS, key=lambda order: scores[order])


def quaternion_columns(parts: dict[str, str]) -> tuple[str, ...]:
    """Columns of a quaternion, lettered ones as w x y z, counted ones as they are counted."""
    return tuple(parts[key] for key in ("wxyz" if "w" in parts else sorted(parts)))


def level_push(draft: Draft) -> Series:
    """Horizontal acceleration ``# (rows, 2)`` that a measured quaternion's tilt causes, m/s²; empty without one."""
    parts = draft.assignment.quaternions.get("attitude", {})
    if draft.assignment.is_car or not parts:
        return []
    values = values_of(draft, quaternion_columns(parts))
    order: Order = "wxyz" if "w" in parts else usual_order(values)
    return [GRAVITY * up(scalar_first(part, order))[:, :2] for part in values]


def read_attitude(draft: Draft, attitude: Attitude) -> Series:
    """The attitude of every log ``# (rows, 4)`` as w x y z, signs and frames as recorded."""
    values = values_of(draft, attitude.sources)
    if attitude.euler:
        return [derive.from_euler(part * UNITS[attitude.unit][1]) for part in values]
    return [scalar_first(part, attitude.order) for part in values]


def set_world(draft: Draft) -> None:
    """Set ``world`` and ``body_rates`` of a draft from its present reading of the attitude."""
    attitude = draft.attitudes["attitude"]
    world = read_attitude(draft, attitude)
    if attitude.direction == "world_to_body":
        world = [part * np.array([1.0, -1.0, -1.0, -1.0]) for part in world]
    draft.world = world
    draft.body_rates = [derive.body_rate(time, part) for time, part in zip(draft.stamps, world, strict=True)]


def tilt_agreement(draft: Draft) -> dict[str, float]:
    """Correlation of horizontal acceleration with what pitch and roll should cause; empty where nothing tilts.

    In the frame that turns with the heading, a level thrust gives g·(body z axis) as horizontal acceleration.
    """
    if not draft.acceleration or not draft.world or draft.assignment.is_car:
        return {}
    expected: dict[str, Series] = {"pitch": [], "roll": []}
    found: dict[str, Series] = {"pitch": [], "roll": []}
    for world, acceleration in zip(draft.world, draft.acceleration, strict=True):
        yaw = derive.heading(world)
        for kind, vectors in ((expected, GRAVITY * up(world)), (found, acceleration)):
            kind["pitch"].append(np.cos(yaw) * vectors[:, 0] + np.sin(yaw) * vectors[:, 1])
            kind["roll"].append(-np.sin(yaw) * vectors[:, 0] + np.cos(yaw) * vectors[:, 1])
    return {
        angle: signals.correlation(expected[angle], found[angle])
        for angle in expected
        if signals.spread(expected[angle]) > GRAVITY * TILTING
    }


def gyro_agreement(draft: Draft) -> dict[str, float]:
    """Correlation of each measured rate with the attitude's derivative; empty where nothing turns."""
    found = {}
    for i, name in enumerate(("wx", "wy", "wz")):
        turning = [part[:, i] for part in draft.body_rates]
        if draft.has(name) and turning and signals.spread(turning) > TURNING:
            found[name] = signals.correlation(draft.values(name), turning)
    return found


def course_agreement(draft: Draft) -> float:
    """How far a car's heading goes along with the way it moves: 1 always, 0 (or less) as by chance or unknown.

    The mean |cos| of the angle between them, which is 2/π by chance.
    """
    if not draft.assignment.is_car or not draft.world or not draft.has("x", "y"):
        return 0.0
    ways = [signals.slopes(draft.stamps, draft.series(axis)) for axis in "xy"]
    aligned = []
    for log, world in enumerate(draft.world):
        pace, yaw = np.hypot(ways[0][log], ways[1][log]), derive.heading(world)
        along = np.abs(np.cos(yaw) * ways[0][log] + np.sin(yaw) * ways[1][log])
        aligned.append(along[pace > CREEPING] / pace[pace > CREEPING])
    rows = np.concatenate(aligned)
    chance = 2.0 / np.pi
    return (float(rows.mean()) - chance) / (1.0 - chance) if len(rows) else 0.0
