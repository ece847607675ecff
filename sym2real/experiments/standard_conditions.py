"""What every run of the standard set suffers beside its effects: noise, disturbances, trim, and an ignorant analyst.

Sensors are noisy, and velocity is the difference of noisy positions. Disturbances are Ornstein–Uhlenbeck processes.
Trim differs from run to run. Some numbers of the plant differ from the nominal ones over the whole data set.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

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
    layout = robot.layouts.state
    free = layout.has_field(POSITION.name)
    coordinates = POSITION.columns if free else layout.joints
    places = [layout.index(name) for name in coordinates if name in layout]
    rates = [layout.index(layout.rates[name]) for name in coordinates if name in layout]
    units = [layout.units[layout.columns[place]] for place in places]
    deviations = np.array([noise.position if unit == "m" else noise.joint for unit in units])
    facing = Layout(tuple(field for field in layout.fields if field.name in ("attitude", "heading")))
    turned, gyro = layout.indices(facing), layout.indices(layout.field("rate").columns if free else ())

    def begin() -> Filter:
        """Sensors that have measured nothing yet: rates by differences need what was measured before."""
        before: list[Array] = []

        def measure(state: Array) -> Array:
            """What is measured of a true state ``# (state,)``, m, rad, m/s, rad/s."""
            result = state.copy()
            if turned:
                angles = torch.from_numpy(noise.angle * rng.standard_normal(facing.tangent_size))
                result[turned] = facing.retract(torch.from_numpy(state[turned]), angles).numpy()
            result[places] += deviations * rng.standard_normal(len(places))
            result[gyro] += noise.rate * rng.standard_normal(len(gyro))
            # Before the first row there is one more, where a constant velocity would have it.
            first = state[places] - robot.dt * state[rates] + deviations * rng.standard_normal(len(places))
            result[rates] = (result[places] - (before[0] if before else first)) / robot.dt
            before[:] = [result[places].copy()]
            return result

        return measure

    return Change("sensor noise", measure=begin)
