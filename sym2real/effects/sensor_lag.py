"""A measurement is filtered: τ dy_m/dt = y - y_m. It serves the diagnosis; control with it is refused."""

import numpy as np

from sym2real.effects.body import Body
from sym2real.effects.domain import NOT_NEGATIVE
from sym2real.effects.kind import Kind, Numbers, Parameter
from sym2real.effects.memory import sampled_lag
from sym2real.effects.searching import Searching
from sym2real.protocols import Change, Filter
from sym2real.trajectory import Array

PIECES = 200  # in which the truth integrates a period


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return (Parameter("value", "s", null=0.0, low=0.0, high=1.0, scale=2 * body.dt, domain=NOT_NEGATIVE),)


def _inject(body: Body, values: Numbers) -> Change:
    """Integrated in small steps along the straight line between two samples."""
    column = body.layouts.state.index(body.column)
    step = body.dt / PIECES

    def begin() -> Filter:
        """A sensor that has been where its first measurement is."""
        kept: list[float] = []

        def report(state: Array) -> Array:
            """What is reported of a state ``# (state,)``."""
            result, now = state.copy(), float(state[column])
            before, filtered = kept or (now, now)
            for middle in (np.arange(PIECES) + 0.5) / PIECES:
                line = before + (now - before) * middle
                filtered += (line - filtered) * step / (values["value"] + 0.5 * step)
            kept[:] = [now, filtered]
            result[column] = filtered
            return result

        return report

    return Change("", measure=begin)


SENSOR_LAG = Kind(
    name="sensor_lag",
    stage="measurement",
    parameters=_parameters,
    formula=r"\tau \dot y_m = y - y_m",
    summary="A sensor or estimator smooths what it reports.",
    confused_with="a lag of the command that drives the same column",
    shown_by="fast motion that another channel measures too",
    fix="lower the filter's time constant in the driver or estimator, or log the raw signal",
    inject=_inject,
    memory=lambda body: sampled_lag(),
    columns="state",
    searching=Searching(why_not=lambda _: "not searched for: the checks of the data see it as a time shift"),
)
