"""What a late steering does to a heading and to a gyro, in the same control period.

The yaw rate at the end of a period is that of the wheels' angle then; the heading has turned by the mean of that angle
over the period. So of a car with a gyro a delay, a lag or a rate limit of the steering makes of a row of commands the
angle e at its end, as behind a loop of endless gain, and the heading, the place and the velocity go by::

    mean = e + w (e_before - e)

With e_before at the end of the period before, a hidden state. Of a delay w is the part f of a period that it is beyond
whole ones. Of a lag, τ ẋ = u - x, it is (m - l)/(1 - l), l = e^(-dt/τ) what is left of the distance from the command
after a period, m = τ (1 - l)/dt what is left of it in the mean. A rate limit r moves the angle for the part
p = abs(e - e_before)/(r dt) of a period, and the mean lacks p/2. Behind a delay it begins f later, so that a period
ends with the part b = max(0, 1 - (1 - f)/p) of the way still to go: that is what the gyro then lacks. w is f + p/2, and
what is owed at the end, o = b² p/2 (e - e_before), a second hidden state, is made up in the next period::

    mean = e + w (e_before - e) + o - o_before

A servo that the effect does not describe, behind it on the robot, leaves the gyro nearer to the mean: it then shows
e + s w (e_before - e), with s, ``mean_share``, between 0 and 1. Nobody knows s; a fit finds it beside the time.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from sympy import Abs, Expr, Integer, Max, exp, floor

from sym2real.effects.body import Body
from sym2real.effects.kind import Domain, Kind, Parameter, Values
from sym2real.effects.memory import WHOLE
from sym2real.effects.terms import begun_at_rest, defined, with_hidden, without_quantities
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import exchange, names_in
from sym2real.vocabulary import STEER_COLUMN

YAW_RATE, SHARE = "wz", "mean_share"
BEFORE, OWED = "steer_before", "steer_owed"
MEAN, SHOWN, OF_GYRO = "steer_mean", "steer_shown", "gyro_share_before"
LATE, LAGGED, RAMP = "steer_late", "steer_lagged", "steer_ramp"
SHORTEST = 1e-9  # part of a period


class Weight(NamedTuple):
    """What a filter does to the steering within a period.

    Args:
        name: of the quantity that holds it for all filters of its kind.
        part: of a period, or of the angle, by the effect's value and the period in s.
        of_mean: how much of that the mean lacks.
    """

    name: str
    part: Callable[[Expr, float], Expr]
    of_mean: float = 1.0


def _late(delay: Expr, dt: float) -> Expr:
    late = delay / dt
    return Max(0, late - floor(late + WHOLE))


def _lagged(time: Expr, dt: float) -> Expr:
    left = exp(-dt / time)
    return time / dt - left / (1 - left)


def _ramp(rate: Expr, dt: float) -> Expr:
    return Abs(symbol(STEER_COLUMN) - symbol(BEFORE)) / (rate * dt)


OF_DELAY, OF_LAG, OF_RAMP = Weight(LATE, _late), Weight(LAGGED, _lagged), Weight(RAMP, _ramp, 0.5)


def _shown(body: Body) -> bool:
    return body.shows_steering and body.column in ("", STEER_COLUMN)


def seen(body: Body) -> tuple[Parameter, ...]:
    """How much of the yaw rate's step goes by the mean as well."""
    share = Parameter(SHARE, "1", null=0.0, low=0.0, high=1.0, scale=0.5, domain=Domain(0.0, 1.0), acts_alone=False)
    return (share,) if _shown(body) else ()


def parts(kind: Kind, weight: Weight, values: Values, body: Body) -> tuple[tuple[Kind, Values], ...]:
    """A filter, and beside it the mean over the period of a steering that it acts on, where a gyro shows its end."""
    if not _shown(body):
        return ((kind, values),)
    return (kind, values), (replace(kind, memory=None, substitute=partial(_by_mean, weight)), values)


def _by_mean(weight: Weight, equations: Equations, values: Values, body: Body) -> Equations:
    """Of several in a row each lets through what the others leave of the angle before."""
    equations = equations if MEAN in equations.quantities else _with_mean(equations)
    part = weight.part(values["value"], equations.dt)
    parts = {weight.name: part, OF_GYRO: weight.of_mean * part * values[SHARE]}
    return defined(equations, {name: 1 - (1 - equations.quantities[name]) * (1 - own) for name, own in parts.items()})


def _with_mean(equations: Equations) -> Equations:
    """The equations with the mean of the steering in its place, and its own for the yaw rate; both are its end yet."""
    steer, last, late, ramp = map(symbol, (STEER_COLUMN, BEFORE, LATE, RAMP))
    row = over_columns(equations, equations.next[YAW_RATE])
    none = dict.fromkeys((MEAN, LATE, LAGGED, RAMP, OF_GYRO, SHOWN), Integer(0))
    equations = begun_at_rest(defined(equations, none), {STEER_COLUMN: symbol(MEAN)})
    equations = with_hidden(equations, BEFORE, "rad", steer, start=steer)
    to_come = Max(0, 1 - (1 - late) / Max(SHORTEST, ramp))
    owed = to_come**2 * ramp / 2 * (steer - last)
    equations = with_hidden(equations, OWED, "rad", owed, start=Integer(0))
    of_mean = 1 - (1 - symbol(LAGGED)) * (1 - late - OF_RAMP.of_mean * ramp)
    of_gyro = 1 - (1 - symbol(OF_GYRO)) * (1 - to_come)
    mean, shown = (steer + share * (last - steer) for share in (of_mean, of_gyro))
    equations = defined(equations, {MEAN: mean + owed - symbol(OWED), SHOWN: shown})
    return replace(equations, next={**equations.next, YAW_RATE: exchange({steer: symbol(SHOWN)})(row)})


def over_columns(equations: Equations, row: Expr) -> Expr:
    """An expression with the quantities put in that go by the steering."""
    using = {STEER_COLUMN}
    while more := {name for name, by in equations.quantities.items() if names_in(by) & using} - using:
        using |= more
    return without_quantities(equations, row, using - {STEER_COLUMN})
