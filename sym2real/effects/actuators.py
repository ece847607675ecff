"""Actuators that answer a command with a memory of what went before.

``rate_limit``. An actuator follows its command no faster than a fixed rate: |da'/dt| ≤ r.

``delay``. Commands act late: a(t) → a(t - d).

``lag``. An actuator approaches its command as a first-order filter: τ da'/dt = a - a'.

``dead_band``. Commands within a band around where the actuator stands do nothing: play in a linkage.

``dead_zone``. Commands within a threshold of zero do nothing: a' = a [|a| > w]. The equations let them through in a
straight line between 0.95 w and 1.05 w, so that a fit feels the threshold.
"""

from functools import partial
from typing import Any

import numpy as np

from sym2real.effects import steering, truth
from sym2real.effects.body import Body
from sym2real.effects.kind import DELAY_TIME, NOT_NEGATIVE, Kind, Numbers, Parameter, Values
from sym2real.effects.manoeuvres import EXCITED
from sym2real.effects.memory import dead_zone, lag, play, rate_limited, shift
from sym2real.effects.searching import Searching, Shown, alone_on, by_role, steps
from sym2real.protocols import Change, Filter
from sym2real.trajectory import Array
from sym2real.vocabulary import UNLIMITED

# A row's command stands for those that a faster controller sends until the next row, half a row later in the mean.
BETWEEN_ROWS = (
    "a controller that sends more often than the log has rows hides up to half a row: `nominal --dt` its step"
)
_of_command = partial(Kind, stage="filter", columns="action")
# Longest likely lag in steps: of a car that is stepped by 20 ms a second, of a boat by 0.1 s five.
LONGEST_LAG = 50
# Parts of a command's deviation from which play is searched. Tuned: a stage's play was found from two and a half times
# too narrow, and not from six times too wide.
PLAY = (0.03, 0.1, 0.25, 0.5)


def _rate_limit_parameters(body: Body) -> tuple[Parameter, ...]:
    unit = f"{body.unit}/s".replace("/s/s", "/s²")
    low, high, scale = (factor * body.scale for factor in (0.1, 1000, 10))
    value = Parameter("value", unit, null=UNLIMITED, low=low, high=high, scale=scale, domain=NOT_NEGATIVE)
    return value, *steering.seen(body)


def _rate_limit_inject(body: Body, values: Numbers) -> Change:
    return Change("", command=lambda: truth.Ramp(body, values["value"]))


def _rate_limit_parts(values: Values, body: Body) -> tuple[tuple[Kind, Values], ...]:
    return steering.parts(RATE_LIMIT, steering.of_ramp, values, body)


RATE_LIMIT = _of_command(
    name="rate_limit",
    parameters=_rate_limit_parameters,
    formula=r"|\dot a'| \le r",
    summary="The actuator follows its command no faster than a fixed rate.",
    confused_with="a lag, whose speed grows with the step",
    shown_by="small and large steps of the command",
    fix="raise the limit in the firmware (servo speed, acceleration limit), or limit the commands' rate",
    inject=_rate_limit_inject,
    memory=lambda body: rate_limited(body.loop_gains),
    parts=_rate_limit_parts,
    shared=(steering.BEFORE,),
    searching=Searching(
        why_not=alone_on("rate command", "thrust", "motors"),
        starts=lambda body, values: tuple(float(np.std(values)) / body.dt * 0.2 * part for part in (1.0, 3.0)),
        from_null=False,
        sizes=lambda body, values: tuple(float(np.std(values)) / body.dt * part for part in (2.0, 1.0, 0.5, 0.2, 0.1)),
        shown_in=by_role({"speed": (Shown.DITHER, Shown.SPEEDS, Shown.SWINGING_SPEED)}, (Shown.DITHER,)),
    ),
)


def _delay_parameters(body: Body) -> tuple[Parameter, ...]:
    value = Parameter("value", "s", null=0.0, low=0.0, high=0.5, scale=2 * body.dt, domain=DELAY_TIME)
    return value, *steering.seen(body)


def _delay_inject(body: Body, values: Numbers) -> Change:
    """Whole periods in a queue before the actuators, the rest by MuJoCo's own delayed controls."""
    columns = body.action_indices()
    periods = int(values["value"] / body.dt + 1e-9)
    rest = values["value"] - periods * body.dt

    def begin() -> Filter:
        """An empty queue, which the first command fills: it is taken to have been held for ever."""
        queue: list[Array] = []

        def wait(action: Array) -> Array:
            """What leaves the queue when a command ``# (action,)`` enters it."""
            queue.extend([action] * (1 if queue else periods + 1))
            late = action.copy()
            late[columns] = queue.pop(0)[columns]
            return late

        return wait

    def edit(spec: Any) -> None:
        """Give every actuator the rest of the delay."""
        truth.delay(spec, truth.actuators(spec, body), rest)

    return Change("", edit=edit if rest > 1e-9 else None, command=begin if periods else None)


def _delay_parts(values: Values, body: Body) -> tuple[tuple[Kind, Values], ...]:
    return steering.parts(DELAY, steering.of_delay, values, body)


