"""Maps of a car's commands that bend, right for small ones and wrong for large ones, or differ from side to side.

``steering_curve``, δ → δ (1 - c δ²). The equations turn a car by tan δ of one angle. A linkage that turns both front
wheels alike, where a turn asks more of the inner one, turns it by less the further they are turned (no Ackermann
geometry: D. Gillespie, Fundamentals of Vehicle Dynamics, ch. 8); so does a servo's arm that runs on a circle, and what
is logged as an angle and is a travel.

``speed_curve``, v → v (1 - c |v|). A motor whose current rises with its load falls behind its commanded speed, as
one does that an open loop drives; so does a driver's map from command to duty that was taken at one speed.

``steering_asymmetry``, δ → δ + a |δ|. A servo's ends, or the rods to the wheels, were set for each side by itself: the
wheels turn by 1 + a of the command to the left, and by 1 - a of it to the right.

``speed_asymmetry``, v → v + a |v|. The same of driving ahead and back, as of a motor with a timing for one direction.
"""

from functools import partial
from typing import Any

from sympy import Abs, Expr

from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.truth import commanding
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import SPEED_COLUMN, STEER_COLUMN

_of_car = partial(Kind, stage="command", robot="car")


def _steer(equations: Equations, values: Values, _body: Body) -> Equations:
    return _bent(equations, STEER_COLUMN, values["value"] * symbol(STEER_COLUMN) ** 2)


def _speed(equations: Equations, values: Values, _body: Body) -> Equations:
    return _bent(equations, SPEED_COLUMN, values["value"] * Abs(symbol(SPEED_COLUMN)))


def _bent(equations: Equations, column: str, lost: Expr) -> Equations:
    return equations.substitute({column: symbol(column) * (1 - lost)})


STEERING_CURVE = _of_car(
    name="steering_curve",
    parameters=of_any_body(Parameter("value", "1/rad²", null=0.0, low=-2.0, high=2.0, scale=0.3)),
    formula=r"\delta \to \delta\,(1 - c\,\delta^2)",
    summary="The steering map is bent: right about the middle, wrong at full lock.",
    confused_with="a steering gain, on one circle",
    shown_by="small and large steering angles both ways",
    fix="measure the wheels' angle against the command at several angles, and put that curve into the driver",
    inject=commanding(lambda steer, _, values: steer * (1.0 - values["value"] * steer**2), STEER_COLUMN),
    substitute=_steer,
    needs=(STEER_COLUMN,),
    searching=Searching(varying=(STEER_COLUMN,), shown_in=lambda _: (Shown.BOTH_WAYS, Shown.HARD)),
)
SPEED_CURVE = _of_car(
    name="speed_curve",
    parameters=of_any_body(Parameter("value", "s/m", null=0.0, low=-0.3, high=0.3, scale=0.03)),
    formula=r"v \to v\,(1 - c\,|v|)",
    summary="The map of speeds is bent: right for slow driving, wrong for fast.",
    confused_with="a speed gain, at one speed; a drag, where no force is measured",
    shown_by="several speeds, held",
    fix="measure the speed against the command at several speeds, and put that curve into the driver",
    inject=commanding(lambda speed, _, values: speed * (1.0 - values["value"] * abs(speed)), SPEED_COLUMN),
    substitute=_speed,
    needs=(SPEED_COLUMN,),
    searching=Searching(varying=(SPEED_COLUMN,), shown_in=lambda _: (Shown.SPEEDS,)),
)


def _by_side(column: str, *shown_in: Shown, **words: Any) -> Kind:
    """One side of a command answered by 1 + a of it, the other by 1 - a."""
    return _of_car(
        parameters=of_any_body(Parameter("value", "1", null=0.0, low=-0.5, high=0.5, scale=0.1)),
        confused_with="an offset of the same command, where its size hardly varies",
        fix="calibrate each side by itself",
        inject=commanding(lambda sent, _, values: sent + values["value"] * abs(sent), column),
        substitute=lambda equations, values, _: equations.substitute(
            {column: symbol(column) + values["value"] * Abs(symbol(column))}
        ),
        needs=(column,),
        searching=Searching(varying=(column,), shown_in=lambda _: shown_in),
        **words,
    )


STEERING_ASYMMETRY = _by_side(
    STEER_COLUMN,
    Shown.BOTH_WAYS,
    Shown.HARD,
    name="steering_asymmetry",
    formula=r"\delta \to \delta + a\,|\delta|",
    summary="The wheels turn further to one side than to the other for the same command.",
    shown_by="small and large steering angles both ways",
)
SPEED_ASYMMETRY = _by_side(
    SPEED_COLUMN,
    Shown.SPEEDS,
    name="speed_asymmetry",
    formula=r"v \to v + a\,|v|",
    summary="The car drives faster ahead than back for the same command, or slower.",
    shown_by="driving ahead and back, slowly and fast",
)
