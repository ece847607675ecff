"""What a late steering does to a heading and to a gyro, in the same control period.

The yaw rate at the end of a period is that of the wheels' angle then; the heading has turned by the mean of that angle
over the period. So of a car with a gyro a delay, a lag or a rate limit of the steering makes of a row of commands the
angle e at its end, as behind a loop of endless gain, and the heading, the place and the velocity go by::

    mean = e + w (e_before - e)

With e_before at the end of the period before, a hidden state. Of a delay w is the part of a period that it is beyond
whole ones. Of a lag, τ ẋ = u - x, it is (m - l)/(1 - l), l = e^(-dt/τ) what is left of the distance from the command
after a period, m = τ (1 - l)/dt what is left of it in the mean. Of a rate limit r it is abs(e - e_before)/(2 r dt).

A servo that the effect does not describe, behind it on the robot, leaves the gyro nearer to the mean: it then shows
e + s w (e_before - e), with s, ``mean_share``, between 0 and 1. Nobody knows s; a fit finds it beside the time.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from sympy import Abs, Expr, Integer, Max, exp, floor

from sym2real.effects.body import Body
from sym2real.effects.kind import Domain, Kind, Parameter, Values
from sym2real.effects.memory import WHOLE
from sym2real.effects.terms import begun_at_rest, defined, with_hidden, without_quantities
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import exchange, names_in
from sym2real.vocabulary import STEER_COLUMN

YAW_RATE, SHARE = "wz", "mean_share"
BEFORE, MEAN, OF_MEAN, OF_GYRO = "steer_before", "steer_mean", "share_before", "gyro_share_before"
Weight = Callable[[Expr, float], Expr]


def of_delay(delay: Expr, dt: float) -> Expr:
    """w of a delay in s."""
    late = delay / dt
    return Max(0, late - floor(late + WHOLE))


def of_lag(time: Expr, dt: float) -> Expr:
    """w of a lag with a time constant in s."""
    left = exp(-dt / time)
    return time / dt - left / (1 - left)


def of_ramp(rate: Expr, dt: float) -> Expr:
    """w of a limit in rad/s: the angle moves by as much of a period as it takes, and is halfway there in the mean."""
    return Abs(symbol(STEER_COLUMN) - symbol(BEFORE)) / (2 * rate * dt)


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
    share = weight(values["value"], equations.dt)
    shares = {OF_MEAN: share, OF_GYRO: share * values[SHARE]}
    return defined(equations, {name: 1 - (1 - equations.quantities[name]) * (1 - own) for name, own in shares.items()})


def _with_mean(equations: Equations) -> Equations:
    """The equations with the mean of the steering in its place, and its own for the yaw rate; both are its end yet."""
    steer, last = symbol(STEER_COLUMN), symbol(BEFORE)
    row = over_columns(equations, equations.next[YAW_RATE])
    none = dict.fromkeys((MEAN, OF_MEAN, OF_GYRO), Integer(0))
    equations = begun_at_rest(defined(equations, none), {STEER_COLUMN: symbol(MEAN)})
    equations = with_hidden(equations, BEFORE, "rad", steer, start=steer)
    equations = defined(equations, {MEAN: steer + symbol(OF_MEAN) * (last - steer)})
    shown = exchange({steer: steer + symbol(OF_GYRO) * (last - steer)})(row)
    return replace(equations, next={**equations.next, YAW_RATE: shown})


def over_columns(equations: Equations, row: Expr) -> Expr:
    """An expression with the quantities put in that go by the steering."""
    using = {STEER_COLUMN}
    while more := {name for name, by in equations.quantities.items() if names_in(by) & using} - using:
        using |= more
    return without_quantities(equations, row, using - {STEER_COLUMN})
