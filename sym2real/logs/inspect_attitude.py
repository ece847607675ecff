"""Evidence on the attitude: component order, direction, degrees, frames, and the signs of angles and gyro."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import NDArray

from sym2real.logs import derive, signals
from sym2real.logs.draft import Draft
from sym2real.logs.parts import Attitude, Frames
from sym2real.logs.signals import Series
from sym2real.logs.units import GRAVITY, UNITS

Array = NDArray[np.float64]

CLEAR = 0.5  # a correlation that decides
WEAK = 0.3  # one below it says nothing
NORM = 0.05
TILTING = 0.01  # rad, standard deviation of the tilt that makes accelerations speak
TURNING = 0.02  # rad/s, of a body rate
RATE_UNITS = ("rad/s", "deg/s", "mrad/s")
FASTEST = 40.0  # rad/s; a gyro of a small robot ends at 2000 deg/s = 35 rad/s
# Of readings that fit alike the usual one is taken; heights count less than rates or accelerations.
RARE_INVERSE, RARE_NED, HEIGHT_COUNTS = 0.2, 0.4, 0.15
ALOFT = 0.05  # m
COMPONENTS = {"wxyz": "wxyz", "xyzw": "xyzw"}


def inspect_attitudes(draft: Draft) -> None:
    """Find all attitudes; sets ``world`` and ``body_rates`` from the measured one."""
    for name, parts in draft.assignment.quaternions.items():
        _quaternion(draft, name, parts)
    for name, parts in draft.assignment.angles.items():
        _euler(draft, name, parts)
    if "attitude" in draft.attitudes:
        _set_world(draft)
        _decide_frames(draft)


def up(quaternion: Array) -> Array:
    """Body z axis in the world ``# (rows, 3)``."""
    return derive.to_world(quaternion, np.broadcast_to([0.0, 0.0, 1.0], (len(quaternion), 3)).copy())


def _values(draft: Draft, columns: tuple[str, ...]) -> Series:
    parts = [draft.raw(column) for column in columns]
    return [np.stack([part[log] for part in parts], axis=1) for log in range(len(draft.tables))]


def _quaternion(draft: Draft, name: str, parts: dict[str, str]) -> None:
    lettered = set(parts) == set("wxyz")
    columns = tuple(parts[key] for key in ("wxyz" if lettered else sorted(parts)))
    values = _values(draft, columns)
    norms = np.concatenate([np.linalg.norm(part, axis=1) for part in values])
    if np.median(np.abs(norms - 1.0)) > NORM:
        for column in columns:
            draft.add(column, "?", "?", f"named like a quaternion, but the norm is {np.median(norms):.3g}", "unknown")
        return
    # Robots stand or fly upright most of the time: the right order turns the body's z axis up.
    upright = {
        order: float(np.mean([up(np.roll(part, order == "xyzw", axis=1))[:, 2].mean() for part in values]))
        for order in COMPONENTS
    }
    order = "wxyz" if lettered else max(upright, key=lambda key: upright[key])
    other = "xyzw" if order == "wxyz" else "wxyz"
    evidence = f"norm {norms.min():.4f} to {norms.max():.4f}; mean body z is {upright[order]:+.2f} up read as {order}"
    clear = upright[order] - upright[other] > WEAK
    evidence += "" if lettered else f", {upright[other]:+.2f} as {other}"
    if lettered and upright[order] < upright[other] - CLEAR:
        evidence += f"; the names may be in another order: as {other} it is {upright[other]:+.2f}"
        draft.comment(name, f'order = "{other}"  # the body would stand upright')
    for column, letter in zip(columns, order, strict=True):
        draft.add(column, f"{name} q{letter}", "1", evidence, "certain" if lettered or clear else "guess")
    draft.attitudes[name] = Attitude(quaternion=columns, order="xyzw" if order == "xyzw" else "wxyz")


def upright_tilt(draft: Draft) -> Series:
    """Sine of the tilt of a measured quaternion ``# (rows,)`` per log, in the order that stands upright."""
    parts = draft.assignment.quaternions.get("attitude", {})
    if draft.assignment.is_car or not parts:
        return []
    columns = tuple(parts[key] for key in ("wxyz" if set(parts) == set("wxyz") else sorted(parts)))
    values = _values(draft, columns)
    readings = [[up(np.roll(part, shift, axis=1)) for part in values] for shift in (0, 1)]
    best = max(readings, key=lambda reading: float(np.mean([part[:, 2].mean() for part in reading])))
    return [np.hypot(part[:, 0], part[:, 1]) for part in best]


