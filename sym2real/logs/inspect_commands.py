"""Evidence on commands: what thrust and motors are counted in, how late the robot answers, reversed signs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sym2real.logs import signals
from sym2real.logs.attitude_reading import up
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_attitude import WEAK
from sym2real.logs.inspect_motion import FASTEST
from sym2real.logs.signals import Series
from sym2real.logs.units import GRAVITY, unit_by_ratio
from sym2real.vocabulary import MOTORS

LONGEST_DELAY = 0.5  # s
SHORTEST_PULSE, LONGEST_PULSE = 900.0, 2200.0  # µs, of servos and speed controllers
STEEPEST = 1.6  # rad; no wheel steers beyond a right angle


@dataclass(frozen=True)
class _Answer:
    """How a robot answers a command, in words for the evidence, and whether it goes the other way."""

    said: str = ""
    reversed: bool = False


def inspect_commands(draft: Draft) -> None:
    """Units of commands and the delay of the answers to them."""
    _thrust(draft)
    _motors(draft)
    _rate_commands(draft)
    _car(draft)
    if draft.has("vbat"):
        _battery(draft)


def specific_force(draft: Draft) -> Series:
    """Acceleration without gravity along the body z axis, m/s² ``# (rows,)`` per log; empty where unknown."""
    if not draft.acceleration or not draft.world or draft.acceleration[0].shape[1] < 3:
        return []
    weight = np.array([0.0, 0.0, GRAVITY if draft.frames == "z_up" else -GRAVITY])
    return [
        np.abs(((part + weight) * up(world)).sum(axis=1))
        for part, world in zip(draft.acceleration, draft.world, strict=True)
    ]


def _thrust(draft: Draft) -> None:
    if not draft.has("thrust"):
        return
    values, named = draft.values("thrust"), draft.named_unit("thrust")
    level = signals.mean(values)
    if level < 0:  # along the body's z down, as PX4 has it
        draft.suspect(draft.column("thrust"), f"mean {level:.3g}, and what carries a robot points up")
        values, level = [-part for part in values], -level
    force = specific_force(draft)
    hover = signals.mean(force) if force else GRAVITY
    share = level / hover
    answer = _answer(draft, values, force).said
    if named:
        draft.settle("thrust", named, f"the name says so{answer}", "certain")
    elif signals.largest(values) > 100.0 or draft.assignment.named[draft.column("thrust")].quantity == "throttle":
        _counted_thrust(draft, draft.column("thrust"), values, level, answer)
    elif 0.6 < share < 1.6:
        evidence = (
            f"mean {level:.3g}, {share:.2f} times the specific force: thrust per unit mass (or N of a 1 kg robot)"
        )
        draft.settle("thrust", "m/s^2", evidence + answer, "likely")
    else:
        evidence = f"mean {level:.3g}: in N the robot would weigh {share:.3g} kg"
        part = signals.largest(values) <= 1.0
        doubt = "; a command of 0 to 1 is possible too" if part else ""
        draft.settle("thrust", "N", evidence + doubt + answer, "guess")
        if part:
            _scaled_by_weight(draft, draft.column("thrust"), level, "a command of 0 to 1, in place of the line above")


def _counted_thrust(draft: Draft, column: str, values: Series, level: float, answer: str) -> None:
    draft.left_out.add("thrust")
    largest = signals.largest(values)
    what = "counts" if largest > 1.0 else "a command of 0 to 1"
    evidence = f"{what}, mean {level:.5g}, up to {largest:.5g}: the log cannot know N per unit{answer}"
    draft.add(column, "thrust command", "?", evidence, "unknown")
    _scaled_by_weight(draft, column, level, what)


def _scaled_by_weight(draft: Draft, column: str, level: float, what: str) -> None:
    """A suspicion that thrust is no force: its mean carries the weight, whatever it counts."""
    worth = f"scale = 1.0 }}  # put mass in kg × {GRAVITY / level:.6g}"
    why = f"{what}: the mean carries the weight, which hides a mass that you do not know; a thrust stand's N is better"
    draft.comment("columns", f'thrust = {{ column = "{column}", {worth} ({why})')


def _answer(draft: Draft, command: Series, response: Series) -> _Answer:
    """The delay and correlation of a response; nothing where none is known, or it is too weak to count.

    It is reversed where its mean is, too: a car that starts on a circle turns faster and faster, and steers less.
    """
    if not response:
        return _Answer()
    rows = max(1, int(LONGEST_DELAY / float(np.median(np.diff(draft.stamps[0])))))
    shift, found = signals.delay(command, response, rows)
    late = shift * float(np.median(np.diff(draft.stamps[0])))
    if abs(found) <= WEAK:
        return _Answer()
    together = sum(float(given @ came) for given, came in zip(command, response, strict=True))
    said = f"; answered {1e3 * late:.0f} ms later (correlation {found:+.2f})"
    return _Answer(said, found < 0 and together < 0)


def _motors(draft: Draft) -> None:
    if not draft.has(*MOTORS):
        return
    values = [part for name in MOTORS for part in draft.values(name)]
    high, low = signals.largest(values), min(float(part.min()) for part in values)
    whole = all(bool((part == np.round(part)).all()) for part in values)
    unit, meaning, sure = _motor_unit(draft.named_unit(*MOTORS), low, high, whole)
    total = [sum(parts) for parts in zip(*map(draft.values, MOTORS), strict=True)]
    force = specific_force(draft)
    evidence = f"{low:.5g} to {high:.5g}: {meaning}{_answer(draft, total, force).said}"
    for name in MOTORS:
        draft.settle(name, unit or "1", evidence, "likely" if sure else "unknown")


