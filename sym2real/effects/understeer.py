"""A car that turns less than its steering says, the more so the faster it turns: δ_eff = δ - K a_y, a_y = u ω_z.

In a steady turn δ = L/R + K a_y, K = D_f - D_r: what the front axle gives way by, per lateral acceleration, beyond the
rear (T. D. Gillespie, Fundamentals of Vehicle Dynamics, ch. 6; R. Rajamani, Vehicle Dynamics and Control, ch. 3).
Tyres and bushings are fast beside a control period, so the turn is the steady one: with k = K u|u| / L the angle that
turns the car solves δ_eff + k tan δ_eff = δ, whose first Newton step from δ is taken. Backwards, slip has the other
sign. Below zero the car oversteers, and diverges where k = -1, its critical speed; the equations stop short of it.
"""

from sympy import Abs, Max, tan

from sym2real.effects.alike import ONE_STEERING, Member
from sym2real.effects.body import Body
from sym2real.effects.car_turning import FORWARD, forward_speed
from sym2real.effects.kind import Kind, Parameter, Values, of_any_body
from sym2real.effects.roll_steer import roll_steer
from sym2real.effects.searching import Searching, Shown
from sym2real.symbolic import Equations, symbol

LEAST = 0.2  # of 1 + k / cos² δ, which is zero where the car diverges


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    steer, forward = symbol("steer"), forward_speed(body)
    growth, slope = values["value"] * forward * Abs(forward) / body.number("wheelbase"), tan(steer)
    return equations.substitute({"steer": steer - growth * slope / Max(1 + growth * (1 + slope**2), LEAST)})


UNDERSTEER = Kind(
    name="understeer",
    stage="thrust",
    # Road cars have 0.002 to 0.01 (1 to 6 degrees per g).
    parameters=of_any_body(Parameter("value", "rad s²/m", null=0.0, low=-0.02, high=0.1, scale=0.005)),
    formula=r"\delta \to \delta - K\,u\,\omega_z",
    summary="The front axle gives way more than the rear, so fast turns are wider than the steering says.",
    confused_with="a steering gain at one speed; tyres at their limit where every turn is fast",
    shown_by="the same circle at several speeds, at lateral accelerations up to 2.5 m/s²",
    fix="stiffen the steering and the front tyres, or move weight back; below zero: the rear, and forward",
    inject=lambda body, values: roll_steer(body, front=values["value"], rear=0.0),
    substitute=_substitute,
    needs=("steer", *FORWARD),
    numbers=("wheelbase",),
    robot="car",
    alike=(Member(ONE_STEERING, 1),),
    searching=Searching(varying=("steer",), shown_in=lambda _: (Shown.SPEEDS,)),
)
