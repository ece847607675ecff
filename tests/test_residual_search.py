"""Beam search as residual learner: it finds what MuJoCo was given, adds nothing to what is right, and stays frozen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from tracked import tracked

from sym2real.adaptation.predictions import horizon_errors
from sym2real.adaptation.residual_search import ResidualSearch, with_added
from sym2real.dataset import Dataset, Transitions
from sym2real.effects import effect
from sym2real.errors import ModelError, UnknownNameError
from sym2real.experiments.learning import training_tasks
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.experiments.standard_conditions import sensors
from sym2real.layout import Layouts
from sym2real.neural import Composed, Ensemble, SymbolicResidual
from sym2real.plants import EquationsPlant, MujocoPlant
from sym2real.protocols import Change
from sym2real.regression.residual_terms import ResidualSettings, residual_terms
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import Equations, compile_model, symbol
from sym2real.trajectory import Trajectory

WIND = 0.02  # N along x
PUSH = WIND / CRAZYFLIE.numbers["mass"] * CRAZYFLIE.dt  # m/s a step
NOISE = sensors(CRAZYFLIE, np.random.default_rng(4))


def flown(*changes: Change, rows: int = 240) -> Transitions:
    return tracked(MujocoPlant(CRAZYFLIE, changes), rows=rows)


def added(model: Equations, base: Equations, transitions: Transitions) -> np.ndarray:
    """Mean of what the terms add to every column in a step."""
    state, action = torch.tensor(transitions.state), torch.tensor(transitions.action)
    pair = [compile_model(one, dtype=torch.float64)(state, action) for one in (model, base)]
    return (pair[0] - pair[1]).mean(0).numpy()


@pytest.fixture(scope="module")
def base() -> Equations:
    return CRAZYFLIE.nominal()


@pytest.mark.parametrize("rows", [(50, 40), (40, 10, 40)])
def test_rows_too_few_for_a_window_are_no_block(rows: tuple[int, ...]) -> None:
    layouts, rng = Layouts.of(["x", "vx", "speed"]), np.random.default_rng(0)
    logs = [
        Trajectory.from_arrays(rng.standard_normal((n + 1, 2)), rng.standard_normal((n + 1, 1)), layouts, dt=0.05)
        for n in rows
    ]
    transitions = Dataset(logs).transitions()
    left = np.stack([0.3 * transitions.state[:, 1], np.zeros(len(transitions))], axis=1)
    found = residual_terms(transitions, left, ResidualSettings(degree=1))
    assert found.keys() == {"x"}
    assert float(found["x"].coeff(symbol("vx"))) == pytest.approx(0.3)


@pytest.mark.parametrize("noisy", [False, True])
def test_a_wind_of_mujocos_is_found(base: Equations, noisy: bool) -> None:
    before = base.to_json()
    windy = flown(*([NOISE] if noisy else []), effect("wind", CRAZYFLIE).inject(fx=WIND))
    model = ResidualSearch(ResidualSettings(degree=2)).fit(windy, base)
    assert isinstance(model, Equations)
    assert base.to_json() == before
    found = added(model, base, windy)
    assert found[7] == pytest.approx(PUSH, rel=0.15)
    assert np.abs(found[[8, 9]]).max() < 0.15 * PUSH
    assert model.next["vx"] != base.next["vx"]


def test_mass_is_found_in_the_thrust(base: Equations) -> None:
    """Three grams more: the push that lacks in vz′ is a tenth of what holds the weight."""
    heavy = flown(effect("added_mass", CRAZYFLIE).inject(value=0.003))
    model = ResidualSearch().fit(heavy, base)
    assert isinstance(model, Equations)
    mass = CRAZYFLIE.numbers["mass"]
    assert float(added(model, base, heavy)[9]) == pytest.approx(-CRAZYFLIE.dt * 9.81 * 0.003 / mass, rel=0.1)
    assert ResidualSearch().fit(heavy, base).to_json() == model.to_json()


def test_nothing_is_added_to_what_is_right(base: Equations) -> None:
    """The log is the base's own, seen by noisy sensors: what is added is far below what noise makes of a step."""
    clean = tracked(EquationsPlant(base, CRAZYFLIE), rows=240)
    assert ResidualSearch().fit(clean, base).to_json() == base.to_json()
    noisy = NOISE.measure()
    states = np.array([noisy(state) for state in (*clean.state, clean.next_state[-1])])
    model = ResidualSearch().fit(replace(clean, state=states[:-1], next_state=states[1:]), base)
    assert isinstance(model, Equations)
    assert np.abs(added(model, base, clean)).max() < 2e-3


def test_one_noisy_log_leads_no_prediction_astray(base: Equations) -> None:
    """Noise of 300 rows has terms too; rolled out over 0.8 s they once took a model beyond all numbers."""
    learned, unseen = noisy_runs(CRAZYFLIE, training_tasks(CRAZYFLIE), count=2, rows=300, seed=3)
    model = ResidualSearch().fit(Dataset([learned]).transitions(), base)
    errors = [float(np.linalg.norm(horizon_errors(one, [unseen], 40), axis=1).mean()) for one in (base, model)]
    assert errors[1] < 1.1 * errors[0]


def test_an_ensemble_keeps_its_weights_below_expressions() -> None:
    ensemble = Ensemble(CRAZYFLIE.layouts, 2, (4,), seed=1)
    with torch.no_grad():
        ensemble.output_scale.zero_()  # predicts no change: what lacks is the whole motion
    before = {name: tensor.clone() for name, tensor in ensemble.state_dict().items()}
    windy = flown()
    model = ResidualSearch(ResidualSettings(degree=2)).fit(windy, ensemble)
    assert isinstance(model, Composed)
    assert isinstance(model.residual, SymbolicResidual)
    assert all(torch.equal(tensor, before[name]) for name, tensor in ensemble.state_dict().items())
    state, action = torch.tensor(windy.state).float(), torch.tensor(windy.action).float()
    wrong = model(state, action) - torch.tensor(windy.next_state).float()
    moved = torch.tensor(windy.next_state - windy.state).float()
    assert float(wrong[:, :3].norm()) < 0.1 * float(moved[:, :3].norm())


def test_what_does_not_fit_is_refused(base: Equations) -> None:
    short = flown(rows=30)
    with pytest.raises(ModelError, match="at least 10 windows of 20 consecutive transitions, found 3"):
        ResidualSearch().fit(short, base)
    with pytest.raises(UnknownNameError, match="'nowhere'"):
        with_added(base, {"nowhere": symbol("x")})
