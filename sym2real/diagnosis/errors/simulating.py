"""What equations predict of a step, and how well: the work of their methods of these names."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import torch
from torch import Tensor

from sym2real.dataset import Logs
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.data.windows import rows_ahead
from sym2real.diagnosis.errors.skill import prediction_errors
from sym2real.effects.along_logs import prepared
from sym2real.effects.sensors import MeasuredModel
from sym2real.effects.visible import visible_state
from sym2real.symbolic import Equations
from sym2real.symbolic.predicting import Values, tensor_of
from sym2real.trajectory import check_columns

_model = lru_cache(maxsize=32)(MeasuredModel)


def predict(equations: Equations, state: Values, action: Values, inputs: Values | None = None) -> Values:
    """See :meth:`~sym2real.Equations.predict`."""
    if isinstance(state, Tensor):
        none = state.new_zeros((*state.shape[:-1], equations.layouts.inputs.size))
        given = (state, _like(state, action), none if inputs is None else _like(state, inputs))
        layouts = replace(equations.layouts, state=visible_state(equations)).groups
        for (name, layout), values in zip(layouts.items(), given, strict=True):
            check_columns(name, values.shape, layout)
        return _model(equations)(*given)
    given = [tensor_of(values) for values in (state, action)] + ([] if inputs is None else [tensor_of(inputs)])
    with torch.no_grad():
        return predict(equations, *given).numpy()


def _like(state: Tensor, values: Values) -> Tensor:
    return values if isinstance(values, Tensor) else tensor_of(values).to(state)


def score(equations: Equations, data: Logs, horizon: float) -> dict[str, float]:
    """See :meth:`~sym2real.Equations.score`."""
    model, logs = prepared(equations, long_enough(data, equations))
    (errors,) = prediction_errors(model, logs, [rows_ahead(horizon, logs.dt)], "smoothed", ())
    return {channel: error.fit for channel, error in errors.errors.items()}
