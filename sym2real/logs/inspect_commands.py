"""Evidence on commands: what thrust, motors and rates are counted in."""

import numpy as np

from sym2real.logs import derive
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_driving import inspect_driving
from sym2real.logs.inspect_motion import FASTEST, RATES
from sym2real.logs.reading import (
    CLEAR,
    LONGEST_PULSE,
    Reading,
    are_pulses,
    by_name,
    by_others,
    by_size,
    largest,
    turning,
)
from sym2real.logs.units import GRAVITY
from sym2real.trajectory import Array
from sym2real.vocabulary import MOTORS, RATE, RATE_COMMAND, THRUST_COLUMN

HIGHEST_VOLTAGE = 60.0  # the largest packs of such robots have 12 cells of 4.2 V


def inspect_commands(draft: Draft) -> None:
    """Units of commands."""
    if draft.has(THRUST_COLUMN):
        _thrust(draft)
    if draft.has(*MOTORS):
        _motors(draft)
    _find_rate_commands(draft)
    _rate_commands(draft)
    inspect_driving(draft)
    if draft.has("vbat"):
        reading = by_name(draft, ["vbat"]) or by_size(("V", "mV"), float(draft.values("vbat").mean()), HIGHEST_VOLTAGE)
        draft.settle("vbat", *reading)


def _specific_force(draft: Draft) -> float:
    """Mean acceleration without gravity along the body's z axis, m/s²; that of gravity where unknown.

    Noise of positions makes each row's far too large to either side, and leaves the mean. It is negative with z down.
    """
    if draft.acceleration is None or draft.world is None or draft.acceleration.shape[1] < 3:
        return GRAVITY
    weight = np.array([0.0, 0.0, GRAVITY if draft.frames == "z_up" else -GRAVITY])
    force = ((draft.acceleration + weight) * derive.up(draft.world)).sum(axis=1)
    return abs(draft.rows.mean(force)) or GRAVITY


def _thrust(draft: Draft) -> None:
    column, values = draft.column(THRUST_COLUMN), draft.values(THRUST_COLUMN)
    level, most, reading = abs(float(values.mean())), largest(draft, [THRUST_COLUMN]), by_name(draft, [THRUST_COLUMN])
    unknown = not reading and (most > 100.0 or draft.assignment.named[column].quantity == "throttle")
    if values.mean() < 0:  # along the body's z down, as PX4 has it
        _downwards(draft, column, values, sure=draft.frames == "ned_frd" and not unknown)
    if not level:
        draft.leave_open(THRUST_COLUMN, "thrust command", "its mean is 0, which carries nothing", "scale = 1.0 }")
        return
    share = level / _specific_force(draft)
    part = "a command of 0 to 1"
    # The mean carries the weight, whatever it counts.
    worth = f"scale = 1.0 }}  # put mass in kg × {GRAVITY / level:.6g} ("
    why = "the mean carries the weight, which hides a mass that you do not know; a thrust stand's N is better)"
    if reading:
        draft.settle(THRUST_COLUMN, *reading)
    elif unknown:
        what = "counts" if most > 1.0 else part
        evidence = f"{what}, mean {level:.5g}, up to {most:.5g}: the log cannot know N per unit"
        draft.leave_open(THRUST_COLUMN, "thrust command", evidence, f"{worth}{what}: {why}")
    elif 0.6 < share < 1.6:
        per_mass = f"thrust per unit mass, or N where the robot weighs {share:.2g} kg"
        evidence = f"mean {level:.3g}, {share:.2f} times the specific force: {per_mass}"
        draft.settle(THRUST_COLUMN, "m/s^2", evidence, "likely")
    else:
        evidence = f"mean {level:.3g}: in N the robot would weigh {share:.3g} kg"
        doubt = f"; {part} is possible too" if most <= 1.0 else ""
        draft.settle(THRUST_COLUMN, "N", evidence + doubt, "guess")
        if doubt:
            line = f'thrust = {{ column = "{column}", {worth}{part}, in place of the line above: {why}'
            draft.comment("columns", line)


def _downwards(draft: Draft, column: str, values: Array, sure: bool) -> None:
    evidence = f"mean {values.mean():.3g}, and what carries a robot points up"
    if not sure:
        draft.suspect(column, evidence)
        return
    draft.reverse(column)
    draft.add(column, "reversed", "", f"{evidence}, which is along minus z in such frames", "certain")


def _motors(draft: Draft) -> None:
    values = draft.values(*MOTORS)
    unit, meaning, confidence = _motor_unit(draft, values)
    evidence = f"{values.min():.5g} to {np.abs(values).max():.5g}: {meaning}"
    for name in MOTORS:
        draft.settle(name, unit, evidence, confidence)


def _motor_unit(draft: Draft, values: Array) -> Reading:
    low, high = values.min(), np.abs(values).max()
    if named := by_name(draft, MOTORS):
        return named
    if low >= 0 and high <= 1.0:
        return "1", "a command of 0 to 1; the thrust per command follows from the log only per unit mass", "likely"
    if are_pulses(values):
        return "1", "pulses in µs, 1000 to 2000; what they give in thrust cannot be known", "unknown"
    if LONGEST_PULSE < high <= 65535.0 and (values == np.round(values)).all():
        return "uint16", "16-bit counts; 65535 is full", "likely"
    what = "neither 0 to 1, nor pulses, nor 16-bit counts: speeds or scaled pulses; the unit cannot be known"
    return "1", what, "unknown"


def _find_rate_commands(draft: Draft) -> None:
    """PX4 calls commanded rates roll, pitch and yaw: take them for that where body rates follow, as no angle's do."""
    columns, rates = draft.assignment.beside, draft.body_rates
    if not columns or rates is None or any(map(draft.has, RATE_COMMAND.columns)):
        return
    alike = [draft.rows.correlation(draft.raw(name), rate) for name, rate in zip(columns, rates.T, strict=True)]
    if min(alike[:2]) >= CLEAR:
        draft.assignment.columns.update(zip(RATE_COMMAND.columns, columns, strict=True))


def _rate_commands(draft: Draft) -> None:
    """The body rate that answers is the attitude's, else the gyro's."""
    pairs = dict(zip(RATE_COMMAND.columns, RATE.columns, strict=True))
    names = [name for name in pairs if draft.has(name)]
    if not names:
        return
    turned = {name: rate for name in names if (rate := turning(draft, pairs[name])) is not None}
    by_motion = by_others(draft, RATES[:2], turned, "the body rate in rad/s")
    size = largest(draft, names)
    reading = by_name(draft, names) or by_size(RATES, size, FASTEST, by_motion)
    for name in names:
        draft.settle(name, *reading)
