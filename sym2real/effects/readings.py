"""Sensors that report another number than there is.

``sensor_sign``. A measurement has the wrong sign: y → -y, a factor of -1; 1 is none.

``sensor_bias``. A measurement is off by a constant: y → y + b.

``sensor_scale``. A measurement is a multiple of the truth: y → k·y. A factor of -1 is ``sensor_sign``.

``sensor_lag``. A measurement is filtered: τ dy_m/dt = y - y_m. It serves the diagnosis; control with it is refused.

``time_shift``. A measurement is stamped late or early: y_m(t) = y(t - d). It serves the diagnosis; control with it is
refused.
"""

from functools import partial

import numpy as np

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.kind import NOT_NEGATIVE, SHIFT_TIME, Kind, Numbers, Parameter, Values, about_zero, of_any_body
from sym2real.effects.memory import sampled_lag, shift
from sym2real.effects.searching import SETTLED, Searching, by_role
from sym2real.effects.terms import reported, reporting
from sym2real.errors import ModelError
from sym2real.protocols import Change, Filter
from sym2real.symbolic import Equations
from sym2real.trajectory import Array
from sym2real.vocabulary import JOINT_ANGLE, JOINT_DISPLACEMENT

_of_column = partial(Kind, stage="measurement", columns="state")


def _report(state: Array, body: Body, values: Numbers) -> Array:
    state[body.layouts.state.index(body.column)] += values["value"]
    return state


SENSOR_BIAS = _of_column(
    name="sensor_bias",
    parameters=about_zero(20),
    formula=r"y_m = y + b",
    summary="A sensor adds a constant.",
    confused_with="a trim of the command that drives the same column",
    shown_by="the robot at rest, where the true value is known",
    fix="calibrate the sensor at rest",
    inject=truth.measuring(_report),
    substitute=lambda equations, values, body: reporting(
        equations, {body.column: reported(equations, body.column) + values["value"]}
    ),
    searching=Searching(why_not=by_role({JOINT_ANGLE.name: "", JOINT_DISPLACEMENT.name: ""}, SETTLED)),
)


def multiplied(equations: Equations, values: Values, body: Body) -> Equations:
    """The measured column times a factor."""
    return reporting(equations, {body.column: reported(equations, body.column) * values["value"]})


@truth.measuring
def multiplying(state: Array, body: Body, values: Numbers) -> Array:
    """Its truth."""
    state[body.layouts.state.index(body.column)] *= values["value"]
    return state


SENSOR_SCALE = _of_column(
    name="sensor_scale",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.01, high=100.0, scale=0.1)),
    formula=r"y_m = k\,y",
    summary="A sensor reports what it measures times a factor.",
    confused_with="a gain of the command that drives the same column",
    shown_by="motion that another channel measures too: rates against the attitude's derivative",
    fix="calibrate the sensor",
    inject=multiplying,
    substitute=multiplied,
    searching=Searching(why_not=lambda _: SETTLED),
)


SENSOR_SIGN = _of_column(
    name="sensor_sign",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=-1.0, high=1.0, scale=2.0, fitted=False)),
    formula=r"y_m = -y",
    summary="A sensor's axis points the other way.",
    confused_with="nothing, once the column is compared with the attitude's derivative",
    shown_by="any motion of that axis",
    fix="turn the sign in the log's specification, or the axis in the driver",
    inject=multiplying,
    substitute=multiplied,
    searching=Searching(why_not=lambda _: SETTLED),
)


PIECES = 200  # in which the truth integrates a period


def _sensor_lag_inject(body: Body, values: Numbers) -> Change:
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


SENSOR_LAG = _of_column(
    name="sensor_lag",
    parameters=lambda body: (Parameter("value", "s", 0.0, low=0.0, high=1.0, scale=2 * body.dt, domain=NOT_NEGATIVE),),
    formula=r"\tau \dot y_m = y - y_m",
    summary="A sensor or estimator smooths what it reports.",
    confused_with="a lag of the command that drives the same column",
    shown_by="fast motion that another channel measures too",
    fix="lower the filter's time constant in the driver or estimator, or log the raw signal",
    inject=_sensor_lag_inject,
    memory=lambda body: sampled_lag(),
    searching=Searching(why_not=lambda _: SETTLED),
)


def _time_shift_inject(body: Body, values: Numbers) -> Change:
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


TIME_SHIFT = _of_column(
    name="time_shift",
    parameters=lambda body: (Parameter("value", "s", null=0.0, low=-0.2, high=0.5, scale=body.dt, domain=SHIFT_TIME),),
    formula=r"y_m(t) = y(t - d)",
    summary="A channel's time stamps are late or early.",
    confused_with="a delay of the command that drives the same column",
    shown_by="fast motion that another channel measures too",
    fix="stamp at the sensor, or move the column by this time before the log is read",
    inject=_time_shift_inject,
    memory=lambda body: shift(),
    searching=Searching(why_not=lambda _: SETTLED),
)
