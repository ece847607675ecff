"""Tyres that must slip to push sideways: both axles move at an angle D·a_y outwards of where their wheels point.

A tyre's side force is its slip angle times its cornering stiffness, so in a turn the rear axle moves outwards of the
heading by m l_f a_y / (L C_r) = D a_y (R. T. Bundorf's cornering compliance; Gillespie, ch. 6): v_rear = -D |u| a_y,
a_y = u ω_z. The front axle does alike; what it does beyond that is ``understeer``. To D a_y tan²δ the turn is then that
of the base, which is asked with the slip taken off the velocity; the slip is added to velocity and place behind it.
Tyres take up their slip within centimetres: it is the steady one of the step's end.
"""

from dataclasses import replace

from sympy import Abs, Expr

from sym2real.effects.alike import ONE_ARM, Member
from sym2real.effects.body import Body
from sym2real.effects.car_turning import FORWARD, forward_speed
from sym2real.effects.frames import dot
from sym2real.effects.kind import Kind, Parameter, Values, of_any_body
from sym2real.effects.roll_steer import roll_steer
from sym2real.effects.searching import Searching, Shown
from sym2real.symbolic import Equations, symbol


def _slip(compliance: Expr, forward: Expr, rate: Expr) -> Expr:
    return -compliance * Abs(forward) * forward * rate


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    before = _slip(values["value"], forward_speed(body), symbol("wz"))
    changes = {"vx": symbol("vx") + before * symbol("sin_yaw"), "vy": symbol("vy") - before * symbol("cos_yaw")}
    held = replace(equations.substitute(changes), output=equations.output)  # what is measured is the car's
    after = held.next
    forward = dot((after["vx"], after["vy"]), (after["cos_yaw"], after["sin_yaw"]))
    slip = _slip(values["value"], forward, after["wz"])
    aside = {"x": -slip * after["sin_yaw"], "y": slip * after["cos_yaw"]}
    moved = {name: after[name] + equations.dt * speed for name, speed in aside.items()}
    moved |= {f"v{name}": after[f"v{name}"] + speed for name, speed in aside.items()}
    return replace(held, next={**after, **moved})


TYRE_SLIP = Kind(
    name="tyre_slip",
    stage="loop",
    # Tyres whose stiffness is 10 to 50 times their load have 0.01 to 0.002.
    parameters=of_any_body(Parameter("value", "rad s²/m", null=0.0, low=0.0, high=0.1, scale=0.005)),
    formula=r"v_\mathrm{rear} = -D\,|u|\,u\,\omega_z",
    summary="Tyres slip to push sideways, so that in turns the car moves outwards of where it points.",
    confused_with="a lever arm at one speed, behind the axle by D u²",
    shown_by="the same circle at several speeds, at lateral accelerations up to 2.5 m/s²",
    fix="fit stiffer tyres or lighten the car, or keep the term in the model",
    inject=lambda body, values: roll_steer(body, front=values["value"], rear=values["value"]),
    substitute=_substitute,
    needs=("steer", "x", "y", *FORWARD, "wz"),
    robot="car",
    alike=(Member(ONE_ARM, 1),),
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)
