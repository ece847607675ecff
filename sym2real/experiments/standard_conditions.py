"""What every run of the standard set suffers beside its effects: noise, disturbances, trim, and an ignorant analyst.

Sensors are noisy, and velocity is the difference of noisy positions. Disturbances are Ornstein–Uhlenbeck processes.
Trim differs from run to run. Some numbers of the plant differ from the nominal ones over the whole data set.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from sym2real.effects import effect
from sym2real.experiments.excitation import ColouredNoise
from sym2real.layout import Layout
from sym2real.protocols import Change, Filter
from sym2real.robots import Robot
from sym2real.tasks.task import flies
from sym2real.trajectory import Array
from sym2real.vocabulary import POSITION

POSITION_NOISE = 0.5e-3  # m
ANGLE_NOISE = float(np.deg2rad(0.3))
GYRO_NOISE = 0.02  # rad/s
ENCODER_NOISE = 1e-3  # rad
FORCE = np.array([1.5e-3, 1.5e-3, 1e-3])  # N, world axes
FORCE_TIME, TORQUE_TIME = 0.3, 0.1  # s
TORQUE = np.full(3, 1e-6)  # N m, body axes
COMMANDS = np.array([0.006, 0.01])  # rad, m/s: steering, speed
COMMANDS_TIME = 0.3  # s
FLIGHT_TRIM = {"gain:thrust": {"value": 0.004}, "mounting_tilt": {"roll": np.deg2rad(0.1), "pitch": np.deg2rad(0.1)}}
DRIVE_TRIM = {
    "offset:steer": {"value": 0.004},
    "gain:speed": {"value": 0.004},
    "yaw_bias": {"value": np.deg2rad(0.15)},
}
UNKNOWN = 0.1
LOOP = ("wx", "wy", "wz")


def unknown(robot: Robot, rng: np.random.Generator) -> Change:
    """Numbers of the plant that the analyst's nominal has wrong, once per data set."""
    first, second = 1.0 + rng.uniform(-UNKNOWN, UNKNOWN, 2)

    def edit_flight(spec: Any) -> None:
        """Inertia, and the gain of the rate loop, which the actuators of the description hold."""
        body = spec.worldbody.first_body()
        body.inertia = first * np.array(body.inertia)
        for actuator in spec.actuators:
            if actuator.name in LOOP:
                actuator.gainprm = second * np.array(actuator.gainprm)
                actuator.biasprm = second * np.array(actuator.biasprm)

    def edit_drive(spec: Any) -> None:
        """Time constant of every contact (``solref``, s): how soft tyres and ground are."""
        for geom in spec.geoms:
            geom.solref = [first * geom.solref[0], geom.solref[1]]

    return Change("", edit=edit_flight if flies(robot) else edit_drive)


def trim(robot: Robot, rng: np.random.Generator) -> tuple[Change, ...]:
    """What differs from run to run, uniform."""
    table = FLIGHT_TRIM if flies(robot) else DRIVE_TRIM
    changes = []
    for key, widths in table.items():
        trimmed = effect(key, robot)
        drawn = {name: trimmed.null[name] + rng.uniform(-width, width) for name, width in widths.items()}
        changes.append(trimmed.inject(**drawn))
    return tuple(changes)


def disturbance(robot: Robot, rng: np.random.Generator) -> Change:
    """Force and torque on a quadrotor; noise of steering and speed on a car, behind its commands."""
    if flies(robot):
        return Change("", force=_push(robot, rng))
    noise = ColouredNoise(COMMANDS, COMMANDS_TIME, robot.dt, rng)
    return Change("", command=lambda: lambda action: action + noise.next())


