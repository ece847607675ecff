"""Predictions along logs: a residual sees what it was trained on, hidden states go on, any precision will do."""

import copy

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from sym2real.dataset import Dataset
from sym2real.diagnosis import ROWS, add, compare
from sym2real.effects import compose, effect
from sym2real.effects.along_logs import predicted_from, prepared
from sym2real.neural import Composed, Ensemble, ResidualMLP
from sym2real.neural.leftover import leftover
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.robots.crazyflie import HOVER
from sym2real.symbolic import Equations
from sym2real.trajectory import Trajectory

COMMANDS, STATES = 3, 2
AHEAD = 4
OLDEST_SPEED = 7 + 2 * (1 + COMMANDS) - 1  # among what is seen
SEEN = 7 + 2 * (1 + COMMANDS) + 7 * STATES


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


@pytest.mark.parametrize("place", range(SEEN))
def test_a_residual_sees_of_a_log_what_it_was_trained_on(base: Equations, log: Trajectory, place: int) -> None:
    """Where the residual of x is a column of what is seen, x is off by what the training saw there."""
    trained = leftover(Dataset([log]).transitions(), base, COMMANDS, STATES)
    rows = np.arange(len(log) - AHEAD)
    changed = _x_moved_by(place, base, log, rows)[:, 0]
    torch.testing.assert_close(changed, trained.seen[rows, place].double(), rtol=1e-4, atol=1e-4)


def test_a_rollout_moves_past_commands_as_they_were_trained_on(base: Equations, log: Trajectory) -> None:
    """Where the residual of x is the oldest past command, x ends up by the sum of those further on."""
    trained = leftover(Dataset([log]).transitions(), base, COMMANDS, STATES)
    rows = np.arange(len(log) - AHEAD)
    oldest = trained.seen[:, OLDEST_SPEED].double()
    wanted = torch.stack([oldest[rows + step] for step in range(AHEAD)]).sum(0)
    torch.testing.assert_close(_x_moved_by(OLDEST_SPEED, base, log, rows)[:, -1], wanted, rtol=1e-4, atol=1e-4)


def test_models_in_single_precision_are_compared_with_logs(base: Equations, log: Trajectory) -> None:
    """Residuals and ensembles as they are trained, from Python: a residual of nothing predicts as its base does."""
    none = ResidualMLP(MUSHR.layouts, (4,))
    for weights in none.linears[-1].parameters():
        torch.nn.init.zeros_(weights)
    ensemble = Ensemble(MUSHR.layouts, 2, (4,), dt=base.dt, robot="mushr")
    for single, double in ((Composed(base, none), base), (ensemble, copy.deepcopy(ensemble).double())):
        ends = zip(*(compare(model, log).to_dict()["horizons"] for model in (single, double)), strict=True)
        for found, wanted in ends:
            for channel, figures in wanted["errors"].items():
                assert found["errors"][channel]["value"] == pytest.approx(figures["value"], rel=1e-3, abs=1e-5)


def test_hidden_states_go_on_from_piece_to_piece_of_a_simulated_log() -> None:
    """A rotor that spins up over seconds: pieces of two rows follow the flight that the model itself made."""
    slow = add(CRAZYFLIE.nominal(), "motor_lag", {"value": 0.3})
    rng = np.random.default_rng(0)
    action = np.tile([HOVER, 0.0, 0.0, 0.0], (60, 1))
    action[:, 0] *= 1.0 + 0.3 * rng.choice([-1.0, 1.0], 60)
    start = np.zeros((60, 13))
    start[:, 6] = 1.0
    still = Trajectory(
        np.arange(60) * slow.dt, start, action, np.zeros((60, CRAZYFLIE.layouts.inputs.size)), CRAZYFLIE.layouts
    )
    flown = slow.simulate(still)
    pieces = slow.simulate(flown, horizon=2 * slow.dt)
    np.testing.assert_allclose(pieces.state[:ROWS], flown.state[:ROWS], atol=1e-9)


def _x_moved_by(place: int, base: Equations, log: Trajectory, rows: NDArray[np.int64]) -> torch.Tensor:
    """What a residual of x that is a column of what it sees changes of x ``# (windows, steps)``."""
    predicted = []
    for size in (1.0, 0.0):
        predicting, (ready,) = prepared(Composed(base, _seen(place, size)), Dataset([log]))
        predicted.append(predicted_from(predicting, ready, rows, AHEAD)[..., 0])
    return predicted[0] - predicted[1]


def _seen(place: int, size: float) -> ResidualMLP:
    """So many times a column of what it sees, added to x: its positive part less its negative one."""
    residual = ResidualMLP(MUSHR.layouts, (2,), commands=COMMANDS, states=STATES)
    first, last = (layer for layer in residual.linears)
    with torch.no_grad():
        first.weight.zero_()
        first.weight[:, place] = torch.tensor([1.0, -1.0])
        last.weight[0] = size * torch.tensor([1.0, -1.0])
    return residual
