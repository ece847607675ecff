"""Evidence on commands: what thrust and motors are counted in, how late the robot answers, reversed signs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sym2real.logs.attitude_reading import up
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_motion import FASTEST, RATES
from sym2real.logs.reading import WEAK, Said, by_name, by_others, by_size, largest
from sym2real.logs.units import GRAVITY, UNITS
from sym2real.trajectory import Array
from sym2real.vocabulary import MOTORS, RATE, RATE_COMMAND, SPEED_COLUMN, STEER_COLUMN, THRUST_COLUMN

SHORTEST_PULSE, LONGEST_PULSE = 900.0, 2200.0  # µs, of servos and speed controllers
STEEPEST = 1.6  # rad; no wheel steers beyond a right angle
HIGHEST_VOLTAGE = 60.0  # the largest packs of such robots have 12 cells of 4.2 V


@dataclass(frozen=True)
class _Answer:
    """How a robot answers a command, in words for the evidence, and whether it goes the other way."""

    said: str = ""
    reversed: bool = False


def inspect_commands(draft: Draft) -> None:
    """Units of commands and the delay of the answers to them."""
    if draft.has(THRUST_COLUMN):
        _thrust(draft)
    if draft.has(*MOTORS):
        _motors(draft)
    _rate_commands(draft)
    if draft.has(STEER_COLUMN):
        _steer(draft)
        if draft.has(SPEED_COLUMN):
            _speed(draft)
    if draft.has("vbat"):
        told = by_name(draft, ["vbat"]) or by_size(("V", "mV"), float(draft.values("vbat").mean()), HIGHEST_VOLTAGE)
        draft.settle("vbat", *told)


def _answer(draft: Draft, command: Array, response: Array | None) -> _Answer:
    """The delay and correlation of a response; nothing where none is known, or it is too weak to count.

    It is reversed where its mean is, too: a car that starts on a circle turns faster and faster, and steers less.
    """
    if response is None:
        return _Answer()
    late, found = draft.rows.delay(command, response)
    if abs(found) <= WEAK:
        return _Answer()
    said = f"; answered {1e3 * late:.0f} ms later (correlation {found:+.2f})"
    return _Answer(said, found < 0 and float(command @ response) < 0)


def _specific_force(draft: Draft) -> Array | None:
    """Acceleration without gravity along the body z axis, m/s² ``# (rows,)``; None where unknown."""
    if draft.acceleration is None or draft.world is None or draft.acceleration.shape[1] < 3:
        return None
    weight = np.array([0.0, 0.0, GRAVITY if draft.frames == "z_up" else -GRAVITY])
    force: Array = np.abs(((draft.acceleration + weight) * up(draft.world)).sum(axis=1))
    return force


def _thrust(draft: Draft) -> None:
    column, values = draft.column(THRUST_COLUMN), draft.values(THRUST_COLUMN)
    if values.mean() < 0:  # along the body's z down, as PX4 has it
        draft.suspect(column, f"mean {values.mean():.3g}, and what carries a robot points up")
        values = -values
    level, most, force = float(values.mean()), largest(draft, [THRUST_COLUMN]), _specific_force(draft)
    share = level / (GRAVITY if force is None else float(force.mean()))
    answer = _answer(draft, values, force).said
    part = "a command of 0 to 1"
    # The mean carries the weight, whatever it counts.
    worth = f"scale = 1.0 }}  # put mass in kg × {GRAVITY / level:.6g} ("
    why = "the mean carries the weight, which hides a mass that you do not know; a thrust stand's N is better)"
    if said := by_name(draft, [THRUST_COLUMN]):
        draft.settle(THRUST_COLUMN, said[0], said[1] + answer, said[2])
    elif most > 100.0 or draft.assignment.named[column].quantity == "throttle":
        what = "counts" if most > 1.0 else part
        evidence = f"{what}, mean {level:.5g}, up to {most:.5g}: the log cannot know N per unit{answer}"
        draft.leave_open(THRUST_COLUMN, "thrust command", evidence, f"{worth}{what}: {why}")
    elif 0.6 < share < 1.6:
        evidence = (
            f"mean {level:.3g}, {share:.2f} times the specific force: thrust per unit mass (or N of a 1 kg robot)"
        )
        draft.settle(THRUST_COLUMN, "m/s^2", evidence + answer, "likely")
    else:
        evidence = f"mean {level:.3g}: in N the robot would weigh {share:.3g} kg"
        doubt = f"; {part} is possible too" if most <= 1.0 else ""
        draft.settle(THRUST_COLUMN, "N", evidence + doubt + answer, "guess")
        if doubt:
            line = f'thrust = {{ column = "{column}", {worth}{part}, in place of the line above: {why}'
            draft.comment("columns", line)


