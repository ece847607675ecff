"""Thrust per unit of command, from the first seconds of a log."""

import numpy as np
import torch

from sym2real.errors import ModelError
from sym2real.layout import motors_of
from sym2real.robots.motors import MotorUnit
from sym2real.robots.robot import GRAVITY
from sym2real.rotation import rotate
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import ATTITUDE, VELOCITY


def fit_thrust_per_unit(trajectory: Trajectory, seconds: float = 2.0, unit: MotorUnit = "command") -> float:
    """Acceleration along body z per unit of command, m/s² per unit; times the mass it is N per unit.

    Of motors in rad/s it is that per squared speed, m/rad² (k_f ω² is their thrust).

    Least squares over the first ``seconds`` of v(t) = v₀ + k ∫ u R e₃ dt - g t e₃ for k and v₀, which needs no
    difference of noisy velocities. The unit u is what the log holds: ``thrust``, or the sum of ``motor1`` … ``motor4``,
    of speeds the sum of their squares.

    Raises:
        ModelError: when the log is shorter than ten rows of that time or without thrust.
        UnknownNameError: when it has neither thrust nor motors, or no attitude.
    """
    rows = int(np.searchsorted(trajectory.time, trajectory.time[0] + seconds)) + 1
    first = trajectory.rows(0, rows)
    if len(first) < 10:
        raise ModelError(f"thrust per unit needs ten rows in the first {seconds:g} s, found {len(first)}")
    time = first.time - first.time[0]
    thrust = _command(first, unit)[:, None] * _body_z(first)  # (rows, 3)
    impulse = np.concatenate([np.zeros((1, 3)), np.cumsum(thrust[:-1] * np.diff(time)[:, None], axis=0)])
    velocity = np.stack([first.column(name) for name in VELOCITY.columns], axis=1)
    velocity[:, 2] += GRAVITY * time
    # v₀ is the mean of what the impulse does not explain, so centring removes it.
    impulse, velocity = impulse - impulse.mean(0), velocity - velocity.mean(0)
    if not (impulse**2).sum() > 0:
        raise ModelError(f"no thrust in the first {seconds:g} s of {trajectory.name!r}")
    return float((impulse * velocity).sum() / (impulse**2).sum())


def _command(trajectory: Trajectory, unit: MotorUnit) -> Array:
    if motors := motors_of(trajectory.layouts.action):
        power = 2 if unit == "rad/s" else 1
        total: Array = np.sum([trajectory.column(name) ** power for name in motors], axis=0)
        return total
    return trajectory.column("thrust")


def _body_z(trajectory: Trajectory) -> Array:
    quaternion = np.stack([trajectory.column(name) for name in ATTITUDE.columns], axis=1)
    return rotate(torch.as_tensor(quaternion), torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64)).numpy()
