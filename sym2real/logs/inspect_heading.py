"""Evidence on a heading that stands alone: unit, sign and zero, by the way the car moves where that tells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import isnan, pi

import numpy as np

from sym2real.logs import signals, spec_text
from sym2real.logs.assignment import HEADINGS
from sym2real.logs.course import TOGETHER, between, course, decides, together
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_attitude import angle_unit
from sym2real.logs.parts import Source
from sym2real.logs.signals import Series
from sym2real.logs.units import UNITS, unit_by_ratio

READINGS = ("rad", "deg")
UNIT = 0.05  # of sine and cosine from the unit circle, noise included
WHOLE_TURN = 0.1  # of a turn, within which a jump is one: it turns meanwhile


@dataclass(frozen=True)
class _Reading:
    """What a column of angles is: unit, evidence for it, whether it is beyond doubt, and 1 or -1 by its sense."""

    unit: str
    evidence: str
    sure: bool
    sense: float = 1.0


def inspect_yaw(draft: Draft) -> None:
    """Unit, wraps, sign and zero of headings; sets ``heading`` from the measured one."""
    ways = _courses(draft)
    _sines(draft)
    for name in ("yaw", "ref_yaw"):
        if not draft.has(name):
            continue
        column, values, named = draft.column(name), draft.values(name), draft.named_unit(name)
        found = _by_course(values, ways) or _by_wraps(values) or _by_rate(draft, name)
        reading = found or _Reading(*angle_unit(draft, [column], signals.largest(values)))
        if named and reading.unit != named:
            contradiction = f"the name says {named}, the numbers say {reading.unit}"
            draft.comment(name, contradiction)
            reading = replace(reading, evidence=f"{contradiction}: {reading.evidence}")
        jumps = sum(int((np.abs(np.diff(part)) > 0.75 * _turn(reading.unit)).sum()) for part in values)
        evidence = f"{reading.evidence}; wraps {jumps} times"
        draft.settle(name, reading.unit, evidence, "certain" if reading.sure else "likely")
        _sense(draft, name, column, ways, reading)


def _sines(draft: Draft) -> None:
    """Headings as sine and cosine."""
    for sine, cosine in (pair for pair in HEADINGS if draft.has(*pair)):
        parts = list(zip(draft.raw(sine), draft.raw(cosine), strict=True))
        off = max(float(np.abs(np.hypot(*part) - 1.0).max()) for part in parts)
        circle = f"sine and cosine lie on a circle of 1 within {off:.2g}"
        for name in (sine, cosine):
            draft.add(name, name, "1", circle, "certain" if off < UNIT else "guess")
        if sine == "sin_yaw":
            draft.heading = [np.arctan2(*part) for part in parts]


def _courses(draft: Draft) -> Series:
    """The way a car moves ``# (rows,)`` per stretch; empty for other robots."""
    if not draft.assignment.is_car or not draft.has("x", "y"):
        return []
    logs = zip(draft.stamps, draft.series("x"), draft.series("y"), strict=True)
    speeds = draft.values("speed") if draft.has("speed") else [None] * len(draft.looked_at)
    return [course(*log, speed) for log, speed in zip(logs, speeds, strict=True)]


def _sense(draft: Draft, name: str, column: str, ways: Series, reading: _Reading) -> None:
    """File a heading that turns against the path, or is counted from elsewhere; it stays as recorded."""
    heading = [reading.sense * part for part in draft.series(name)]
    if reading.sense < 0:
        draft.suspect(column, "turns against the path: the heading, not the steering, is counted the other way round")
    if ways and together(ways, heading) > TOGETHER and (apart := between(ways, heading)):
        heading = [part + apart for part in heading]
        # (log - zero) with the sign of the sense is the heading: zero = -sense · apart, in the log's unit.
        zero = round(-reading.sense * apart / UNITS[reading.unit][1], 3)
        draft.add(column, "heading counted from another direction", "", f"the path is {apart:+.2f} rad off", "likely")
        draft.comment(name, f"suspected: the path is {apart:+.2f} rad off the heading; in place of the line above:")
        draft.comment(name, f"{name} = {spec_text.text(Source(column, draft.units[name], zero=zero))}")
    if name == "yaw":
        draft.heading = heading


def _turn(unit: str) -> float:
    return 2.0 * pi / UNITS[unit][1]


def _by_course(values: Series, ways: Series) -> _Reading | None:
    """The unit and sense in which the heading turns as the path does, where only one does."""
    if not ways:
        return None
    scores: Mapping[tuple[str, float], float] = {
        (unit, sense): together(ways, [sense * UNITS[unit][1] * part for part in values])
        for unit, sense in product(READINGS, (1.0, -1.0))
    }
    best = max(scores, key=lambda reading: scores[reading])
    if isnan(scores[best]) or not all(decides(scores[best], scores[score]) for score in scores if score != best):
        return None
    unit, sense = best
    other = max(score for (name, _), score in scores.items() if name != unit)
    turned = "with" if sense > 0 else "against"
    return _Reading(unit, f"in {unit} it turns {turned} the path ({scores[best]:.2f}; {other:.2f})", True, sense)


def _by_wraps(values: Series) -> _Reading | None:
    """The unit whose whole turn is what the values jump by."""
    jumps = np.abs(np.concatenate([np.diff(part) for part in values]))
    span = max(float(np.ptp(part)) for part in values)
    for unit in READINGS:
        turn = _turn(unit)
        whole = np.abs(jumps - turn) < WHOLE_TURN * turn
        if whole.any() and (1.0 - WHOLE_TURN) * turn < span < (1.0 + WHOLE_TURN) * turn:
            return _Reading(unit, f"wraps by {jumps[whole].mean():.4g}, a turn in {unit}", True)
    return None


def _by_rate(draft: Draft, name: str) -> _Reading | None:
    """The unit in which it changes as fast as a yaw rate whose unit its name states."""
    rate = draft.assignment.columns.get("wz", "")
    if name != "yaw" or not draft.assignment.unit(rate):
        return None
    factor = UNITS[draft.assignment.unit(rate)][1]
    turning = [factor * part for part in draft.raw(rate)]
    slopes = signals.slopes(draft.stamps, draft.values(name))
    if abs(signals.correlation(slopes, turning)) < TOGETHER:
        return None
    share = signals.ratio(slopes, turning)
    return _Reading(unit_by_ratio(share, READINGS), f"changes by {share:.3g} a second where {rate!r} says 1 rad", True)