DELAY = _of_command(
    name="delay",
    parameters=_delay_parameters,
    formula=r"a(t) \to a(t - d)",
    summary="Commands act some time after they were sent.",
    confused_with="a lag, motor lag in hover, and measurements that are all late, as behind a motion capture's filter",
    shown_by=f"fast changes of the command: {EXCITED}",
    fix="shorten the way (radio, queue; a motion capture's filter), or let the controller plan with the commands under "
    f"way; {BETWEEN_ROWS}",
    inject=_delay_inject,
    memory=lambda body: shift(body.loop_gains),
    of_attitude=True,
    of_all=lambda _: True,
    parts=_delay_parts,
    shared=(steering.BEFORE,),
    searching=Searching(
        why_not=alone_on("motors"),
        starts=steps(1.0, 2.0, 4.0),
        shown_in=by_role({"speed": (Shown.DITHER, Shown.SPEEDS)}, (Shown.DITHER,)),
    ),
)


def _lag_parameters(body: Body) -> tuple[Parameter, ...]:
    longest = max(1.0, LONGEST_LAG * body.dt)  # what is stepped slowly is slow
    value = Parameter("value", "s", null=0.0, low=0.0, high=longest, scale=2 * body.dt, domain=NOT_NEGATIVE)
    return value, *steering.seen(body)


def _slow(spec: Any, body: Body, values: Numbers) -> None:
    """MuJoCo's actuator dynamics."""
    for actuator in truth.actuators(spec, body):
        truth.set_lag(spec, actuator, values["value"])


def _lag_parts(values: Values, body: Body) -> tuple[tuple[Kind, Values], ...]:
    return steering.parts(LAG, steering.of_lag, values, body)


LAG = _of_command(
    name="lag",
    parameters=_lag_parameters,
    formula=r"\tau \dot a' = a - a'",
    summary="The actuator approaches its command as a first-order filter.",
    confused_with="a delay; a common lag of the rate commands also with motor lag",
    shown_by="steps of the command that are held longer than the time constant",
    fix=f"stiffen the actuator's own loop, or let the controller plan with the lag; {BETWEEN_ROWS}",
    inject=truth.editing(_slow),
    memory=lambda body: lag(body.loop_gains),
    of_attitude=True,
    of_all=lambda _: True,
    parts=_lag_parts,
    shared=(steering.BEFORE,),
    lagging=True,
    searching=Searching(
        why_not=alone_on("motors"),
        starts=steps(2.5),
        shown_in=by_role({"speed": (Shown.DITHER, Shown.SPEEDS, Shown.SWINGING_SPEED)}, (Shown.DITHER,)),
    ),
)


def _widest(body: Body) -> float:
    return 5 * body.scale


def _band_parameters(body: Body) -> tuple[Parameter, ...]:
    return (
        Parameter("value", body.unit, null=0.0, low=0.0, high=_widest(body), scale=body.scale, domain=NOT_NEGATIVE),
    )


_of_a_band = partial(_of_command, parameters=_band_parameters)


def _dead_band_inject(body: Body, values: Numbers) -> Change:
    half = 0.5 * values["value"]

    def play(position: float, command: float) -> tuple[float, float]:
        position = float(np.clip(position, command - half, command + half))
        return position, position

    return truth.following(body, play)


DEAD_BAND = _of_a_band(
    name="dead_band",
    formula=r"a' = \mathrm{clip}(a', a - w/2, a + w/2)",
    summary="A linkage has play: commands that turn back do nothing within a band, w from end to end.",
    confused_with="a lag of the servo",
    shown_by="slow reversals of the command",
    fix="take the play out of the linkage",
    inject=_dead_band_inject,
    memory=lambda body: play(),
    searching=Searching(
        why_not=alone_on("rate command", "thrust", "motors"),
        starts=lambda body, values: tuple(min(part * float(np.std(values)), _widest(body)) for part in PLAY),
        from_null=False,
        sizes=lambda _, values: tuple(float(np.std(values)) * part for part in (0.05, 0.1, 0.2, 0.5, 1.0, 2.0)),
    ),
)


def _dead_zone_inject(body: Body, values: Numbers) -> Change:
    return truth.following(
        body, lambda position, command: (position, command if abs(command) > values["value"] else 0.0)
    )


DEAD_ZONE = _of_a_band(
    name="dead_zone",
    formula=r"a' = a\,[\,|a| > w\,]",
    summary="Commands smaller than a threshold do nothing; larger ones act in full.",
    confused_with="a gain, where few commands are small; dry friction",
    shown_by="slow changes of the command through zero, small and large ones",
    fix="raise the motor driver's lowest duty, or take out the dead zone of the driver or the remote control",
    inject=_dead_zone_inject,
    memory=lambda body: dead_zone(),
    searching=Searching(
        why_not=alone_on("rate command", "thrust", "motors"),
        starts=lambda body, values: tuple(
            np.minimum(np.quantile(np.abs(values), (0.03, 0.07, 0.15, 0.3)), _widest(body)).tolist()
        ),
        from_null=False,
        sizes=lambda _, values: tuple(np.quantile(np.abs(values), (0.02, 0.05, 0.1, 0.2, 0.4)).tolist()),
        shown_in=by_role({"speed": (Shown.SPEEDS,)}, ()),
    ),
)
