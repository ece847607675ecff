"""When a flight goes on, when it lands, when the motors are cut: one pure function of what is known.

Whatever is not a number, or comes from a clock that went backwards, counts as bad: comparisons are written so that
NaN fails them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hardware.interfaces import Verdict
from sym2real.errors import ShapeError
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array

CUTS = ("tumbled", "locked", "crashed")  # flags of the supervisor under which the firmware turns no motor
LOST, LINK_ENDED = "lost", "the link to the robot has ended"  # its flag, and a reason
NEAR_GROUND = 0.15  # m: lower it falls unharmed, and a blind thrust might lift it up
MOST_DESCENT = 1.0  # m/s: as after a fall from 5 cm
FAR = 1e3  # m: no motion capture sees that far
BELOW_GROUND = 0.3  # m: a landing aims there, so that it does not float in its own ground effect
LEVELS_AFTER = 0.5  # s without a set-point until a Crazyflie's firmware turns level by itself
CLOCK_SLACK = 0.05  # s: data may arrive after the moment that it is judged at


@dataclass(frozen=True)
class Limits:
    """Limits of a flight.

    Args:
        low, high: corners of the volume that the robot stays in, m, world axes.
        tilt: largest angle between the body's and the world's z axis, rad.
        upside_down: angle beyond which no landing is possible, rad.
        pose_age: s without a pose from motion capture before a blind landing.
        attitude_age: s without attitude from the robot before a blind landing.
        battery: least voltage in V; it counts once it has stayed below for :attr:`battery_time`.
        reserve: V above it without which nothing takes off: about what a take-off pulls a Crazyflie's battery down.
        battery_time: s, longer than a gust of thrust pulls the voltage down.
        late: s that an action may be late before the flight is ended without it.
        overruns: actions in a row that may come after their period.
        landing: longest landing, s.
        blind: longest landing without position or attitude, s.
        blind_thrust: its thrust, as a part of what has held the robot up so far.
        descent: speed of a landing, m/s.
        touchdown: height above the ground at which motors are cut, m.
        standing_tilt: angle within which a drone takes off, rad: the firmware's self-test reads up to 5° on level
            ground (SENSORS_MAN_TEST_LEVEL_MAX), and a floor slopes by up to 5° (a ramp of 1:12).
        standing_rate: root mean square of a body rate within which it takes off, rad/s: five times the 10 steps of
            2000°/s / 2¹⁵ at which the firmware calls its gyroscope still (GYRO_VARIANCE_BASE).
        facing: difference between its yaw and motion capture's within which it takes off, rad.
    """

    low: tuple[float, float, float] = (-1.5, -1.5, -0.2)
    high: tuple[float, float, float] = (1.5, 1.5, 1.7)
    tilt: float = math.radians(70.0)
    upside_down: float = math.radians(110.0)
    pose_age: float = 0.2
    attitude_age: float = 0.2
    battery: float = 3.2
    reserve: float = 0.3
    battery_time: float = 0.3
    late: float = 0.1
    overruns: int = 5
    landing: float = 12.0
    blind: float = 3.0
    blind_thrust: float = 0.94
    descent: float = 0.3
    touchdown: float = 0.04
    standing_tilt: float = math.radians(10.0)
    standing_rate: float = 0.05
    facing: float = math.radians(15.0)


def require_possible(limits: Limits) -> None:
    """Refuse limits by which no flight would end well, such as a tilt in degrees or a thrust in percent.

    Raises:
        ShapeError: with what they must be.
    """
    fence = all(low < high for low, high in zip(limits.low, limits.high, strict=True))
    angles = 0.0 < limits.standing_tilt <= limits.tilt <= limits.upside_down <= math.pi
    if not (fence and angles and 0.0 < limits.blind_thrust < 1.0 and 0.0 < limits.descent < math.inf):
        raise ShapeError(
            "limits: expected low corners below the high ones, 0 < standing_tilt <= tilt <= upside_down <= π rad, "
            f"0 < blind_thrust < 1 and a descent in m/s above 0, found {limits}"
        )
    if not (limits.descent <= MOST_DESCENT and 0.0 < limits.touchdown <= NEAR_GROUND):
        raise ShapeError(
            f"limits: expected a descent up to {MOST_DESCENT:g} m/s and a touchdown above 0 and up to {NEAR_GROUND:g} "
            f"m, found {limits.descent:g} and {limits.touchdown:g}"
        )
    _require_time_to_land(limits)
    for option, found in (("late", limits.late), ("pose_age", limits.pose_age), ("attitude_age", limits.attitude_age)):
        if not found < LEVELS_AFTER:
            raise ShapeError(
                f"limits: expected {option} below {LEVELS_AFTER:g} s, after which the firmware turns level by itself, "
                f"found {found:g}"
            )


def _require_time_to_land(limits: Limits) -> None:
    """A landing from the fence's top comes down before its time is up, where the motors are cut in the air."""
    height = limits.high[2] - limits.low[2]
    steered = (height + BELOW_GROUND) / limits.descent
    blind = math.sqrt(2.0 * height / ((1.0 - limits.blind_thrust) * GRAVITY))
    for option, found, least in (("landing", limits.landing, steered), ("blind", limits.blind, blind)):
        if not found > least:
            raise ShapeError(
                f"limits: from the fence's top the motors would be cut in the air: expected {option} above {least:.1f} "
                f"s for a fence {height:.1f} m high, found {found:g}"
            )


