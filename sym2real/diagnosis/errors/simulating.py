"""What equations predict of a step and of a log, and how well: the work of their methods of these names."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import torch
from torch import Tensor

from sym2real.dataset import Dataset, Logs, logs_in
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.data.start import start_states
from sym2real.diagnosis.data.windows import rows_ahead
from sym2real.diagnosis.errors.skill import prediction_errors
from sym2real.effects.along_logs import predicted_from, prepared
from sym2real.effects.sensors import MeasuredModel
from sym2real.symbolic import Equations
from sym2real.symbolic.predicting import Values, tensor_of
from sym2real.trajectory import Trajectory

_model = lru_cache(maxsize=32)(MeasuredModel)


def predict(equations: Equations, state: Values, action: Values, inputs: Values | None = None) -> Values:
    """See :meth:`~sym2real.Equations.predict`."""
    if isinstance(state, Tensor):
        none = state.new_zeros((*state.shape[:-1], equations.layouts.inputs.size))
        return _model(equations)(state, action, none if inputs is None else inputs)
    given = [tensor_of(values) for values in (state, action)] + ([] if inputs is None else [tensor_of(inputs)])
    with torch.no_grad():
        return predict(equations, *given).numpy()


def simulate(equations: Equations, log: Trajectory, horizon: float | None = None) -> Trajectory:
    """See :meth:`~sym2real.Equations.simulate`."""
    model, logs = prepared(equations, Dataset(logs_in(log)))
    ready = logs[0]
    steps = len(ready) - 1 if horizon is None else rows_ahead(horizon, ready.dt)
    rows = np.arange(0, len(ready) - 1, steps)
    predicted = predicted_from(model, ready, rows, steps, start=start_states(ready, rows)).flatten(0, 1).numpy()
    state = np.concatenate([ready.state[:1], predicted[: len(ready) - 1]])
    layouts = replace(ready.layouts, action=log.layouts.action)
    name = f"{log.name} simulated".strip()
    return replace(ready, state=state, action=log.action, layouts=layouts, name=name, raw={})


def score(equations: Equations, data: Logs, horizon: float) -> dict[str, float]:
    """See :meth:`~sym2real.Equations.score`."""
    model, logs = prepared(equations, long_enough(data, equations))
    (errors,) = prediction_errors(model, logs, [rows_ahead(horizon, logs.dt)], "smoothed", ())
    return {channel: error.fit for channel, error in errors.errors.items()}
