"""A measurement is stamped late or early: y_m(t) = y(t - d). It serves the diagnosis; control with it is refused."""

import numpy as np

from sym2real.effects.body import Body
from sym2real.effects.domain import SHIFT_TIME
from sym2real.effects.kind import Kind, Numbers, Parameter
from sym2real.effects.memory import shift
from sym2real.effects.searching import SETTLED, Searching
from sym2real.errors import ModelError
from sym2real.protocols import Change, Filter
from sym2real.trajectory import Array


def _inject(body: Body, values: Numbers) -> Change:
    """Interpolated between past samples; a plant cannot report the future."""
    if values["value"] < 0:
        raise ModelError(f"a plant cannot measure the future: expected a time shift of at least 0 s, found {values}")
    column = body.layouts.state.index(body.column)

    def begin() -> Filter:
        """A filter that has seen nothing yet."""
        past: list[float] = []

        def report(state: Array) -> Array:
            past.append(float(state[column]))
            times = body.dt * np.arange(len(past))
            result = state.copy()
            result[column] = np.interp(times[-1] - values["value"], times, past)
            return result

        return report

    return Change("", measure=begin)


TIME_SHIFT = Kind(
    name="time_shift",
    stage="measurement",
    parameters=lambda body: (Parameter("value", "s", null=0.0, low=-0.2, high=0.5, scale=body.dt, domain=SHIFT_TIME),),
    formula=r"y_m(t) = y(t - d)",
    summary="A channel's time stamps are late or early.",
    confused_with="a delay of the command that drives the same column",
    shown_by="fast motion that another channel measures too",
    fix="stamp at the sensor, or move the column by this time before the log is read",
    inject=_inject,
    memory=lambda body: shift(),
    columns="state",
    searching=Searching(why_not=lambda _: SETTLED),
)
