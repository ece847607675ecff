"""An attitude read from a log in one of the ways that it may be meant."""

import numpy as np

from sym2real.logs import derive
from sym2real.logs.course import course, together
from sym2real.logs.draft import Draft
from sym2real.logs.parts import Attitude, Order
from sym2real.logs.standard import quaternions
from sym2real.logs.units import GRAVITY
from sym2real.trajectory import Array
from sym2real.vocabulary import SPEED_COLUMN

ORDERS: tuple[Order, Order] = ("wxyz", "xyzw")
TILTING = 0.01  # rad, standard deviation of the tilt that makes accelerations speak
TURNING = 0.02  # rad/s, of a body rate
FACING = 0.3  # what the first component's size counts beside the vertical: robots often start facing along x


def read_attitude(draft: Draft, attitude: Attitude) -> Array:
    """An attitude w x y z ``# (rows, 4)``, signs and frames as recorded."""
    read = quaternions(draft.raw(*attitude.sources), attitude)
    return draft.rows.each(derive.continuous, read / np.linalg.norm(read, axis=1, keepdims=True))


def uprightness(draft: Draft, attitude: Attitude) -> float:
    """Mean of the body z axis's vertical part: robots stand or fly upright most of the time."""
    return float(derive.up(read_attitude(draft, attitude))[:, 2].mean())


def usual_reading(draft: Draft, parts: dict[str, str]) -> Attitude:
    """Components by letters; of counted ones the order that stands upright and, where both do, has the larger w."""
    if "w" in parts:
        return Attitude(tuple(parts[key] for key in "wxyz" if key in parts))
    readings = [Attitude(tuple(parts[key] for key in sorted(parts)), order) for order in ORDERS]
    faced = (FACING * float(np.abs(read_attitude(draft, reading)[:, 0]).mean()) for reading in readings)
    return max(zip(readings, faced, strict=True), key=lambda pair: uprightness(draft, pair[0]) + pair[1])[0]


def set_world(draft: Draft, attitude: Attitude) -> None:
    """Take the attitude to be this one; sets ``world`` and ``body_rates``."""
    draft.attitudes["attitude"] = attitude
    draft.world = read_attitude(draft, attitude)
    draft.body_rates = draft.rows.each(derive.body_rate, draft.rows.stamps, draft.world)


def tilts(draft: Draft, world: Array) -> dict[str, tuple[Array, Array]]:
    """The horizontal acceleration that pitch and roll of an attitude cause, beside the measured one; none of a car.

    In the frame that turns with the heading, a level thrust gives g·(body z axis) as horizontal acceleration.
    """
    if draft.acceleration is None or draft.assignment.is_car:
        return {}
    back = np.exp(-1j * derive.heading(world))
    expected, measured = (
        back * (part[:, 0] + 1j * part[:, 1]) for part in (GRAVITY * derive.up(world), draft.acceleration)
    )
    return {"pitch": (expected.real, measured.real), "roll": (expected.imag, measured.imag)}


def tilt_agreement(draft: Draft) -> dict[str, float]:
    """Correlation of horizontal acceleration with what pitch and roll should cause; empty where nothing tilts."""
    pairs = {} if draft.world is None else tilts(draft, draft.world)
    tilting = {angle: pair for angle, pair in pairs.items() if draft.rows.spread(pair[0]) > GRAVITY * TILTING}
    return {angle: draft.rows.correlation(*pair) for angle, pair in tilting.items()}


def gyro_agreement(draft: Draft) -> dict[str, float]:
    """Correlation of each measured rate with the attitude's, or the heading's; empty where nothing turns."""
    turning = {name: rate for name, rate in draft.turning.items() if draft.has(name)}
    return {
        name: draft.rows.correlation(draft.values(name), rate)
        for name, rate in turning.items()
        if draft.rows.spread(rate) > TURNING
    }


def way(draft: Draft) -> Array | None:
    """The direction in which a car, or what has a heading in a plane, moves in rad ``# (rows,)``, NaN where it stands.

    None for other robots.
    """
    in_plane = draft.has("yaw") and not draft.has("z")
    if not (draft.assignment.is_car or in_plane) or not draft.has("x", "y"):
        return None
    speed = [draft.values(SPEED_COLUMN)] if draft.has(SPEED_COLUMN) else []
    return draft.rows.each(course, draft.rows.stamps, draft.series("x"), draft.series("y"), *speed)


def course_agreement(draft: Draft) -> float:
    """How far a car's heading goes along with the way it moves: 1 always, 0 by chance or unknown."""
    moved = way(draft)
    if moved is None or draft.world is None:
        return 0.0
    return float(np.nan_to_num(together([moved], [derive.heading(draft.world)])))
