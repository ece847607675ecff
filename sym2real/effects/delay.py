"""Commands act late: a(t) → a(t - d)."""

from typing import Any

import numpy as np

from sym2real.effects.alike import ONE_DELAY, Member
from sym2real.effects.body import Body
from sym2real.effects.domain import DELAY_TIME
from sym2real.effects.kind import Kind, Numbers, Parameter
from sym2real.effects.manoeuvres import EXCITED
from sym2real.effects.memory import shift
from sym2real.effects.searching import Searching, Shown, alone_on, by_role, steps
from sym2real.effects.truth import actuators
from sym2real.protocols import Change, Filter
from sym2real.trajectory import Array


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return (Parameter("value", "s", null=0.0, low=0.0, high=0.5, scale=2 * body.dt, domain=DELAY_TIME),)


def _inject(body: Body, values: Numbers) -> Change:
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
        for actuator in actuators(spec, body):
            actuator.delay += rest
            actuator.nsample = int(np.ceil(actuator.delay / spec.option.timestep)) + 2

    return Change("", edit=edit if rest > 1e-9 else None, command=begin if periods else None)


DELAY = Kind(
    name="delay",
    stage="filter",
    parameters=_parameters,
    formula=r"a(t) \to a(t - d)",
    summary="Commands act some time after they were sent.",
    confused_with="a lag, and motor lag in hover",
    shown_by=f"fast changes of the command: {EXCITED}",
    fix="shorten the way (radio, driver, queue), or let the controller plan with the commands still under way",
    inject=_inject,
    memory=lambda body: shift(),
    columns="action",
    column_needed=False,
    alike=(Member(ONE_DELAY, 0), Member(ONE_DELAY, 1, "?*")),
    searching=Searching(
        why_not=alone_on("motors"),
        starts=steps(1.0, 2.0, 4.0),
        shown_in=by_role({"speed": (Shown.DITHER, Shown.SPEEDS)}, (Shown.DITHER,)),
    ),
)
