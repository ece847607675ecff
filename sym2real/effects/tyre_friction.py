"""Tyres that hold less: the force on the ground is limited to μ·m·g.

Across the motion it limits the turn. Front tyres at their limit turn the car about its rear axle, c = L/2 behind its
centre, against the lateral acceleration of that centre and against wheels that are driven alike::

    (J + m c²) dω/dt = ± μ m g c - m c (|u| + u₀) ω,   u₀ = 2 k w²/(L m)

k: the drive's N s/m a wheel, w: the track. Front tyres that slide sideways with v_s resist less, by
1/(1 + 4 k v_s/(μ m g)). After a step the yaw rate lies between the two solutions: where tyres slide it follows late.

A tyre that slides has one force, against its slip (Coulomb): of μ m g the drive gets the share that its demand
4 k (u_cmd - u) has beside the turn's, m u² tan(δ)/L. The plain robot has μ = 1.
"""

from typing import Any

from sympy import Abs, Expr, Max, Min, Piecewise, atan, exp, sqrt, tan

from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.car_turning import FORWARD, forward_speed
from sym2real.effects.domain import NOT_NEGATIVE
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.truth import editing
from sym2real.symbolic import Equations, symbol

PLAIN = 1.0
SLOWEST = 1e-3  # m/s; slower cars are not limited


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    friction, steer, command = values["value"], symbol("steer"), symbol("speed")
    drive, forward = 4 * body.numbers.get("wheel_drive", 0.0) / body.mass, forward_speed(body)
    grip = friction * GRAVITY
    changes = {}
    wheelbase, track = body.number("wheelbase"), body.numbers.get("track", 0.0)
    if drive > 0 and "speed" in body.layouts.action:
        ahead, across = (1 - exp(-drive * body.dt)) / body.dt * (command - forward), forward**2 * tan(steer) / wheelbase
        held = grip / Max(grip, sqrt(ahead**2 + across**2))
        changes["speed"] = Piecewise((forward + held * (command - forward), friction < PLAIN), (command, True))
    speed, resisting = Max(Abs(forward), SLOWEST), drive * track**2 / (2 * wheelbase)
    sliding = Max(speed * Abs(tan(steer)) - wheelbase * grip / (speed + resisting), 0)
    resisting = speed + resisting / 2 * (1 + grip / (grip + drive * sliding))
    going, kept = Piecewise((speed, forward >= 0), (-speed, True)), _kept(body, resisting)
    middle, reach = kept * symbol("wz") if kept else 0, (1 - kept) * grip / resisting
    turn = Max(middle - reach, Min(middle + reach, going * tan(steer) / wheelbase))
    limited = atan(turn * wheelbase / going)
    changes["steer"] = Piecewise((limited, friction < PLAIN), (steer, True))
    return equations.substitute(changes)


def _kept(body: Body, resisting: Expr) -> Expr | float:
    """Share of the yaw rate that is left after a step against |u| + u₀; none where nobody told the inertia."""
    if "jz" not in body.numbers or "wz" not in body.layouts.state:
        return 0
    centre = body.number("wheelbase") / 2
    return exp(-body.dt * resisting / (body.number("jz") / (body.mass * centre) + centre))


def _smooth(spec: Any, body: Body, values: Numbers) -> None:
    """Friction of all geoms: MuJoCo takes the larger of the two that touch."""
    for geom in spec.geoms:
        geom.friction = [min(values["value"], geom.friction[0]), *list(geom.friction)[1:]]


TYRE_FRICTION = Kind(
    name="tyre_friction",
    stage="thrust",
    parameters=of_any_body(Parameter("value", "1", null=PLAIN, low=0.05, high=PLAIN, scale=0.3, domain=NOT_NEGATIVE)),
    formula=r"|F_\mathrm{lateral}| \le \mu\,m\,g",
    summary="The tyres let go in fast turns, and the car runs wide.",
    confused_with="a steering gain below one, where every turn is fast",
    shown_by="turns at a lateral acceleration of 2.7 m/s² or more, beside slow ones",
    fix="clean or change the tyres or the floor, or slow down in turns",
    inject=editing(_smooth),
    substitute=_substitute,
    needs=("steer", *FORWARD),
    numbers=("mass", "wheelbase"),
    robot="car",
    searching=Searching(
        starts=lambda _body, _values: (0.25, 0.4, 0.6),
        from_null=False,
        sizes=lambda _body, _values: (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1),
        shown_in=lambda _: (Shown.HARD,),
    ),
)
