"""What a fused step of MPPI computes, and what of its sampling is fixed in the text."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr
from torch import Tensor

from sym2real.control.fused_filters import FilterLines
from sym2real.control.fused_residual import Network
from sym2real.robots.robot import MPPISettings, Robot
from sym2real.symbolic.equations import Equations


@dataclass(frozen=True)
class Sampling:
    """What of the sampling is fixed in the text.

    Args:
        colour: 0 white, 1 first-order correlated, 2 through a matrix.
        diagonal: the noise of the actions is independent.
    """

    colour: int
    diagonal: bool

    @classmethod
    def of(cls, settings: MPPISettings, factor: Tensor) -> Sampling:
        """The sampling of these settings with noise of covariance C Cᵀ."""
        colour = 2 if settings.knots else 1 if settings.correlation > 0 else 0
        return cls(colour, bool((factor == factor.diag().diag()).all()))


@dataclass(frozen=True)
class Fused:
    """What a fused step computes.

    Args:
        equations: with their parameter values, which become constants.
        robot: limits, columns and control period.
        cost: running cost over state, action and ``ref_<column>``.
        sampling: what of it is fixed.
        filters: what actions go through.
        residual: a network that adds to the next state; None for none.
    """

    equations: Equations
    robot: Robot
    cost: Expr
    sampling: Sampling
    filters: FilterLines
    residual: Network | None = None