def _euler(draft: Draft, name: str, parts: dict[str, str]) -> None:
    columns = tuple(parts[key] for key in ("roll", "pitch", "yaw"))
    values = _values(draft, columns)
    unit, evidence, sure = angle_unit(draft, list(columns), max(float(np.abs(part).max()) for part in values))
    if not sure and name == "attitude":
        unit, evidence = _unit_by_acceleration(draft, values) or (unit, evidence)
    for column, angle in zip(columns, ("roll", "pitch", "yaw"), strict=True):
        draft.add(column, f"{name} {angle}", unit, evidence, "certain" if sure else "likely")
    draft.attitudes[name] = Attitude(euler=columns, unit=unit)


def angle_unit(draft: Draft, columns: list[str], size: float) -> tuple[str, str, bool]:
    """Unit of angles by name or by size, the evidence, and whether it is beyond doubt."""
    for column in columns:
        if named := draft.assignment.unit(column):
            return named, "the name says so", True
    if size > 2.0 * pi * 1.01:
        return "deg", f"up to {size:.4g}, more than a turn in rad", True
    return "rad", f"up to {size:.3g}, less than a turn in rad", False


def _unit_by_acceleration(draft: Draft, values: Series) -> tuple[str, str] | None:
    """A tilt of 1 rad accelerates by g: so does one of 57.3 deg."""
    if not draft.acceleration or draft.assignment.is_car:
        return None
    tilts, pushes = [], []
    for part, acceleration in zip(values, draft.acceleration, strict=True):
        tilts.append(np.hypot(part[:, 0], part[:, 1]))
        pushes.append(np.hypot(acceleration[:, 0], acceleration[:, 1]))
    share = GRAVITY * float(np.mean(np.concatenate(tilts))) / float(np.mean(np.concatenate(pushes)))
    unit = "deg" if signals.nearest(share, [1.0, 180.0 / pi]) > 1.0 else "rad"
    return unit, f"mean tilt × g is {share:.3g} times the mean horizontal acceleration: 1 in rad, 57.3 in deg"


def read_attitude(draft: Draft, attitude: Attitude) -> Series:
    """The attitude of every log ``# (rows, 4)`` as w x y z, signs and frames as recorded."""
    values = _values(draft, attitude.sources)
    if attitude.euler:
        return [derive.from_euler(part * UNITS[attitude.unit][1]) for part in values]
    unit = [part / np.linalg.norm(part, axis=1, keepdims=True) for part in values]
    return [derive.continuous(np.roll(part, attitude.order == "xyzw", axis=1)) for part in unit]


def _set_world(draft: Draft) -> None:
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
            found[name] = signals.correlation(draft.raw(draft.assignment.columns[name]), turning)
    return found


def _decide_frames(draft: Draft) -> None:
    """Direction of the rotation, and z up or down: the pair that rates, accelerations and heights agree with best."""
    attitude = draft.attitudes["attitude"]
    inverse = Attitude(attitude.quaternion, attitude.order, "world_to_body")
    readings = [attitude] if attitude.euler else [attitude, inverse]
    scores: dict[tuple[int, Frames], float] = {}
    for i, reading in enumerate(readings):
        draft.attitudes["attitude"] = reading
        _set_world(draft)
        scores[i, "z_up"] = _agreement(draft, 1.0) - RARE_INVERSE * i
        scores[i, "ned_frd"] = _agreement(draft, -1.0) - RARE_INVERSE * i - RARE_NED
    best, frames = max(scores, key=lambda key: scores[key])
    draft.attitudes["attitude"], draft.frames = readings[best], frames
    _set_world(draft)
    if best:
        evidence = f"rates and accelerations agree with the inverse rotation ({_text(draft)})"
        draft.add("", "attitude is world to body", "", evidence, "likely")
    if frames == "ned_frd":
        evidence = f"acceleration points against the tilt ({_text(draft)}), as it does with z down"
        draft.add("", "frames are north-east-down", "", evidence, "likely")


def _agreement(draft: Draft, vertical: float) -> float:
    """How well rates, accelerations and heights fit the present reading, with z up (+1) or down (−1)."""
    tilt, gyro = list(tilt_agreement(draft).values()), list(gyro_agreement(draft).values())
    height = signals.mean(draft.series("z")) if draft.has("z") and tilt else 0.0
    aloft = float(np.sign(height)) if abs(height) > ALOFT else 0.0
    return sum(float(np.mean(part)) * sign for part, sign in ((gyro, 1.0), (tilt, vertical)) if part) + (
        HEIGHT_COUNTS * vertical * aloft
    )


def _text(draft: Draft) -> str:
    found = tilt_agreement(draft) | gyro_agreement(draft)
    return "correlations: " + ", ".join(f"{name} {value:+.2f}" for name, value in found.items())
