"""Evidence on a car's commands: what steering and speed are counted in, by how its path turns and how fast it goes."""

import numpy as np

from sym2real.logs.draft import Draft
from sym2real.logs.inspect_motion import DRIVING, NEAR, SPEEDS, pace_of_path
from sym2real.logs.reading import Reading, are_pulses, by_name, by_size, largest, turning
from sym2real.logs.units import UNITS, unit_by_ratio
from sym2real.trajectory import Array
from sym2real.vocabulary import ACCELERATION_COLUMN, SPEED_COLUMN, STEER_COLUMN

STEERING = "steering command"  # what one is called whose unit is not known
STEEPEST = 1.6  # rad; no wheel steers beyond a right angle
BOTH_WAYS = 0.1  # rad/s to either side at the 5th and the 95th percentile: a car that turns both ways
HIDES = "that would hide a gain; the driver's own number is better"
LIKE_ITS_PATH = 3.0  # times; what is as near to the path's speed in m/s may be in m/s, and the map be wrong


def inspect_driving(draft: Draft) -> None:
    """Units of steering and speed or acceleration."""
    if draft.has(STEER_COLUMN):
        _steer(draft)
        if draft.has(SPEED_COLUMN):
            _speed(draft)
        if draft.has(ACCELERATION_COLUMN):
            _acceleration(draft)


def _steer(draft: Draft) -> None:
    column, values = draft.column(STEER_COLUMN), draft.values(STEER_COLUMN)
    turned, left = turning(draft, "wz"), 1.0 if draft.frames == "z_up" else -1.0
    if are_pulses(values):
        span = f"{values.min():.5g} to {values.max():.5g}"
        evidence = f"{span}: pulses in µs; the log cannot know the angle per µs"
        worth = "zero = 1500, scale = 0.001 }  # put the pulse straight ahead, and rad per µs"
        draft.leave_open(STEER_COLUMN, STEERING, evidence, worth)
    elif turned is not None and (fit := _off_centre(draft, values, left * turned)) is not None:
        zero, curvature = fit
        evidence = f"{values.min():.4g} to {values.max():.4g}, a servo's travel: straight ahead at {zero:.4g}"
        worth = (
            f"zero = {zero:.4g}, scale = 1.0 }}  # rad per unit is yours to say: {abs(curvature):.3g} × the wheelbase "
            f"in m by the path, but {HIDES}"
        )
        draft.leave_open(STEER_COLUMN, STEERING, evidence, worth)
        if curvature < 0:
            draft.suspect(column, "the car turns right where it is larger")
    else:
        size = largest(draft, [STEER_COLUMN])
        reading = by_name(draft, [STEER_COLUMN]) or _angle_or_driver(draft, values, turned)
        unit, evidence, confidence = reading or by_size(("rad", "deg"), size, STEEPEST)
        if UNITS[unit][1] * size > STEEPEST:
            evidence += f": up to {size:.4g}, which no wheel of the road turns; the steering wheel's, before its gear?"
            draft.comment(
                STEER_COLUMN, "suspected: a steering wheel's angle; scale = 1 / gear; in place of the line above:"
            )
            draft.comment(STEER_COLUMN, f'steer = {{ column = "{column}", unit = "{unit}", scale = 1.0 }}')
            confidence = "guess"
        draft.settle(STEER_COLUMN, unit, evidence, confidence)


def _angle_or_driver(draft: Draft, values: Array, turned: Array | None) -> Reading | None:
    """Numbers up to 1 are rad or a driver's: the wheelbase that the path asks for in rad tells a user which.

    None of larger numbers, and where the car hardly turns or drives.
    """
    most, pace = np.abs(values).max(), _pace(draft)
    if turned is None or most > 1.0 or np.abs(turned).mean() < BOTH_WAYS or pace.mean() < DRIVING:
        return None
    bent = pace * np.tan(values)
    if not (along := abs(float(bent @ turned))):
        return None
    evidence = f"up to {most:.3g}: rad, if the wheelbase is about {bent @ bent / along:.2g} m; else a driver's -1 to 1"
    return "rad", evidence, "guess"


def _off_centre(draft: Draft, values: Array, turned: Array) -> tuple[float, float] | None:
    """Where a command that never changes its sign steers straight, and the path's curvature per unit in 1/m.

    None where it does change its sign, or the car does not turn both ways.
    """
    pace, (least, most) = _pace(draft), np.percentile(turned, [5, 95])
    if values.min() * values.max() <= 0 or least > -BOTH_WAYS or most < BOTH_WAYS or pace.mean() < DRIVING:
        return None
    slope, offset = np.linalg.lstsq(np.stack([pace * values, pace], axis=1), turned)[0]
    return (float(-offset / slope), float(slope)) if slope else None


def _pace(draft: Draft) -> Array:
    """How fast the car goes, m/s ``# (rows,)``; zeros where nothing tells."""
    if draft.has("vx", "vy"):
        return np.hypot(draft.series("vx"), draft.series("vy"))
    return pace_of_path(draft)


def _speed(draft: Draft) -> None:
    size, pace = np.abs(draft.values(SPEED_COLUMN)), _pace(draft)
    unit, evidence, confidence = by_name(draft, [SPEED_COLUMN]) or ("m/s", f"up to {size.max():.3g}", "guess")
    ratio = float(size.mean() / pace.mean()) if pace.mean() > DRIVING and size.any() else 1.0
    if confidence == "guess" and not 1.0 / LIKE_ITS_PATH < ratio < LIKE_ITS_PATH:
        unit = unit_by_ratio(ratio, SPEEDS)
        off, evidence = ratio * UNITS[unit][1], f"{ratio:.4g} times as fast as the path in m/s"
        if max(off, 1.0 / off) > NEAR:
            worth = f"scale = {1.0 / ratio:.6g} }}  # m/s per unit, as the path says: {HIDES}"
            draft.leave_open(SPEED_COLUMN, "speed command", f"{evidence}: no unit of a speed", worth)
            return
    draft.settle(SPEED_COLUMN, unit, evidence, confidence)


def _acceleration(draft: Draft) -> None:
    """In m/s² unless its name says other; numbers of which the path says that they are neither are a throttle's."""
    values, gained = draft.values(ACCELERATION_COLUMN), draft.rows.slopes(_pace(draft))
    reading = by_name(draft, [ACCELERATION_COLUMN])
    ratio = draft.rows.ratio(values, gained) if gained.any() and values.any() else 1.0
    if reading is None and not 1.0 / LIKE_ITS_PATH < ratio < LIKE_ITS_PATH:
        worth = f"scale = {1.0 / ratio:.6g} }}  # m/s² per unit, as the path says: {HIDES}"
        evidence = f"moves {ratio:.3g} times as much as the path's acceleration in m/s²: a throttle?"
        draft.leave_open(ACCELERATION_COLUMN, "acceleration command", evidence, worth)
    else:
        draft.settle(ACCELERATION_COLUMN, *(reading or ("m/s^2", f"up to {np.abs(values).max():.3g}", "guess")))
