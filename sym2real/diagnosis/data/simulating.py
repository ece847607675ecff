"""What a model predicts of a log: the work of its method of this name."""

from dataclasses import replace

import numpy as np

from sym2real.dataset import Dataset, logs_in
from sym2real.diagnosis.data.start import start_states
from sym2real.diagnosis.data.windows import rows_ahead
from sym2real.effects.along_logs import predicted_from, prepared
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations
from sym2real.trajectory import Trajectory


def simulate(whole: Equations | DynamicsModel, log: Trajectory, horizon: float | None = None) -> Trajectory:
    """See :meth:`~sym2real.Equations.simulate`."""
    model, logs = prepared(whole, Dataset(logs_in(log)))
    ready = logs[0]
    steps = len(ready) - 1 if horizon is None else rows_ahead(horizon, ready.dt)
    rows = np.arange(0, len(ready) - 1, steps)
    predicted = predicted_from(model, ready, rows, steps, start=start_states(ready, rows)).flatten(0, 1).numpy()
    state = np.concatenate([ready.state[:1], predicted[: len(ready) - 1]])
    layouts = replace(ready.layouts, action=log.layouts.action)
    name = f"{log.name} simulated".strip()
    return replace(ready, state=state, action=log.action, layouts=layouts, name=name, raw={})
