"""Evidence on a heading that stands alone: unit, sign and zero, by the way the car moves where that tells."""

from math import pi

import numpy as np

from sym2real.logs import spec_text
from sym2real.logs.angle_units import by_gyro, by_turning, by_turns, by_wraps, jumps, turn_in
from sym2real.logs.attitude_reading import way
from sym2real.logs.course import TOGETHER, between, together
from sym2real.logs.draft import Draft
from sym2real.logs.parts import HEADINGS, Source
from sym2real.logs.reading import by_name
from sym2real.logs.units import UNITS
from sym2real.trajectory import Array

UNIT = 0.05  # of sine and cosine from the unit circle, noise included


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
    sense, by_course = by_turning(values, moved, "the path")
    reading = by_course or by_wraps(draft, values) or (by_gyro(draft, {"wz": column}) if name == "yaw" else None)
    unit, evidence, confidence = reading or by_name(draft, (column,)) or by_turns(values)
    if named and unit != named:
        contradiction = f"the name says {named}, the numbers say {unit}"
        draft.comment(name, contradiction)
        evidence = f"{contradiction}: {evidence}"
    wraps = int((jumps(draft, values) > 0.75 * turn_in(unit)).sum())
    draft.settle(name, unit, f"{evidence}; wraps {wraps} times", confidence)
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
