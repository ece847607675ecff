"""How far a model's predictions are from logs: one step ahead, and at the end of a horizon.

A log holds what sensors report and what was sent. So a prediction starts from the state that the sensors mean, is
driven by what the model's filters let through, and is held against the log as the sensors would report it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from sym2real.effects.filters import filter_commands
from sym2real.effects.inputs import inputs_along
from sym2real.effects.sensors import Sensors
from sym2real.effects.visible import hidden_rows, visible_in_double
from sym2real.neural.model_folder import Model
from sym2real.past import past_rows
from sym2real.symbolic import Equations, equations_of, rollout
from sym2real.trajectory import Array, Trajectory

STRIDE = 0.1  # s between the starts of windows


@dataclass(frozen=True, eq=False)
class Windows:
    """Where predictions start, and what drives them.

    Args:
        start: states that were measured there, as the sensors mean them ``# (windows, state)``.
        action: commands that reach the robot ``# (windows, steps, action)``.
        inputs: known ones ``# (windows, steps, inputs)``.
        past: commands that reached the robot before the start, and states likewise, as far back as the model sees
            ``# (windows, past)``.
    """

    start: Tensor
    action: Tensor
    inputs: Tensor
    past: Tensor


class Predictor:
    """A model as logs see it.

    Args:
        model: equations, or any dynamics model; one made of equations says by them what its sensors and filters do.
    """

    def __init__(self, model: Model) -> None:
        self._model = visible_in_double(model) if isinstance(model, Equations) else model
        self._equations = equations_of(self._model)
        self._sensors = None if self._equations is None else Sensors(self._equations)
        weights = model.parameters() if isinstance(model, nn.Module) else iter(())
        self._past_rows = past_rows(self._model)
        self._precision = next((weight.dtype for weight in weights), torch.float64)

    @torch.no_grad()
    def windows(self, log: Trajectory, rows: NDArray[np.int64], steps: int) -> Windows:
        """What drives predictions of so many steps from these rows of a log ``# (rows,)``."""
        state, action, inputs = (torch.as_tensor(values) for values in (log.state, log.action, log.inputs))
        if self._equations is not None and self._sensors is not None:
            state, action = self._sensors.state(state), filter_commands(self._equations, action)
            inputs = torch.as_tensor(inputs_along(self._equations.layouts.inputs, log))
        reached = replace(log, state=state.numpy(), action=action.numpy())
        ahead = rows[:, None] + np.arange(steps)
        past = torch.as_tensor(reached.past(*self._past_rows)[rows])
        along = [values.to(self._precision) for values in (state, action, inputs)]
        start = torch.cat([state, hidden_rows(self._model, *along)], dim=-1)
        return Windows(start[rows], action[ahead], inputs[ahead], past)

    def predict(self, windows: Windows) -> Tensor:
        """What will be measured in every row of the windows ``# (windows, steps, state)``."""
        sensors = self._sensors
        given = [values.to(self._precision) for values in (windows.start, windows.action, windows.inputs)]
        past = windows.past.to(self._precision) if any(self._past_rows) else None
        with torch.no_grad():
            predicted = rollout(self._model, *given, past=past).double()
        return predicted if sensors is None else sensors.measured(predicted)


def horizon_errors(model: Model, logs: Iterable[Trajectory], steps: int) -> Array:
    """Distance of predicted from measured positions, or joints, after some steps ``# (windows,)``; none of short logs.

    In m, of joints in their units.
    """
    predictor, errors = Predictor(model), []
    for log in logs:
        rows = np.arange(0, len(log) - steps, max(1, round(STRIDE / log.dt)))
        if len(rows):
            state = log.layouts.state
            position = state.indices(column for field in state.placing for column in field.columns)
            away = predictor.predict(predictor.windows(log, rows, steps))[:, -1].numpy() - log.state[rows + steps]
            errors.append(np.linalg.norm(away[:, position], axis=1))
    return np.concatenate([np.empty(0), *errors])


def one_step_error(model: Model, logs: Iterable[Trajectory]) -> float:
    """One-step prediction error relative to how far states move, root mean square over state columns."""
    predictor, wrong, moved = Predictor(model), [], []
    for log in logs:
        if len(log) > 1:
            rows = np.arange(len(log) - 1)
            predicted = predictor.predict(predictor.windows(log, rows, 1))[:, 0].numpy()
            wrong.append(np.square(predicted - log.state[1:]))
            moved.append(np.square(np.diff(log.state, axis=0)))
    if not moved:
        return float("nan")
    error, motion = np.concatenate(wrong).mean(axis=0), np.concatenate(moved).mean(axis=0)
    return float(np.sqrt(np.mean(error[motion > 0] / motion[motion > 0])))
