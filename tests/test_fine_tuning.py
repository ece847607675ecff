"""Fine-tuning of a base: a mass of MuJoCo's is found in its constants, and a right base stays."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from tracked import tracked

from sym2real.adaptation.fine_tuning import FineTuning
from sym2real.dataset import Transitions
from sym2real.effects import effect
from sym2real.errors import ModelError, ShapeError
from sym2real.experiments.standard_conditions import sensors
from sym2real.neural import Ensemble
from sym2real.neural.leftover import errors_by_parameters, leftover
from sym2real.plants import EquationsPlant, MujocoPlant
from sym2real.protocols import Change
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import Equations, compile_model, lift_constants, rollout

HEAVY = effect("added_mass", CRAZYFLIE).inject(value=0.259 * CRAZYFLIE.numbers["mass"])
NOISE = sensors(CRAZYFLIE, np.random.default_rng(2))
STEPS = 20


def flown(*changes: Change, task: str = "circle", rows: int = 300) -> Transitions:
    return tracked(MujocoPlant(CRAZYFLIE, changes), task, rows=rows)


def position_error(model: Equations, transitions: Transitions) -> float:
    """Mean error in m after :data:`STEPS` rows, from every row."""
    state, action = torch.tensor(transitions.state), torch.tensor(transitions.action)
    starts = torch.arange(len(state) - STEPS)
    actions = torch.stack([action[starts + step] for step in range(STEPS)], dim=1)
    predicted = rollout(compile_model(model, dtype=torch.float64), state[starts], actions)[:, -1]
    return float((predicted - state[starts + STEPS])[:, :3].norm(dim=-1).mean())


@pytest.fixture(scope="module")
def base() -> Equations:
    return CRAZYFLIE.nominal()


def test_a_mass_of_mujocos_is_found_in_the_constants(base: Equations) -> None:
    """By noisy sensors, judged on another task: thrust pushes vz by dt / mass, the one number that it is behind."""
    before, heavy = base.to_json(), flown(NOISE, HEAVY)
    model, report = FineTuning().fit_reported(heavy, base)
    assert base.to_json() == before
    assert report.penalty is not None
    assert "vz" in report.columns
    elsewhere = flown(HEAVY, task="lemniscate")
    assert position_error(model, elsewhere) < 0.25 * position_error(base, elsewhere)
    assert set(model.parameters) == set(base.parameters)
    again = FineTuning().fit(heavy, base, start=model)
    assert isinstance(again, Equations)
    assert again.to_json() == model.to_json()


def test_a_right_base_stays(base: Equations) -> None:
    """The log is the base's own: exactly as it is, and seen by noisy sensors within what their noise does."""
    right = tracked(EquationsPlant(base, CRAZYFLIE), rows=300)
    assert FineTuning().fit(right, base) is base
    noisy = flown(NOISE)
    model = FineTuning().fit(noisy, base)
    assert isinstance(model, Equations)
    assert position_error(model, flown(task="lemniscate")) < position_error(base, noisy)


def test_errors_by_parameters_are_those_of_the_equations_with_them(base: Equations) -> None:
    heavy, lifted = flown(HEAVY, rows=60), lift_constants(base)
    values = torch.tensor(list(lifted.parameters.values()), dtype=torch.float64)
    found = errors_by_parameters(heavy, lifted)(torch.stack([values, 1.1 * values]))
    changed = lifted.at(**{name: 1.1 * value for name, value in lifted.parameters.items()})
    torch.testing.assert_close(found[..., 0], leftover(heavy, base).error)
    torch.testing.assert_close(found[..., 1], leftover(heavy, changed).error)


def test_an_ensemble_goes_on_from_its_weights() -> None:
    ensemble = Ensemble(CRAZYFLIE.layouts, 2, (8,), seed=1)
    before = {name: tensor.clone() for name, tensor in ensemble.state_dict().items()}
    heavy = flown(HEAVY, rows=100)
    tuned = FineTuning().fit(heavy, ensemble)
    assert isinstance(tuned, Ensemble)
    assert all(torch.equal(tensor, before[name]) for name, tensor in ensemble.state_dict().items())
    state, action = torch.tensor(heavy.state).float(), torch.tensor(heavy.action).float()
    with torch.no_grad():
        wrong = [(model(state, action) - torch.tensor(heavy.next_state)).norm() for model in (tuned, ensemble)]
    assert float(wrong[0]) < 0.2 * float(wrong[1])


def test_what_cannot_be_tuned_is_refused(base: Equations) -> None:
    with pytest.raises(ModelError, match="at least 40 consecutive transitions, found 15"):
        FineTuning().fit(flown(rows=15), base)
    with pytest.raises(ShapeError, match="state columns are"):
        FineTuning().fit(flown(rows=60), MUSHR.nominal())
