"""What logs lack that would tell effects apart (turns of yaw, changes of thrust, dither, circles), and what to fly."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np

from sym2real.layout import Layout, motors_of, turned_by_motors
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import ATTITUDE, VELOCITY

# Length of the mean heading vector above which yaw stays (standard deviation below 0.46 rad).
STEADY_YAW = 0.9
# Relative standard deviation of the thrust below which it stays: an offset then differs from a gain by a tenth.
STEADY_THRUST = 0.1
# That below which it is one value: a curve through the hover thrust differs from a gain by all of its slope.
CONSTANT_THRUST = 0.01
# Standard deviation of rate commands from row to row that counts as dither, rad/s (DIAGNOSIS: 0.15 and more separate).
DITHER = 0.15
# Share of commands in one direction, and least speed (m/s) at which a car's circle is looked at.
SINGLE_DIRECTION, MOVING = 0.95, 0.2
# Squared cosine between a lever arm's and a yaw bias's sideways velocity from which on they count as one.
SINGLE_CIRCLE = 0.5
# Interquartile range of the speed, by its median, below which a flight or drive has one speed.
STEADY_SPEED = 0.25
# Steering angle (rad) whose tangent is larger by a hundredth.
SMALL_ANGLE = 0.17
# Lateral acceleration (m/s²) that tyres hold (DIAGNOSIS: grip shows from 2.7 on).
GRIP = 2.7
# What shows effects that are late, and how a robot with such a field of commands is commanded to do it.
EXCITED = "dither of the commands (rates: above 0.15 rad/s), or steps of them"
EXCITED_BY = {
    "rate command": "dither of the rate commands above 0.15 rad/s",
    "attitude command": "dither of the attitude command",
    "motors": "dither of the motors, each on its own",
    "steering": "steps of steering and speed",
}
# White noise to its third difference.
THIRD_DIFFERENCE = np.sqrt(20.0)

Condition = Callable[[Sequence[Trajectory]], bool]


def in_words_of(action: Layout, advice: str) -> str:
    """A sentence with the commands that a robot has in place of :data:`EXCITED`."""
    words = [EXCITED_BY[field.name] for field in action.fields if field.name in EXCITED_BY]
    return advice.replace(EXCITED, words[0]) if words else advice


def always(logs: Sequence[Trajectory]) -> bool:
    """True on every flight."""
    return True


def no_motor_torques(logs: Sequence[Trajectory]) -> bool:
    """Whether no motor's torque shows in what is predicted: else it tells a motor's strength from the robot's mass."""
    return not any(turned_by_motors(log.layouts) for log in logs)


def steady_yaw(logs: Sequence[Trajectory]) -> bool:
    """Whether a quadrotor looks one way: a force from the ground then looks like a tilted sensor."""
    if not (columns := _joined(logs, ATTITUDE.columns)):
        return False
    w, x, y, z = columns
    heading = np.exp(1j * np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
    return bool(abs(heading.mean()) > STEADY_YAW)


def _varies_less(logs: Sequence[Trajectory], part: float) -> bool:
    values = [_thrust(log) for log in logs]
    if not values or any(len(value) == 0 for value in values):
        return False
    together = np.concatenate(values)
    return bool(together.std() < part * abs(together.mean()))


def _alone(logs: Sequence[Trajectory], shown: Condition) -> bool:
    return no_motor_torques(logs) and shown(logs)


# Whether the thrust command hardly varies, or not at all; and whether nothing else shows how strong motors are.
steady_thrust, constant_thrust = (partial(_varies_less, part=part) for part in (STEADY_THRUST, CONSTANT_THRUST))
steady_thrust_alone, constant_thrust_alone = (partial(_alone, shown=rule) for rule in (steady_thrust, constant_thrust))


def steady_speed(logs: Sequence[Trajectory]) -> bool:
    """Whether half of the time is spent close to one speed."""
    names = [name for name in VELOCITY.columns if all(name in log.layouts.state for log in logs)]
    if not names or not logs:
        return False
    low, middle, high = np.quantile(np.linalg.norm(_joined(logs, names), axis=0), (0.25, 0.5, 0.75))
    return bool(high - low < STEADY_SPEED * middle)


def typical_speed(logs: Iterable[Trajectory]) -> float:
    """Median speed in m/s; zero of robots that tell no velocity."""
    velocities = [[log.column(name) for name in VELOCITY.columns if name in log.layouts.state] for log in logs]
    speeds = [np.linalg.norm(columns, axis=0) for columns in velocities if columns]
    return float(np.median(np.concatenate(speeds))) if speeds else 0.0


def small_steering(logs: Sequence[Trajectory]) -> bool:
    """Whether the tangent of nearly every steering angle is the angle, within a hundredth."""
    columns = _joined(logs, ("steer",))
    return bool(columns) and bool(np.quantile(np.abs(columns[0]), 0.95) < SMALL_ANGLE)


def tyres_hold(logs: Sequence[Trajectory]) -> bool:
    """Whether a car hardly ever turns hard enough to slide."""
    if not (columns := _joined(logs, ("vx", "vy", "wz", "steer"))):
        return False
    return bool(np.quantile(np.hypot(columns[0], columns[1]) * abs(columns[2]), 0.95) < GRIP)


def calm_rates(logs: Sequence[Trajectory]) -> bool:
    """Whether rate commands change smoothly."""
    names = ("wx_cmd", "wy_cmd")
    logs = [log for log in logs if _has(log, names) and len(log) > 3]
    if not logs:
        return False
    jumps = [np.diff(log.column(name), n=3).std() / THIRD_DIFFERENCE for log in logs for name in names]
    return bool(np.mean(jumps) < DITHER)


def single_direction(logs: Sequence[Trajectory]) -> bool:
    """Whether a car only ever drives forwards, or only backwards."""
    if columns := _joined([log for log in logs if "speed" in log.layouts.action], ["speed"]):
        speed = columns[0]
    elif columns := _joined(
        [log for log in logs if "acceleration" in log.layouts.action], ("vx", "vy", "cos_yaw", "sin_yaw")
    ):
        speed = columns[0] * columns[2] + columns[1] * columns[3]
    else:
        return False
    forward = float((speed > 0).mean())
    return max(forward, 1 - forward) > SINGLE_DIRECTION


def single_circle(logs: Sequence[Trajectory]) -> bool:
    """Whether yaw rate and speed go together, as on one circle: a lever arm then looks like a turned heading."""
    if not (columns := _joined(logs, ("sin_yaw", "cos_yaw", "vx", "vy", "wz"))):
        return False
    sine, cosine, vx, vy, rate = columns
    speed = vx * cosine + vy * sine
    speed, rate = speed[moving := abs(speed) > MOVING], rate[moving]
    return bool((speed @ rate) ** 2 > SINGLE_CIRCLE * (speed @ speed) * (rate @ rate))


def _thrust(log: Trajectory) -> Array:
    if "thrust" in log.layouts.action:
        return log.column("thrust")
    if motors := motors_of(log.layouts.action):
        total: Array = np.sum([log.column(name) for name in motors], axis=0)
        return total
    return np.zeros(0)


def _joined(logs: Sequence[Trajectory], names: Sequence[str]) -> list[Array]:
    """Columns of all logs one behind the other; none where there is no log, or one that lacks a column."""
    if not logs or not all(_has(log, names) for log in logs):
        return []
    return [np.concatenate([log.column(name) for log in logs]) for name in names]


def _has(log: Trajectory, names: Iterable[str]) -> bool:
    known = {*log.layouts.columns, *log.extra}
    return all(name in known for name in names)
