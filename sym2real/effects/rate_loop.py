"""The on-board rate loop ω̇ = K (ω_cmd - ω) + τ/J over one held step, from the robot's J and K."""

import math
from dataclasses import dataclass

from sympy import Expr, Integer, exp

from sym2real.effects.body import Body
from sym2real.effects.wrench import AXES, uses
from sym2real.symbolic import Equations, symbol

NUMBERS = ("jx", "jy", "jz", "kx", "ky", "kz")


@dataclass(frozen=True)
class RateLoop:
    """One axis of the loop.

    Args:
        axis: "x", "y" or "z".
        inertia: J in kg m².
        gain: K in 1/s.
        dt: step in s.
    """

    axis: str
    inertia: float
    gain: float
    dt: float

    @property
    def rate(self) -> Expr:
        """The axis's body rate, rad/s."""
        return symbol(f"w{self.axis}")

    @property
    def command(self) -> Expr:
        """The commanded body rate, rad/s."""
        return symbol(f"w{self.axis}_cmd")

    @property
    def kept(self) -> float:
        """Share of a rate's distance from its command that is left after a step."""
        return math.exp(-self.gain * self.dt)

    @property
    def response(self) -> float:
        """Rate after a step per angular acceleration that acts throughout it, s."""
        return (1.0 - self.kept) / self.gain

    def mean_torque(self) -> Expr:
        """Mean torque of the loop over the step, N m."""
        share = (1.0 - self.kept) / (self.gain * self.dt)
        return self.inertia * self.gain * share * (self.command - self.rate)

    def torque_that_ends_at(self, rate: Expr) -> Expr:
        """Held torque with which the loop's rate is ``rate`` after the step, N m."""
        return self.inertia / self.response * (rate - self.command - self.kept * (self.rate - self.command))

    def with_gain(self, factor: Expr, reach: Expr | float, torque: Expr) -> Expr:
        """Torque to add so that the loop's gain is ``factor`` times K and its command ``reach`` times the command.

        Args:
            factor: on the gain.
            reach: on the command.
            torque: N m, that acts besides.
        """
        kept = exp(-self.gain * self.dt * factor)
        aim = reach * self.command
        end = aim + (self.rate - aim) * kept + torque / self.inertia * (1 - kept) / (self.gain * factor)
        return self.torque_that_ends_at(end) - torque


def rate_loops(body: Body, dt: float) -> tuple[RateLoop, RateLoop, RateLoop]:
    """The three axes of a body's rate loop.

    Raises:
        ModelError: when the body's numbers lack inertia or gains.
    """
    x, y, z = (RateLoop(axis, body.number(f"j{axis}"), body.number(f"k{axis}"), dt) for axis in AXES)
    return x, y, z


def other_torque(equations: Equations, axis: str) -> Expr:
    """What else turns the body: the wrench input's symbol, or zero where the equations do not use it."""
    return symbol(f"t{axis}") if uses(equations, f"t{axis}") else Integer(0)
