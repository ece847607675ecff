"""Evidence on the attitude: component order, direction, degrees, frames."""

from dataclasses import replace
from itertools import product

import numpy as np

from sym2real.logs.agreement import ALOFT
from sym2real.logs.angle_units import of_measured, of_wanted
from sym2real.logs.attitude_reading import (
    ORDERS,
    course_agreement,
    gyro_agreement,
    set_world,
    tilt_agreement,
    uprightness,
    usual_reading,
)
from sym2real.logs.draft import Draft
from sym2real.logs.parts import UPRIGHT, Attitude, Direction, Frames
from sym2real.logs.reading import CLEAR, Reading
from sym2real.vocabulary import EULER_ANGLES

NORM = 0.05
# Of readings that fit alike the usual one is taken. Robots fly above the origin: z down goes with negative heights.
RARE_INVERSE, RARE_NED, RARE_ORDER, HEIGHT_COUNTS = 0.2, 0.5, 0.1, 0.8
RARE_NAMES = 0.5  # of columns whose names say another order: as rare as z down
COURSE_COUNTS = 3.0  # a car that drives where it points tells more than the sign of one rate
FRAMES: tuple[tuple[Frames, float], ...] = (("z_up", 1.0), ("ned_frd", -1.0))


def inspect_attitudes(draft: Draft) -> None:
    """Find all attitudes; sets ``world`` and ``body_rates`` from the measured one."""
    if "attitude" in draft.assignment.angles:
        _euler(draft, "attitude", of_measured(draft, _angles(draft, "attitude")))
    for name, parts in sorted(draft.assignment.quaternions.items()):
        _quaternion(draft, name, parts)
    if "attitude" in draft.attitudes:
        _decide(draft)
    for name in draft.assignment.angles:
        if name != "attitude":
            _euler(draft, name, of_wanted(draft, _angles(draft, name)))
    for name, parts in draft.assignment.quaternions.items():
        if name in draft.attitudes:
            _report_quaternion(draft, name, lettered="w" in parts)


def _quaternion(draft: Draft, name: str, parts: dict[str, str]) -> None:
    norm = float(np.median(np.linalg.norm(draft.raw(*parts.values()), axis=1)))
    if abs(norm - 1.0) > NORM:
        for column in parts.values():
            draft.add(column, "?", "?", f"named like a quaternion, but the norm is {norm:.3g}", "unknown")
        return
    draft.attitudes[name] = usual_reading(draft, parts)


def _report_quaternion(draft: Draft, name: str, lettered: bool) -> None:
    attitude = draft.attitudes[name]
    norms = np.linalg.norm(draft.raw(*attitude.quaternion), axis=1)
    other = replace(attitude, order=ORDERS[attitude.order == ORDERS[0]])
    upright, otherwise = uprightness(draft, attitude), uprightness(draft, other)
    evidence = f"norm {norms.min():.4f} to {norms.max():.4f}; mean body z is {upright:+.2f} up"
    evidence += "" if lettered else f" read as {attitude.order}, {otherwise:+.2f} as {other.order}"
    if lettered and upright < otherwise - CLEAR:
        evidence += f"; the names may be in another order: as {other.order} it is {otherwise:+.2f}"
        draft.comment(name, f'order = "{other.order}"  # the body would stand upright')
    letters = attitude.order if len(attitude.quaternion) == len(attitude.order) else UPRIGHT
    for column, letter in zip(attitude.quaternion, letters, strict=True):
        draft.add(column, f"{name} q{letter}", "1", evidence, "certain" if lettered else "likely")


def _euler(draft: Draft, name: str, guess: Reading) -> None:
    columns = _angles(draft, name)
    for column, angle in zip(columns, EULER_ANGLES, strict=True):
        draft.add(column, f"{name} {angle}", *guess)
    draft.attitudes[name] = Attitude(euler=columns, unit=guess[0])  # type: ignore[arg-type]


def _angles(draft: Draft, name: str) -> tuple[str, ...]:
    return tuple(draft.assignment.angles[name][key] for key in EULER_ANGLES)


def _decide(draft: Draft) -> None:
    """Order, direction, and z up or down: what rates, accelerations, the vertical and heights agree with best."""
    first = draft.attitudes["attitude"]
    counted = "w" not in draft.assignment.quaternions.get("attitude", {"w": ""})
    directions: tuple[Direction, ...] = ("body_to_world",) if first.euler else ("body_to_world", "world_to_body")
    set_world(draft, first)
    # One axis alone may as well have its sign reversed.
    turning = len(gyro_agreement(draft))
    evidence_count = turning + len(tilt_agreement(draft)) + bool(course_agreement(draft))
    # Names are doubted by rates about several axes alone.
    doubted = turning > 1 and len(first.quaternion) == len(first.order)
    orders = ORDERS if counted or doubted else (first.order,)
    rare_inverse = RARE_INVERSE if evidence_count > 1 else 2.0
    scores: dict[tuple[Attitude, Frames], float] = {}
    for order, direction in product(orders, directions):
        reading = replace(first, order=order, direction=direction)
        set_world(draft, reading)
        other_order = RARE_ORDER if counted else RARE_NAMES
        rare = rare_inverse * (direction != "body_to_world") + other_order * (order != first.order)
        rare -= uprightness(draft, reading) if counted else 0.0
        for frames, vertical in FRAMES:
            scores[reading, frames] = _agreement(draft, vertical) - rare - RARE_NED * (frames != "z_up")
    best, draft.frames = max(scores, key=lambda key: scores[key])
    set_world(draft, best)
    if counted:
        for name, parts in draft.assignment.quaternions.items():
            if name in draft.attitudes and "w" not in parts:
                draft.attitudes[name] = replace(draft.attitudes[name], order=best.order)
    if not counted and best.order != first.order:
        evidence = f"rates and accelerations agree with them as {best.order}, whatever their names ({_text(draft)})"
        draft.add("", "the scalar is last", "", evidence, "likely")
    if best.direction == "world_to_body":
        evidence = f"rates and accelerations agree with the inverse rotation ({_text(draft)})"
        draft.add("", "attitude is world to body", "", evidence, "likely")
    if draft.frames == "ned_frd":
        evidence = f"acceleration points against the tilt ({_text(draft)}), as it does with z down"
        draft.add("", "frames are north-east-down", "", evidence, "likely")


def _agreement(draft: Draft, vertical: float) -> float:
    """How well rates, accelerations and heights fit the present reading, with z up (+1) or down (−1)."""
    tilt, gyro = list(tilt_agreement(draft).values()), list(gyro_agreement(draft).values())
    height = float(draft.series("z").mean()) if draft.has("z") and tilt else 0.0
    aloft = float(np.sign(height)) if abs(height) > ALOFT else 0.0
    fit = HEIGHT_COUNTS * vertical * aloft + COURSE_COUNTS * course_agreement(draft)
    return fit + (float(np.mean(gyro)) if gyro else 0.0) + (vertical * float(np.mean(tilt)) if tilt else 0.0)


def _text(draft: Draft) -> str:
    correlations = tilt_agreement(draft) | gyro_agreement(draft)
    return "correlations: " + ", ".join(f"{name} {value:+.2f}" for name, value in correlations.items())
