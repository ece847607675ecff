"""What a force or a torque across the motion does to a car whose tyres hold: it works on the turn, not the tyres.

The car has one degree of freedom, along its heading; the heading turns by tan(δ)/L per metre, so by virtual work a
yaw torque τ_z pushes along the heading with τ_z tan(δ)/L, and a force F across it at a distance c ahead of the rear
axle with c F tan(δ)/L.
"""

from sympy import Expr, tan

from sym2real.effects.body import Body
from sym2real.effects.frames import axes, body_velocity
from sym2real.effects.wrench import push
from sym2real.symbolic import Equations, symbol

FORWARD = ("vx", "vy", "sin_yaw", "cos_yaw")  # what the speed along the heading follows from


def forward_speed(body: Body) -> Expr:
    """u, m/s."""
    return body_velocity(body)[0]


def push_ahead(equations: Equations, body: Body, force: Expr) -> Equations:
    """A force along the heading, N."""
    return push(equations, body, force=[force * component for component in axes(body)[0]])


def push_turning(equations: Equations, body: Body, torque: Expr) -> Equations:
    """A yaw torque in N m by the work it does."""
    return push_ahead(equations, body, torque * tan(symbol("steer")) / body.number("wheelbase"))