def _motors(draft: Draft) -> None:
    values = draft.values(*MOTORS)
    unit, meaning, confidence = _motor_unit(draft, values)
    answer = _answer(draft, values.sum(axis=1), _specific_force(draft)).said
    evidence = f"{values.min():.5g} to {np.abs(values).max():.5g}: {meaning}{answer}"
    for name in MOTORS:
        draft.settle(name, unit, evidence, confidence)


def _motor_unit(draft: Draft, values: Array) -> Said:
    low, high = values.min(), np.abs(values).max()
    if named := by_name(draft, MOTORS):
        return named
    if low >= 0 and high <= 1.0:
        return "1", "a command of 0 to 1; the thrust per command follows from the log only per unit mass", "likely"
    if _are_pulses(values):
        return "1", "pulses in µs, 1000 to 2000; what they give in thrust cannot be known", "unknown"
    if LONGEST_PULSE < high <= 65535.0 and (values == np.round(values)).all():
        return "uint16", "16-bit counts; 65535 is full", "likely"
    what = "neither 0 to 1, nor pulses, nor 16-bit counts: speeds or scaled pulses; the unit cannot be known"
    return "1", what, "unknown"


def _are_pulses(values: Array) -> bool:
    return bool(((values >= SHORTEST_PULSE) & (values <= LONGEST_PULSE)).all())


def _rate_commands(draft: Draft) -> None:
    """The body rate that answers is the attitude's, else the gyro's."""
    pairs = dict(zip(RATE_COMMAND.columns, RATE.columns, strict=True))
    names = [name for name in pairs if draft.has(name)]
    if not names:
        return
    turned = {name: rate for name in names if (rate := _turning(draft, pairs[name])) is not None}
    told = by_others(draft, RATES[:2], turned, "the body rate in rad/s")
    size = largest(draft, names)
    unit, evidence, confidence = by_name(draft, names) or by_size(RATES, size, FASTEST, told)
    for name in names:
        answer = _answer(draft, draft.values(name), turned.get(name))
        draft.settle(name, unit, evidence + answer.said, confidence)
        if answer.reversed and draft.world is not None:
            draft.suspect(draft.column(name), f"the attitude turns the other way{answer.said}")


def _turning(draft: Draft, rate: str) -> Array | None:
    """A body rate by attitude or heading, else by the gyro; None where none is known."""
    return draft.turning.get(rate, draft.series(rate) if draft.has(rate) else None)


def _steer(draft: Draft) -> None:
    column, values = draft.column(STEER_COLUMN), draft.values(STEER_COLUMN)
    turning, left = _turning(draft, "wz"), 1.0 if draft.frames == "z_up" else -1.0
    answer = _answer(draft, values, None if turning is None else left * turning)
    pulses = _are_pulses(values)
    if pulses:
        span = f"{values.min():.5g} to {values.max():.5g}"
        evidence = f"{span}: pulses in µs; the log cannot know the angle per µs{answer.said}"
        worth = "zero = 1500, scale = 0.001 }  # put the pulse straight ahead, and rad per µs"
        draft.leave_open(STEER_COLUMN, "steering command", evidence, worth)
    else:
        size = largest(draft, [STEER_COLUMN])
        unit, evidence, confidence = by_name(draft, [STEER_COLUMN]) or by_size(("rad", "deg"), size, STEEPEST)
        if UNITS[unit][1] * size > STEEPEST:
            evidence += f": up to {size:.4g}, which no wheel of the road turns; the steering wheel's, before its gear?"
            draft.comment(
                STEER_COLUMN, "suspected: a steering wheel's angle; scale = 1 / gear; in place of the line above:"
            )
            draft.comment(STEER_COLUMN, f'steer = {{ column = "{column}", unit = "{unit}", scale = 1.0 }}')
            confidence = "guess"
        draft.settle(STEER_COLUMN, unit, evidence + answer.said, confidence)
    if answer.reversed:
        where = "pulses are longer" if pulses else "it is positive"
        draft.suspect(column, f"the car turns right where {where}{answer.said}")


def _speed(draft: Draft) -> None:
    size = np.abs(draft.values(SPEED_COLUMN))
    pace = np.hypot(draft.series("vx"), draft.series("vy")) if draft.has("vx", "vy") else None
    unit, evidence, confidence = by_name(draft, [SPEED_COLUMN]) or ("m/s", f"up to {size.max():.3g}", "guess")
    draft.settle(SPEED_COLUMN, unit, evidence + _answer(draft, size, pace).said, confidence)
