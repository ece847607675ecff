"""Pure pursuit and speed for a car, forward and in reverse.

The car follows the arc that is tangent to its heading and passes through a point ahead on the reference,
(x, y) in body axes::

    κ = 2 y / (x² + y²),   steer = atan(L κ)

The same arc holds in reverse, where the point lies behind. The speed is the reference's, signed along the heading,
plus a gain times the distance still missing.
Source: R. C. Coulter, "Implementation of the Pure Pursuit Path Tracking Algorithm", CMU-RI-TR-92-01, 1992.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.protocols import Memoryless
from sym2real.trajectory import Array

STANDING = 0.05  # m/s: a reference slower than this is a place to park at, not a path to follow


@dataclass(frozen=True)
class PurePursuit(Memoryless):
    """Controller of test drives; it knows a wheelbase, not a model.

    Args:
        wheelbase: m.
        low: least action: steering in rad, speed in m/s ``# (2,)``.
        high: greatest action ``# (2,)``.
        dt: control period in s.
        reference: full state ``# (..., 7)`` wanted at a time in s ``# (...,)``: a task's ``reference``.
        lookahead: how far ahead in time the pursued point lies, s.
        gain: speed per distance missing, 1/s.
        tolerance: distance to a place to park at that counts as arrived, m.
    """

    wheelbase: float
    low: ArrayLike
    high: ArrayLike
    dt: float
    reference: Callable[[Tensor], Tensor]
    lookahead: float = 0.5
    gain: float = 1.5
    tolerance: float = 0.03

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Steering in rad and speed in m/s ``# (2,)`` for a state ``# (7,)`` at time ``step · dt``."""
        measured = np.asarray(state, dtype=np.float64)
        times = step * self.dt + torch.tensor([0.0, self.lookahead], dtype=torch.float64)
        here, ahead = self.reference(times).to(torch.float64).numpy()
        missing = to_body(here[0:2] - measured[0:2], measured)
        target = to_body(ahead[0:2] - measured[0:2], measured)
        pace = to_body(here[4:6], measured)
        distance = float(np.hypot(*target))
        if np.hypot(*pace) < STANDING:
            speed = 0.0 if distance < self.tolerance else self.gain * float(np.copysign(distance, target[0]))
        else:
            speed = float(np.copysign(np.hypot(*pace), pace[0])) + self.gain * float(missing[0])
        curvature = 2 * target[1] / max(distance, self.tolerance) ** 2
        action: Array = np.clip([np.arctan(self.wheelbase * curvature), speed], self.low, self.high)
        return action


def to_body(vector: Array, state: Array) -> Array:
    """World vector ``# (2,)`` in the axes of a car in this state ``# (7,)``: forward, left."""
    sine, cosine = state[2], state[3]
    return np.array([cosine * vector[0] + sine * vector[1], cosine * vector[1] - sine * vector[0]])
