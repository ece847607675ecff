"""Ensembles trained on transitions: they predict what they have not seen, differ where they know little, and repeat."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sym2real.control import RandomCommands
from sym2real.dataset import Dataset, Transitions
from sym2real.errors import ShapeError
from sym2real.neural import Composed, Descent, Ensemble, EnsembleTraining, ResidualTraining
from sym2real.plants import EquationsPlant, run_episode
from sym2real.robots import MUSHR

SMALL = EnsembleTraining(members=3, widths=(32, 32), robot="mushr", descent=Descent(400, 3e-3, rows=128))


def driven(seed: int, rows: int = 400) -> Transitions:
    plant = EquationsPlant(MUSHR.nominal(), MUSHR)
    return Dataset([run_episode(plant, RandomCommands(MUSHR, seed=seed), None, steps=rows + 1)]).transitions()


@pytest.fixture(scope="module")
def rows() -> Transitions:
    return driven(0)


@pytest.fixture(scope="module")
def ensemble(rows: Transitions) -> Ensemble:
    return SMALL.fit(rows)


def change_error(model: Ensemble | Composed, rows: Transitions) -> float:
    """Of the change in a step, over the change itself."""
    state, action = (torch.tensor(values).float() for values in (rows.state, rows.action))
    following = torch.tensor(rows.next_state).float()
    with torch.no_grad():
        return float((model(state, action) - following).norm() / (following - state).norm())


def test_it_predicts_a_drive_that_it_has_not_seen(ensemble: Ensemble, rows: Transitions) -> None:
    assert change_error(ensemble, driven(1)) < 0.7  # 1 is that nothing changes; one drive teaches a network little
    assert change_error(ensemble, rows) < 0.5
    assert (ensemble.dt, ensemble.robot) == (pytest.approx(MUSHR.dt), "mushr")
    near = ensemble.members(torch.tensor(rows.state).float(), torch.tensor(rows.action).float())
    far = ensemble.members(5 + torch.tensor(rows.state).float(), torch.tensor(rows.action).float())
    assert float(far.std(0).mean()) > 3 * float(near.std(0).mean())


def test_variances_are_those_of_the_noise() -> None:
    """Change of one column is noise of a known size: the predicted variance is its square."""
    rng, rows = np.random.default_rng(0), driven(2)
    noisy = rows.next_state.copy()
    noisy[:, 4] = rows.state[:, 4] + 0.3 * rng.standard_normal(len(rows))
    training = EnsembleTraining(2, (16,), probabilistic=True, descent=Descent(600, 1e-2, rows=128))
    made = training.fit(Transitions(**{**vars(rows), "next_state": noisy}))
    with torch.no_grad():
        outputs = made.outputs(torch.tensor(rows.state).float(), torch.tensor(rows.action).float())
        deviation = (made.log_variance(outputs) / 2).exp() * made.output_scale
    assert float(deviation[..., 4].median()) == pytest.approx(0.3, rel=0.2)
    assert bool((made.log_variance(outputs) <= made.highest + 1e-4).all())
    assert bool((made.log_variance(outputs) >= made.lowest - 1e-4).all())


def test_the_same_seed_gives_the_same_bits_and_a_start_goes_on(ensemble: Ensemble, rows: Transitions) -> None:
    short = EnsembleTraining(3, (32, 32), robot="mushr", descent=Descent(20, 1e-3, rows=128))
    first, second = short.fit(rows), short.fit(rows)
    assert all(torch.equal(one, second.state_dict()[name]) for name, one in first.state_dict().items())
    before = {name: tensor.clone() for name, tensor in ensemble.state_dict().items()}
    tuned = short.fit(rows, ensemble)
    assert change_error(tuned, rows) < change_error(first, rows)
    assert all(torch.equal(tensor, before[name]) for name, tensor in ensemble.state_dict().items())
    with pytest.raises(ShapeError, match="members and widths"):
        EnsembleTraining(2, (8,)).fit(rows, ensemble)


def test_a_residual_on_a_frozen_ensemble(ensemble: Ensemble, rows: Transitions) -> None:
    """NN*+NN: every row gains speed along x, whatever its neighbours do; the ensemble's weights stay bit for bit."""
    before = {name: tensor.clone() for name, tensor in ensemble.state_dict().items()}
    target = Transitions(**{**vars(rows), "next_state": rows.next_state + np.eye(7)[4] * 0.02})
    model, report = ResidualTraining(steps=1, descent=Descent(150)).fit_reported(target, ensemble)
    assert isinstance(model.below, Ensemble)
    assert all(torch.equal(tensor, before[name]) for name, tensor in ensemble.state_dict().items())
    assert "vx" in report.columns
    state, action = (torch.tensor(values).float() for values in (rows.state, rows.action))
    with torch.no_grad():
        wrong = [one(state, action)[:, 4] - torch.tensor(target.next_state[:, 4]).float() for one in (model, ensemble)]
    assert abs(float(wrong[0].mean())) < 0.7 * abs(float(wrong[1].mean()))
