"""Tyres that hold less: the force on the ground is limited to μ·m·g.

Across the motion it limits the yaw rate: |ω_z| ≤ μ g / (|u| + u₀). Wheels that are driven alike resist a turn, which
the front tyres must overcome as well: u₀ = 2 k w²/(L m), k the drive's N s/m a wheel, w the track; front tyres that
slide sideways with v_s resist less, by 1/(1 + 4 k v_s/(μ m g)). Along the motion the drive is limited:
4 k |u_cmd - u| ≤ μ m g. The plain robot has μ = 1.
"""

from __future__ import annotations

from typing import Any

from sympy import Abs, Max, Min, Piecewise, atan, tan

from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.car_turning import FORWARD, forward_speed
from sym2real.effects.domain import NOT_NEGATIVE
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.searching import Searching, Shown
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol

PLAIN = 1.0
SLOWEST = 1e-3  # m/s; slower cars are not limited


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return (Parameter("value", "1", null=PLAIN, low=0.05, high=PLAIN, scale=0.3, domain=NOT_NEGATIVE),)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    friction, steer, command = values["value"], symbol("steer"), symbol("speed")
    drive, forward = 4 * body.numbers.get("wheel_drive", 0.0) / body.mass, forward_speed(body)
    grip = friction * GRAVITY
    changes = {}
    if drive > 0 and "speed" in body.layouts.action:
        wanted = Max(-grip, Min(grip, drive * (command - forward)))
        changes["speed"] = Piecewise((forward + wanted / drive, friction < PLAIN), (command, True))
    wheelbase, track = body.number("wheelbase"), body.numbers.get("track", 0.0)
    speed, resisting = Max(Abs(forward), SLOWEST), drive * track**2 / (2 * wheelbase)
    sliding = Max(speed * Abs(tan(steer)) - wheelbase * grip / (speed + resisting), 0)
    resisting = resisting / 2 * (1 + grip / (grip + drive * sliding))
    steepest = grip * wheelbase / (speed * (speed + resisting))
    limited = atan(Max(-steepest, Min(steepest, tan(steer))))
    changes["steer"] = Piecewise((limited, friction < PLAIN), (steer, True))
    return equations.substitute(changes)


def _inject(body: Body, values: Numbers) -> Change:
    """Friction of all geoms: MuJoCo takes the larger of the two that touch."""

    def edit(spec: Any) -> None:
        for geom in spec.geoms:
            geom.friction = [min(values["value"], geom.friction[0]), *list(geom.friction)[1:]]

    return Change("", edit=edit if values["value"] < PLAIN else None)


TYRE_FRICTION = Kind(
    name="tyre_friction",
    stage="thrust",
    parameters=_parameters,
    formula=r"|F_\mathrm{lateral}| \le \mu\,m\,g",
    summary="The tyres let go in fast turns, and the car runs wide.",
    confused_with="a steering gain below one, where every turn is fast",
    shown_by="turns at a lateral acceleration of 2.7 m/s² or more, beside slow ones",
    fix="clean or change the tyres or the floor, or slow down in turns",
    inject=_inject,
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
