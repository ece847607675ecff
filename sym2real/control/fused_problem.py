"""What a fused step of MPPI computes."""

from dataclasses import dataclass

from sympy import Expr

from sym2real.control.fused_filters import FilterLines
from sym2real.control.fused_residual import Network
from sym2real.robots.robot import Robot
from sym2real.symbolic.equations import Equations


@dataclass(frozen=True)
class Fused:
    """What a fused step computes.

    Args:
        equations: with their parameter values, which become constants.
        robot: limits, columns, control period, and how its commands are sampled.
        cost: running cost over state, action and ``ref_<column>``.
        filters: what actions go through.
        residual: a network that adds to the next state; None for none.
    """

    equations: Equations
    robot: Robot
    cost: Expr
    filters: FilterLines
    residual: Network | None = None

    @property
    def colour(self) -> int:
        """Of the noise along the horizon: 0 white, 1 first-order correlated, 2 through a matrix."""
        return 2 if self.robot.mppi.knots else 1 if self.robot.mppi.correlation > 0 else 0