def _motor_unit(named: str, low: float, high: float, whole: bool) -> tuple[str, str, bool]:
    if named:
        return named, "the name says so", True
    if low >= 0 and high <= 1.0:
        return "", "a command of 0 to 1; the thrust per command follows from the log only per unit mass", True
    if low >= SHORTEST_PULSE and high <= LONGEST_PULSE:
        return "", "pulses in µs, 1000 to 2000; what they give in thrust cannot be known", False
    if whole and 2200.0 < high <= 65535.0:
        return "uint16", "16-bit counts; 65535 is full", True
    return "", "neither 0 to 1, nor pulses, nor 16-bit counts: speeds or scaled pulses; the unit cannot be known", False


def _rate_commands(draft: Draft) -> None:
    names = [name for name in ("wx_cmd", "wy_cmd", "wz_cmd") if draft.has(name)]
    if not names:
        return
    size = max(signals.largest(draft.values(name)) for name in names)
    unit, evidence = _rate_command_unit(draft, names, size)
    for name in names:
        answer = _answer(draft, draft.values(name), _response(draft, name.removesuffix("_cmd")))
        draft.settle(name, unit, evidence + answer.said, "likely")
        if answer.reversed and draft.world:
            draft.suspect(draft.column(name), f"the attitude turns the other way{answer.said}")


def _rate_command_unit(draft: Draft, names: list[str], size: float) -> tuple[str, str]:
    if named := draft.named_unit(*names):
        return named, "the name says so"
    if size > FASTEST:
        return "deg/s", f"up to {size:.3g}, faster than a small robot turns in rad/s"
    shares = [
        signals.ratio(draft.values(name), response)
        for name in names
        if (response := _response(draft, name.removesuffix("_cmd")))
    ]
    if not shares:
        return "rad/s", f"up to {size:.3g}"
    share = float(np.median(shares))
    return unit_by_ratio(share, ("rad/s", "deg/s")), f"moves {share:.3g} times as much as the body rate in rad/s"


def _response(draft: Draft, rate: str) -> Series:
    """A body rate by the attitude, else by the gyro."""
    if draft.body_rates:
        return [part[:, "xyz".index(rate[1])] for part in draft.body_rates]
    return draft.series(rate) if draft.has(rate) else []


def _car(draft: Draft) -> None:
    if not draft.has("steer"):
        return
    column, values = draft.column("steer"), draft.values("steer")
    if draft.has("speed"):
        _speed(draft)
    if _are_pulses(values):
        _steering_pulses(draft, column, values)
        return
    size, named = signals.largest(values), draft.named_unit("steer")
    unit = named or ("deg" if size > STEEPEST else "rad")
    evidence = "the name says so" if named else f"up to {size:.3g}"
    answer = _answer(draft, values, _turning(draft))
    draft.settle("steer", unit, evidence + answer.said, "certain" if named else "likely")
    if answer.reversed:
        draft.suspect(column, f"the car turns right where it is positive{answer.said}")


def _are_pulses(values: Series) -> bool:
    return all(bool(((part >= SHORTEST_PULSE) & (part <= LONGEST_PULSE)).all()) for part in values)


def _steering_pulses(draft: Draft, column: str, values: Series) -> None:
    draft.left_out.add("steer")
    answer = _answer(draft, values, _turning(draft))
    span = f"{min(float(part.min()) for part in values):.5g} to {signals.largest(values):.5g}"
    evidence = f"{span}: pulses in µs; the log cannot know the angle per µs{answer.said}"
    draft.add(column, "steering command", "?", evidence, "unknown")
    worth = "zero = 1500, scale = 0.001 }  # put the pulse straight ahead, and rad per µs"
    draft.comment("columns", f'steer = {{ column = "{column}", {worth}')
    if answer.reversed:
        draft.suspect(column, f"the car turns right where pulses are longer{answer.said}")


def _turning(draft: Draft) -> Series:
    """A car's rate of turn to the left, rad/s: by heading, attitude, else gyro; empty where none is known."""
    if draft.heading:
        return signals.slopes(draft.stamps, [np.unwrap(part) for part in draft.heading])
    left = 1.0 if draft.frames == "z_up" else -1.0
    return [left * part for part in _response(draft, "wz")]


def _speed(draft: Draft) -> None:
    values, named = draft.values("speed"), draft.named_unit("speed")
    pace: Series = []
    if draft.has("vx", "vy"):
        pace = [np.hypot(a, b) for a, b in zip(draft.series("vx"), draft.series("vy"), strict=True)]
    evidence = f"up to {signals.largest(values):.3g}{_answer(draft, [np.abs(part) for part in values], pace).said}"
    draft.settle("speed", named or "m/s", evidence, "certain" if named else "guess")


def _battery(draft: Draft) -> None:
    level, named = signals.mean(draft.values("vbat")), draft.named_unit("vbat")
    # The largest packs of such robots have 12 cells of 4.2 V.
    unit = named or ("mV" if level > 60.0 else "V")
    draft.settle("vbat", unit, f"mean {level:.4g}", "certain" if named else "likely")
