"""Simulated quadrotor flights as a log would hold them: noisy sensors, dithered commands, small pushes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import torch

from sym2real.control import Disturbed, GeometricQuadrotor
from sym2real.dataset import Dataset
from sym2real.effects import effect
from sym2real.experiments.excitation import ColouredNoise
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE
from sym2real.tasks import make_task
from sym2real.trajectory import Trajectory

# Effects left out of the search to keep tests short; each test file adds its own.
LEFT_OUT = (
    *("gain:*", "offset:*", "limit:*", "delay:*", "lag*", "motor_lag"),
    *("thrust_curve", "battery_sag", "ground_effect", "translational_lift"),
    *("torque_bias", "flapping_moment", "quadratic_drag"),
)
NOISE = {"position": 5e-4, "attitude": np.deg2rad(0.3), "rate": 0.02}


def flights(key: str = "", **values: float) -> Dataset:
    return flights_with(key, values)


def flights_with(key: str, values: dict[str, float], count: int = 4, steps: int = 220) -> Dataset:
    return flights_with_all({key: values} if key else {}, count, steps)


def flights_with_all(hidden: Mapping[str, Mapping[str, float]], count: int = 4, steps: int = 220) -> Dataset:
    chosen = tuple((key, tuple(values.items())) for key, values in hidden.items())
    return Dataset(_flown(chosen, index, steps) for index in range(count))


def flown(key: str, values: dict[str, float], index: int, steps: int) -> Trajectory:
    return _flown(((key, tuple(values.items())),), index, steps)


@cache
def _flown(hidden: tuple[tuple[str, tuple[tuple[str, float], ...]], ...], index: int, steps: int) -> Trajectory:
    """One flight; whoever asks for it again gets the same one, which nobody changes."""
    robot, rng = CRAZYFLIE, np.random.default_rng([5, index])
    name = ("hover", "circle", "lemniscate", "circle")[index % 4]
    task = make_task(name, robot)
    changes = [effect(key, robot).inject(**dict(values)) for key, values in hidden]
    tracking = GeometricQuadrotor(robot.mass, robot.low, robot.high, robot.dt, task.reference, yaw_rate=0.7)
    dither = ColouredNoise(np.array([0.005, 0.15, 0.15, 0.15]), 0.05, robot.dt, rng)
    push = ColouredNoise(np.array([1.5e-3, 1.5e-3, 1e-3, 1e-6, 1e-6, 1e-6]), 0.2, robot.dt, rng)
    wrench = np.array([push.next() for _ in range(steps)])
    episode = run_episode(
        MujocoPlant(robot, changes), Disturbed(tracking, dither.next, robot.low, robot.high), task,
        steps=steps, wrench=wrench, name=f"{name} {index}", seed=index,
    )  # fmt: skip
    return measured(episode, rng)


def measured(flown: Trajectory, rng: np.random.Generator) -> Trajectory:
    layout = flown.layouts.state
    deviation = np.concatenate([np.full(f.tangent_size, NOISE.get(f.name, 0.0)) for f in layout.fields])
    tangent = torch.as_tensor(deviation * rng.standard_normal((len(flown), layout.tangent_size)))
    state = layout.retract(torch.as_tensor(flown.state), tangent).numpy()
    velocity = layout.slice("velocity")
    state[1:, velocity] = np.diff(state[:, layout.slice("position")], axis=0) / CRAZYFLIE.dt
    return replace(flown, state=state, inputs=np.zeros_like(flown.inputs))
