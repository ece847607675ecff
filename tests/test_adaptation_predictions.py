"""Predictions of logs drive a residual with what it was trained on."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from sym2real.adaptation.predictions import Predictor
from sym2real.dataset import Dataset
from sym2real.effects import compose, effect
from sym2real.neural import Composed, ResidualMLP
from sym2real.neural.leftover import leftover
from sym2real.robots import MUSHR
from sym2real.symbolic import Equations
from sym2real.trajectory import Trajectory

COMMANDS, STATES = 3, 2
AHEAD = 4
PLACE = 7 + 2 * (1 + COMMANDS) - 1  # of the oldest speed command among what is seen


@pytest.fixture(scope="module")
def base() -> Equations:
    """Late, slow commands and a lever arm: what is sent, and measured, is not what the equations take."""
    plain = MUSHR.nominal()
    keys = {"delay": {"value": 0.12}, "lag:speed": {"value": 0.1}, "lever_arm": {"rx": 0.2, "ry": 0.0}}
    return compose(plain, [(effect(key, plain), values) for key, values in keys.items()])


@pytest.fixture(scope="module")
def log(base: Equations) -> Trajectory:
    rng = np.random.default_rng(3)
    rows = 40
    state = np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0], (rows, 1)) + rng.normal(0.0, 0.1, (rows, 7))
    layouts = MUSHR.layouts
    state = layouts.state.normalise(torch.as_tensor(state)).numpy()
    action = rng.uniform([-0.3, 0.0], [0.3, 2.0], (rows, 2))
    return Trajectory(np.arange(rows) * base.dt, state, action, np.zeros((rows, 3)), layouts)


def test_a_residual_sees_of_a_log_what_it_was_trained_on(base: Equations, log: Trajectory) -> None:
    """At the start of every window, and of its past commands in all later rows of the rollout."""
    trained = leftover(Dataset([log]).transitions(), base, COMMANDS, STATES)
    predictor = Predictor(Composed(base, _oldest_speed(1.0)))
    rows = np.arange(len(log) - AHEAD)
    windows = predictor.windows(log, rows, AHEAD)
    fed = torch.cat([windows.start, windows.action[:, 0], windows.past], dim=-1).float()
    torch.testing.assert_close(fed, trained.seen[: len(rows)], rtol=1e-6, atol=1e-6)


def test_a_rollout_moves_past_commands_as_they_were_trained_on(base: Equations, log: Trajectory) -> None:
    """Where the residual of x is the oldest past command, x ends up by the sum of those further on."""
    trained = leftover(Dataset([log]).transitions(), base, COMMANDS, STATES)
    rows = np.arange(len(log) - AHEAD)
    with_it, without = (_predicted(Composed(base, _oldest_speed(size)), log, rows) for size in (1.0, 0.0))
    oldest = trained.seen[:, PLACE].double()
    wanted = torch.stack([oldest[rows + step] for step in range(AHEAD)]).sum(0)
    torch.testing.assert_close((with_it - without)[:, 0], wanted, rtol=1e-4, atol=1e-4)


def _predicted(model: Composed, log: Trajectory, rows: NDArray[np.int64]) -> torch.Tensor:
    predictor = Predictor(model)
    return predictor.predict(predictor.windows(log, rows, AHEAD))[:, -1]


def _oldest_speed(size: float) -> ResidualMLP:
    """So many times the oldest speed command that it sees, added to x; a speed that is never negative passes a ReLU."""
    residual = ResidualMLP(MUSHR.layouts, (1,), commands=COMMANDS, states=STATES)
    first, last = (layer for layer in residual.linears)
    with torch.no_grad():
        first.weight.zero_()
        first.weight[0, PLACE] = 1.0
        last.weight[0, 0] = size
    return residual
