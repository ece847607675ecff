"""Geometric tracking of a position and a heading for a quadrotor with thrust and body-rate commands.

Desired acceleration, and with it the desired thrust direction and attitude (world axes, g upward)::

    a = a* + K_p (p* - p) + K_v (v* - v) + g e_z
    z = a / |a|,   y = z × (cos ψ, sin ψ, 0) / |…|,   R* = [y × z, y, z]

Commands::

    thrust = m a · R e_z                          (N)
    rates  = R^T R* ω* - K_R (R*^T R - R^T R*)^∨ / 2   (rad/s, body axes)

ω* turns the thrust direction with the jerk of the reference, and with its heading.
Sources: T. Lee, M. Leok, N. H. McClamroch, "Geometric tracking control of a quadrotor UAV on SE(3)", CDC 2010;
ω* from D. Mellinger, V. Kumar, "Minimum snap trajectory generation and control for quadrotors", ICRA 2011.
The moment loop of Lee et al. is left to the rate loop on board.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.control.at_steps import AtSteps
from sym2real.protocols import Memoryless
from sym2real.robots.robot import GRAVITY
from sym2real.rotation import axes, yaw
from sym2real.trajectory import Array

UP = np.array([0.0, 0.0, 1.0])
# Reference velocities are differentiated over this half-step, s: one control period, so that a corner of the
# reference asks for a rate that the vehicle can give.
HALF_STEP = 0.02
MOST_FEEDBACK = 8.0  # m/s²: far from the reference the vehicle leans by about 40°, no further
LEAST_PULL = 2.0  # m/s²: the thrust direction never points at the ground


@dataclass(frozen=True)
class Gains:
    """Feedback gains; the position poles lie at about -2.6 ± 1.1i 1/s, well inside those of the attitude.

    Args:
        position: 1/s² of acceleration per m.
        velocity: 1/s of acceleration per m/s.
        attitude: rad/s of rate per rad.
    """

    position: float = 8.0
    velocity: float = 5.2
    attitude: float = 12.0


@dataclass(frozen=True)
class GeometricQuadrotor(Memoryless):
    """Controller of test flights, take-off and landing. It knows a mass, not a model.

    Args:
        mass: kg.
        low: least action: thrust in N, body rates in rad/s ``# (4,)``.
        high: greatest action ``# (4,)``.
        dt: control period in s.
        reference: full state ``# (..., 13)`` wanted at a time in s ``# (...,)``: a task's, of time alone.
        yaw_rate: turns the reference's heading further, rad/s.
        gains: feedback gains.
    """

    mass: float
    low: ArrayLike
    high: ArrayLike
    dt: float
    reference: Callable[[Tensor], Tensor]
    yaw_rate: float = 0.0
    gains: Gains = Gains()

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Thrust in N and body rates in rad/s ``# (4,)`` for a state ``# (13,)`` at time ``step · dt``."""
        measured = np.asarray(state, dtype=np.float64)
        attitude = body_axes(measured[3:7])
        goal = self._points[step]
        feedback = self.gains.position * (goal.position - measured[0:3])
        feedback += self.gains.velocity * (goal.velocity - measured[7:10])
        feedback *= min(1.0, MOST_FEEDBACK / max(float(np.linalg.norm(feedback)), 1e-9))
        pull = goal.acceleration + feedback + GRAVITY * UP
        pull[2] = max(pull[2], LEAST_PULL)
        heading = goal.yaw + self.yaw_rate * step * self.dt
        wanted = attitude_along(pull, heading)
        error = wanted.T @ attitude - attitude.T @ wanted
        spin = turning_rate(wanted, goal.jerk, float(np.linalg.norm(pull)), goal.yaw_rate + self.yaw_rate)
        tilt_error = np.array([error[2, 1], error[0, 2], error[1, 0]]) / 2
        rates = attitude.T @ wanted @ spin - self.gains.attitude * tilt_error
        action: Array = np.clip([self.mass * pull @ attitude[:, 2], *rates], self.low, self.high)
        return action

    @cached_property
    def _points(self) -> AtSteps[ReferencePoint]:
        return AtSteps(partial(reference_points, self.reference), self.dt)


@dataclass(frozen=True)
class ReferencePoint:
    """A reference and its derivatives at one time: world axes, SI, yaw in rad."""

    position: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    yaw: float
    yaw_rate: float


def reference_points(reference: Callable[[Tensor], Tensor], times: Tensor) -> list[ReferencePoint]:
    """A reference at times in s ``# (n,)``; acceleration and jerk by central differences of its velocity."""
    around = times + torch.tensor([[-HALF_STEP], [0.0], [HALF_STEP]], dtype=torch.float64)
    states = reference(around).to(torch.float64)  # (3, n, 13)
    before, here, after = states.numpy()
    acceleration = (after - before)[:, 7:10] / (2 * HALF_STEP)
    jerk = (after - 2 * here + before)[:, 7:10] / HALF_STEP**2
    columns = here[:, 0:3], here[:, 7:10], acceleration, jerk, yaw(states[1, :, 3:7]).tolist(), here[:, 12].tolist()
    return [ReferencePoint(*row) for row in zip(*columns, strict=True)]


def body_axes(attitude: Array) -> Array:
    """Rotation matrix ``# (3, 3)``, columns are the body axes in the world, of a unit quaternion ``# (4,)``."""
    return np.array([*zip(*axes(attitude.tolist()), strict=True)])


def cross(left: Array, right: Array) -> Array:
    """Cross product of two vectors ``# (3,)``; NumPy's own takes most of a control step."""
    (a, b, c), (d, e, f) = left.tolist(), right.tolist()
    return np.array([b * f - c * e, c * d - a * f, a * e - b * d])


def attitude_along(pull: Array, heading: float) -> Array:
    """Rotation matrix ``# (3, 3)`` whose z axis points along ``pull`` ``# (3,)`` at this heading in rad."""
    z_axis = pull / max(float(np.linalg.norm(pull)), 1e-9)
    across = cross(z_axis, np.array([np.cos(heading), np.sin(heading), 0.0]))
    y_axis = across / max(float(np.linalg.norm(across)), 1e-9)
    return np.column_stack([cross(y_axis, z_axis), y_axis, z_axis])


def turning_rate(attitude: Array, jerk: Array, pull: float, yaw_rate: float) -> Array:
    """Body rates ``# (3,)`` in rad/s that keep thrust along an acceleration that changes with ``jerk``."""
    across = jerk / max(pull, 1e-9)  # its part along z changes the thrust alone, and is dropped by the projections
    return np.array([-across @ attitude[:, 1], across @ attitude[:, 0], yaw_rate * attitude[2, 2]])
