"""Linear-quadratic regulator about a reference, for any robot whose equations are known.

At the robot's start and its action at rest, Δx' = A Δx + B Δu in the state's tangent; K solves the discrete Riccati
equation, and u = u_rest - K (x ⊖ x_ref). It holds a pole upright, an arm at its posture, a rotorcraft in hover.
"""

from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
import torch
from numpy.typing import ArrayLike
from scipy.linalg import solve_discrete_are
from torch import Tensor

from sym2real.control.at_steps import AtSteps
from sym2real.errors import ModelError
from sym2real.protocols import Memoryless
from sym2real.robots import Robot
from sym2real.symbolic import Equations, compile_model
from sym2real.tasks.task import Reference
from sym2real.trajectory import Array

STEP = 1e-5  # of the tangent and of commands, for derivatives in double precision
# Weights by the unit of a component, and of a command that uses its whole range.
PLACE, SPEED, EFFORT = 1.0, 0.1, 0.1


@dataclass
class LinearQuadratic(Memoryless):
    """A :class:`~sym2real.protocols.Controller`.

    Args:
        robot: gives limits, start and rest.
        reference: wanted state over time in s, of time alone.

    Raises:
        ModelError: where the linearised robot cannot be stabilised.
    """

    robot: Robot
    reference: Reference
    gain: Array = field(init=False)

    def __post_init__(self) -> None:
        self.gain = _gain(self.robot)

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Action ``# (action,)`` for a measured state ``# (state,)``, within the limits."""
        measured = torch.as_tensor(np.asarray(state, dtype=np.float64))
        away = self.robot.layouts.state.difference(measured, self._wanted[step]).numpy()
        clipped: Array = np.clip(self.robot.rest - self.gain @ away, self.robot.low, self.robot.high)
        return clipped

    @cached_property
    def _wanted(self) -> AtSteps[Tensor]:
        return AtSteps(lambda times: self.reference(times).unbind(), self.robot.dt)


@lru_cache(maxsize=8)
def _gain(robot: Robot) -> Array:
    """K ``# (action, tangent)``; kept, because the equations of an arm take seconds, and every log is flown."""
    slope, effect = linearised(robot.nominal(), robot)
    layout, span = robot.layouts.state, robot.high - robot.low
    units = [field.unit for field in layout.fields for _ in range(field.tangent_size)]
    weight = np.diag([SPEED if unit.endswith("/s") else PLACE for unit in units])
    try:
        cost = solve_discrete_are(slope, effect, weight, np.diag(EFFORT / span**2))
    except (np.linalg.LinAlgError, ValueError) as error:
        raise ModelError(f"{robot.name}: expected a robot that commands can hold at its start, found none") from error
    inner = np.diag(EFFORT / span**2) + effect.T @ cost @ effect
    return np.asarray(np.linalg.solve(inner, effect.T @ cost @ slope), dtype=np.float64)


def linearised(equations: Equations, robot: Robot) -> tuple[Array, Array]:
    """A ``# (tangent, tangent)`` and B ``# (tangent, action)`` at start and rest, by central differences."""
    layout, model = robot.layouts.state, compile_model(equations, dtype=torch.float64)
    start, rest = torch.as_tensor(robot.start), torch.as_tensor(robot.rest)
    held = torch.zeros(equations.layouts.inputs.size, dtype=torch.float64)

    def after(moves: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        states = layout.retract(start.expand(len(moves), -1), moves)
        following: torch.Tensor = model(states, rest + action, held.expand(len(moves), -1))
        return following

    def slope(of_state: bool, size: int) -> Array:
        unit, other = STEP * torch.eye(size, dtype=torch.float64), layout.tangent_size
        still = torch.zeros(size, rest.numel() if of_state else other, dtype=torch.float64)
        ends = [after(side * unit, still) if of_state else after(still, side * unit) for side in (1.0, -1.0)]
        return (layout.difference(*ends) / (2.0 * STEP)).T.numpy()

    return slope(True, layout.tangent_size), slope(False, rest.numel())