@dataclass(frozen=True, eq=False)
class Condition:
    """What the verdict follows from.

    Args:
        pose_age, attitude_age: s since each has arrived.
        position: m, world axes ``# (3,)``.
        attitude: quaternion w x y z, body→world ``# (4,)``.
        battery: greatest voltage of the last ``battery_time``, V.
        flags: what the robot says of itself, as of :class:`hardware.interfaces.Reading`.
        late: s that the action is late.
        overruns: actions in a row that came after their period.
        action_is_finite: whether the controller's action is numbers throughout.
        asked: why somebody wants the flight to end ("Ctrl-C"), empty where nobody does.
    """

    pose_age: float
    attitude_age: float
    position: Array
    attitude: Array
    battery: float
    flags: frozenset[str] = frozenset({"can_fly"})
    late: float = 0.0
    overruns: int = 0
    action_is_finite: bool = True
    asked: str = ""


@dataclass(frozen=True)
class Judgement:
    """A verdict, its reason in words (empty for GO), and the remedy where the reason is not what was commanded."""

    verdict: Verdict
    reason: str = ""
    remedy: str = ""


def judge(condition: Condition, limits: Limits) -> Judgement:
    """The verdict on one moment of a flight."""
    for flag in CUTS:
        if flag in condition.flags:
            return Judgement(Verdict.CUT, f"the robot says it is {flag}")
    angle = tilt_of(condition.attitude)
    if fresh(condition.attitude_age, limits.attitude_age) and angle > limits.upside_down:
        return Judgement(Verdict.CUT, f"upside down: tilted by {math.degrees(angle):.0f}°")
    late, row = condition.late, condition.overruns
    found = (
        (condition.asked, ""),
        (blind_reason(condition, limits), "look at the radio and motion capture"),
        (outside(condition.position, limits.low, limits.high), ""),
        ("" if angle <= limits.tilt else f"tilted by {math.degrees(angle):.0f}°", ""),
        (
            "" if condition.battery >= limits.battery else f"battery low: {condition.battery:.2f} V",
            "change the battery",
        ),
        ("" if late <= limits.late else f"no action for {late:.2f} s after it was due", ""),
        ("" if row <= limits.overruns else f"{row} actions in a row were late", ""),
        ("" if condition.action_is_finite else "the controller gave no action of finite numbers", ""),
    )
    reason, remedy = next((each for each in found if each[0]), ("", ""))
    return Judgement(Verdict.LAND if reason else Verdict.GO, reason, remedy)


def blind_reason(condition: Condition, limits: Limits) -> str:
    """Why a landing cannot be steered, empty where it can."""
    if LOST in condition.flags:
        return LINK_ENDED
    if not knows_attitude(condition, limits):
        return f"no attitude from the robot for {condition.attitude_age:.2f} s"
    if not knows_position(condition, limits):
        return f"no pose from motion capture for {condition.pose_age:.2f} s"
    return ""


def knows_position(condition: Condition, limits: Limits) -> bool:
    """Whether there is a fresh position that is one."""
    return fresh(condition.pose_age, limits.pose_age) and bool((np.abs(condition.position) < FAR).all())


def knows_attitude(condition: Condition, limits: Limits) -> bool:
    """Whether there is a fresh attitude that is one."""
    return fresh(condition.attitude_age, limits.attitude_age) and not math.isnan(tilt_of(condition.attitude))


def tilt_of(attitude: Array) -> float:
    """Angle in rad between the z axes of body and world, of a quaternion ``# (4,)``; NaN where that is none."""
    w, x, y, z = attitude.tolist()
    square = w * w + x * x + y * y + z * z
    if not 0.5 < square < 2.0:
        return math.nan
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y) / square)))


def fresh(age: float, limit: float) -> bool:
    """Whether data of an age in s is new enough, and not from a clock that went backwards."""
    return -CLOCK_SLACK <= age <= limit


def outside(place: Array, low: Sequence[float], high: Sequence[float]) -> str:
    """Where a place ``# (axes,)`` in m is outside the fence's corners, empty where it is inside."""
    along = zip(place.tolist(), low, high, strict=True)
    for axis, (value, least, most) in zip("xyz", along, strict=False):
        if not least <= value <= most:
            return f"outside the fence: {axis} = {value:.2f} m"
    return ""