def _push(robot: Robot, rng: np.random.Generator) -> Callable[[Any, Any], None]:
    """Held over a control period, which is short beside the processes' time constants."""
    force = ColouredNoise(FORCE, FORCE_TIME, robot.dt, rng)
    torque = ColouredNoise(TORQUE, TORQUE_TIME, robot.dt, rng)
    held = [force.next(), torque.next()]
    calls = 0

    def push(_: Any, data: Any) -> None:
        """Force (N) along world axes; torque (N m) turned there from body axes, as ``xfrc_applied`` has it."""
        nonlocal calls
        calls += 1
        if calls % robot.substeps == 0:
            held[:] = force.next(), torque.next()
        data.xfrc_applied[1, :3] += held[0]
        data.xfrc_applied[1, 3:] += data.xmat[1].reshape(3, 3) @ held[1]

    return push


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of white noise: position in m, attitude or heading in rad, rates in rad/s, joints in rad."""

    position: float = POSITION_NOISE
    angle: float = ANGLE_NOISE
    rate: float = GYRO_NOISE
    joint: float = ENCODER_NOISE


STANDARD_NOISE = SensorNoise()


def sensors(robot: Robot, rng: np.random.Generator, noise: SensorNoise = STANDARD_NOISE) -> Change:
    """Measured states: white noise on position, attitude and gyro; velocity by differences of measured positions.

    Of a robot of joints alone: white noise on every coordinate, rates by differences of measured coordinates.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> plant = MujocoPlant(robot, [sensors(robot, np.random.default_rng(0))])
        >>> bool((plant.reset(robot.start) != robot.start).any())
        True
    """
    if robot.layouts.state.joints and not robot.layouts.state.has_field(POSITION.name):
        return _encoders(robot, rng, noise)
    layout, add_angle = robot.layouts.state, _angle_noise(robot, noise.angle)
    position, velocity, rate = layout.slice("position"), layout.slice("velocity"), layout.slice("rate")

    def begin() -> Filter:
        """A sensor that has measured nothing yet: velocity needs the position measured before."""
        before: list[Array] = []

        def measure(state: Array) -> Array:
            """What is measured of a true state ``# (state,)``, m, rad, m/s, rad/s."""
            result = add_angle(state, rng)
            result[position] += noise.position * rng.standard_normal(position.stop - position.start)
            result[rate] += noise.rate * rng.standard_normal(rate.stop - rate.start)
            # Before the first row there is one more, where a constant velocity would have it.
            first = noise.position * rng.standard_normal(position.stop - position.start)
            earlier = before[0] if before else state[position] - robot.dt * state[velocity] + first
            result[velocity] = (result[position] - earlier) / robot.dt
            before[:] = [result[position].copy()]
            return result

        return measure

    return Change("sensor noise", measure=begin)


def _encoders(robot: Robot, rng: np.random.Generator, noise: SensorNoise) -> Change:
    """Sensors of joints; a rate is known from the second row on, before which it is the true one."""
    layout = robot.layouts.state
    places, rates = layout.indices(layout.joints), layout.indices(layout.rates[joint] for joint in layout.joints)
    deviations = np.array([noise.position if layout.units[joint] == "m" else noise.joint for joint in layout.joints])

    def begin() -> Filter:
        """Sensors that have measured nothing yet."""
        before: list[Array] = []

        def measure(state: Array) -> Array:
            """What is measured of a true state ``# (state,)``."""
            result = state.copy()
            result[places] += deviations * rng.standard_normal(len(places))
            first = state[places] - robot.dt * state[rates] + deviations * rng.standard_normal(len(places))
            result[rates] = (result[places] - (before[0] if before else first)) / robot.dt
            before[:] = [result[places].copy()]
            return result

        return measure

    return Change("sensor noise", measure=begin)


def _angle_noise(robot: Robot, deviation: float) -> Callable[[Array, np.random.Generator], Array]:
    layout: Layout = robot.layouts.state

    def turn(state: Array, rng: np.random.Generator) -> Array:
        result = state.copy()
        place = layout.slice("attitude")
        result[place] = _turned(state[place], deviation * rng.standard_normal(3))
        return result

    def steer(state: Array, rng: np.random.Generator) -> Array:
        result = state.copy()
        place = layout.slice("heading")
        yaw = np.arctan2(*state[place]) + deviation * rng.standard_normal()
        result[place] = np.sin(yaw), np.cos(yaw)
        return result

    return turn if flies(robot) else steer


def _turned(quaternion: Array, vector: Array) -> Array:
    """The quaternion turned by a small rotation vector in body axes, rad."""
    angle = max(float(np.linalg.norm(vector)), 1e-12)
    w, v = float(quaternion[0]), quaternion[1:]
    scalar, axis = np.cos(angle / 2), np.sin(angle / 2) / angle * vector
    (a, b, c), (d, e, f) = v.tolist(), axis.tolist()
    across = np.array([b * f - c * e, c * d - a * f, a * e - b * d])
    turned: Array = np.concatenate([[w * scalar - v @ axis], w * axis + scalar * v + across])
    return turned
