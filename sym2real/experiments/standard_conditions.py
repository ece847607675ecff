"""Noise and disturbances of simulated runs: sensors are noisy, and velocity is the difference of noisy positions.

Disturbances are Ornstein–Uhlenbeck processes; those of the standard set are in ``tools/bench/standard_trim.py``.
"""

from dataclasses import dataclass

import numpy as np
import torch

from sym2real.layout import Layout
from sym2real.protocols import Change, Filter
from sym2real.robots import Robot
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
