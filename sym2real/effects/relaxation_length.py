r"""Tyres that must roll to push: the side force, and with it the turn, follows the steering over a distance σ.

A tyre's side force is at its steady value once the tyre has rolled a few relaxation lengths (Pacejka, Tyre and Vehicle
Dynamics, ch. 1 and 7)::

    (σ/|u|) dF'/dt = F - F'

In a turn the side force is m u² tan(δ)/L, so that at a speed it is the turn that follows: δ' in the place of δ. It is a
lag whose time goes by the speed. δ' is a hidden state that starts at the first command; the equations turn by its mean
over the step, exact for the speed of the step's start.
"""

from typing import Any

from sympy import Abs, Integer, Max, exp

from sym2real.effects import truth
from sym2real.effects.alike import ONE_WAY_TO_TURN, Member
from sym2real.effects.body import Body
from sym2real.effects.car_turning import FORWARD, forward_speed
from sym2real.effects.domain import NOT_NEGATIVE
from sym2real.effects.hidden import with_hidden
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.thrust import defined
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol

TURN, MEMORY = "tyre_turn", "tyre_turn_memory"
SLOWEST = 0.01  # m/s; a car that stands keeps its turn


def _parameters(body: Body) -> tuple[Parameter, ...]:
    """Tyres have about their radius, a sixth of the wheelbase of cars of all sizes."""
    length = body.numbers.get("wheelbase", 1.0)
    return (Parameter("value", "m", null=0.0, low=0.0, high=3 * length, scale=length / 6, domain=NOT_NEGATIVE),)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    steer, memory, length = symbol("steer"), symbol(MEMORY), values["value"]
    rolled = equations.dt * Max(Abs(forward_speed(body)), SLOWEST)
    kept = exp(-rolled / length)
    away = memory - steer
    equations = defined(equations, {TURN: Integer(0)}).substitute({"steer": symbol(TURN)})
    equations = with_hidden(equations, MEMORY, "rad", steer + away * kept, start=steer)
    return defined(equations, {TURN: steer + away * length / rolled * (1 - kept)})


def _inject(body: Body, values: Numbers) -> Change:
    """Wheels that MuJoCo's actuator filters turn, slower in time the slower the car is; the contacts do the rest."""
    length, columns = values["value"], ("front_left_steer", "front_right_steer")

    def slowed(model: Any, data: Any) -> None:
        speed = abs(float(truth.rotation(data)[:, 0] @ truth.velocity(data)))
        for name in columns:
            truth.set_time(model, name, length / max(speed, SLOWEST))

    def edit(spec: Any) -> None:
        for name in columns:
            truth.set_lag(spec, spec.actuator(name), length / SLOWEST)

    return Change("", edit=edit, force=slowed)


RELAXATION_LENGTH = Kind(
    name="relaxation_length",
    stage="loop",
    parameters=_parameters,
    formula=r"\frac{\sigma}{|u|}\,\dot F' = F - F'",
    summary="Tyres must roll a distance before they push sideways, so that turns begin late, the later the slower.",
    confused_with="a lag of the steering at one speed",
    shown_by="steps of the steering at several speeds",
    fix="pump up or stiffen the tyres, or let the controller plan with the term",
    inject=_inject,
    substitute=_substitute,
    needs=("steer", *FORWARD),
    hidden=(MEMORY,),
    robot="car",
    alike=(Member(ONE_WAY_TO_TURN, 1),),
    searching=Searching(varying=("steer",), shown_in=lambda _: (Shown.SPEEDS,)),
)
