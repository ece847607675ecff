"""Evidence on a heading that stands alone: unit, sign and zero, by the way the car moves where that tells."""

from itertools import product
from math import isnan, pi

import numpy as np

from sym2real.logs import spec_text
from sym2real.logs.attitude_reading import way
from sym2real.logs.course import TOGETHER, between, decides, together
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_attitude import ANGLES, angle_unit
from sym2real.logs.parts import HEADINGS, Source
from sym2real.logs.reading import Reading, by_ratio
from sym2real.logs.units import UNITS, unit_by_ratio
from sym2real.trajectory import Array

UNIT = 0.05  # of sine and cosine from the unit circle, noise included
SLOW = 5.0  # a rate of smaller numbers may be in either unit
WHOLE_TURN = 0.1  # of a turn, within which a jump is one: it turns meanwhile


def inspect_yaw(draft: Draft) -> None:
    """Unit, wraps, sign and zero of headings; sets ``heading`` from the measured one."""
    for sine, cosine in (pair for pair in HEADINGS if draft.has(*pair)):
        parts = draft.raw(sine, cosine)
        off = float(np.abs(np.linalg.norm(parts, axis=1) - 1.0).max())
        for name in (sine, cosine):
            circle = f"sine and cosine lie on a circle of 1 within {off:.2g}"
            draft.add(name, name, "1", circle, "certain" if off < UNIT else "guess")
        if sine == "sin_yaw":
            draft.heading = np.arctan2(*parts.T)
    moved = way(draft)
    for name in ("yaw", "ref_yaw"):
        if draft.has(name):
            _inspect(draft, name, moved)


def _inspect(draft: Draft, name: str, moved: Array | None) -> None:
    column, values, named = draft.column(name), draft.values(name), draft.named_unit(name)
    sense, by_course = _by_course(values, moved)
    reading = by_course or _by_wraps(draft, values) or (_by_rate(draft, values) if name == "yaw" else None)
    unit, evidence, confidence = reading or angle_unit(draft, (column,), float(np.abs(values).max()))
    if named and unit != named:
        contradiction = f"the name says {named}, the numbers say {unit}"
        draft.comment(name, contradiction)
        evidence = f"{contradiction}: {evidence}"
    jumps = int((_jumps(draft, values) > 0.75 * _turn(unit)).sum())
    draft.settle(name, unit, f"{evidence}; wraps {jumps} times", confidence)
    # A heading that turns against the path, or is counted from elsewhere, stays as recorded.
    heading = sense * draft.series(name)
    if moved is not None and sense < 0:
        if name == "yaw" and _turns_as_it_is_steered(draft, -heading):
            _suspect_the_place(draft, between([moved], [heading]))
            draft.heading = -heading
            return
        draft.suspect(column, "turns against the path: the heading, not the steering, is counted the other way round")
    if moved is not None and together([moved], [heading]) > TOGETHER and (apart := between([moved], [heading])):
        heading = heading + apart
        # (log - zero) with the sign of the sense is the heading: zero = -sense · apart, in the log's unit.
        zero = round(-sense * apart / UNITS[unit][1], 3)
        draft.add(column, "heading counted from another direction", "", f"the path is {apart:+.2f} rad off", "likely")
        draft.comment(name, f"suspected: the path is {apart:+.2f} rad off the heading; in place of the line above:")
        draft.comment(name, f"{name} = {spec_text.text(Source(column, draft.units[name], zero=zero))}")
    if name == "yaw":
        draft.heading = heading


def _turns_as_it_is_steered(draft: Draft, heading: Array) -> bool:
    """Whether a gyro turns as a heading (rad) does, and both as the steering says where that is an angle.

    Of a heading and a gyro alone nobody knows whether they, or the place, are counted the other way.
    """
    rate, steer = (draft.assignment.columns.get(name, "") for name in ("wz", "steer"))
    if not (rate and steer) or np.abs(draft.raw(steer)).max() > pi / 2:
        return False
    turning = draft.raw(rate)
    return all(
        draft.rows.correlation(other, turning) > TOGETHER
        for other in (draft.rows.slopes(np.unwrap(heading)), draft.raw(steer))
    )


def _suspect_the_place(draft: Draft, apart: float) -> None:
    """A mirrored place: turned over, the heading is ``apart`` (rad) from its path, by a quarter turn if x is y."""
    x, y = draft.column("x"), draft.column("y")
    evidence = "turns against heading, gyro and steering"
    if abs(abs(apart) - pi / 2) < pi / 4:
        draft.add(f"{x}, {y}", "place suspected to be mirrored", "", f"the path {evidence}", "likely")
        for name, other in (("x", y), ("y", x)):
            draft.comment(name, f"suspected: the path {evidence}; in place of the line above:")
            draft.comment(name, f"{name} = {spec_text.text(Source(other, draft.units.get(name, '')))}")
    else:
        draft.suspect(y if abs(apart) < pi / 2 else x, f"the path {evidence}")


def _turn(unit: str) -> float:
    return 2.0 * pi / UNITS[unit][1]


def _jumps(draft: Draft, values: Array) -> Array:
    return np.abs(draft.rows.each(np.diff, values))


def _by_course(values: Array, moved: Array | None) -> tuple[float, Reading | None]:
    """The sense and unit in which the heading turns as the path does, where only one does."""
    if moved is None:
        return 1.0, None
    scores = {
        (unit, sense): together([moved], [sense * UNITS[unit][1] * values])
        for unit, sense in product(ANGLES, (1.0, -1.0))
    }
    best = max(scores, key=lambda reading: scores[reading])
    if isnan(scores[best]) or not all(decides(scores[best], scores[score]) for score in scores if score != best):
        return 1.0, None
    unit, sense = best
    other = max(score for (name, _), score in scores.items() if name != unit)
    turned = "with" if sense > 0 else "against"
    return sense, (unit, f"in {unit} it turns {turned} the path ({scores[best]:.2f}; {other:.2f})", "certain")


def _by_wraps(draft: Draft, values: Array) -> Reading | None:
    """The unit whose whole turn is what the values jump by."""
    jumps = _jumps(draft, values)
    span = max(float(np.ptp(part)) for part in draft.rows.parts(values))
    for unit in ANGLES:
        turn = _turn(unit)
        whole = np.abs(jumps - turn) < WHOLE_TURN * turn
        if whole.any() and (1.0 - WHOLE_TURN) * turn < span < (1.0 + WHOLE_TURN) * turn:
            return unit, f"wraps by {jumps[whole].mean():.4g}, a turn in {unit}", "certain"
    return None


def _by_rate(draft: Draft, values: Array) -> Reading | None:
    """The unit in which it changes as fast as a yaw rate whose unit its name states; where that is unsaid, a guess."""
    rate = draft.assignment.columns.get("wz", "")
    if not rate:
        return None
    slopes, turning = draft.rows.slopes(values), draft.raw(rate)
    if abs(draft.rows.correlation(slopes, turning)) < TOGETHER:
        return None
    unit, share = draft.assignment.unit(rate), draft.rows.ratio(slopes, turning)
    if unit:
        return by_ratio(ANGLES, share / UNITS[unit][1], f"{rate!r} says in rad/s")
    fastest, turns = float(np.abs(turning).max()), float(np.ptp(values)) >= 2.0 * pi
    if fastest > SLOW or not turns or unit_by_ratio(share, ANGLES) != "rad":
        return None
    either = f"or rad, if {rate!r}, at most {fastest:.3g} and its slope, is in rad/s"
    return "deg", f"up to {np.abs(values).max():.4g}, more than a turn in rad; {either}", "guess"
