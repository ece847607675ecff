"""What models with networks predict of a step and of a log, and how well: methods that equations have, too."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from test_neural import lively

from sym2real.control import RandomCommands
from sym2real.effects import effect
from sym2real.errors import ShapeError
from sym2real.neural import Composed, Ensemble, Model
from sym2real.plants import ModelPlant, run_episode
from sym2real.robots import MUSHR
from sym2real.trajectory import Trajectory

ENSEMBLE = Ensemble(MUSHR.layouts, 2, (8, 8), seed=3, dt=MUSHR.dt, robot=MUSHR.name)
ENSEMBLE.output_scale.fill_(0.01)  # untrained weights would lead it far away
MODELS = {
    "equations and network": lambda: Composed(MUSHR.nominal(), lively(MUSHR, (8, 8))),
    "a network that remembers": lambda: Composed(MUSHR.nominal(), lively(MUSHR, (8, 8), commands=6, states=2)),
    "ensemble": lambda: ENSEMBLE,
    "ensemble and network": lambda: Composed(ENSEMBLE, lively(MUSHR, (8, 8))),
}


def driven(model: Model) -> Trajectory:
    return run_episode(ModelPlant(model, MUSHR), RandomCommands(MUSHR, seed=3), steps=60)


@pytest.mark.parametrize("kind", MODELS)
def test_a_model_simulates_its_own_log_and_scores_it_a_hundred(kind: str) -> None:
    model = MODELS[kind]()
    log = driven(model)
    again = model.simulate(log, horizon=0.5)
    np.testing.assert_allclose(again.state, log.state, atol=1e-4)
    assert (again.name, again.layouts) == (f"{log.name} simulated".strip(), log.layouts)
    plain = MUSHR.nominal().score(log)
    for channel, fit in model.score(log).items():
        assert fit > 99.9 > plain[channel]


@pytest.mark.parametrize("kind", MODELS)
def test_a_step_is_what_the_plant_does_from_rest(kind: str) -> None:
    """In rows of any shape; NumPy comes back as NumPy of double precision, a tensor as one of its own."""
    model = MODELS[kind]()
    log = driven(model)
    after = model.predict(log.state[:1], log.action[:1])
    assert isinstance(after, np.ndarray)
    assert after.dtype == np.float64
    np.testing.assert_allclose(after, log.state[1:2], atol=1e-5)
    state, action = torch.as_tensor(log.state[0], dtype=torch.float32), torch.as_tensor(log.action[0])
    one = model.predict(state, action)
    assert one.dtype == torch.float32
    torch.testing.assert_close(one.double(), torch.as_tensor(after[0]), atol=1e-5, rtol=0)
    assert not one.requires_grad  # what it has learned is no variable of a prediction; what is given may be
    assert model.predict(state.requires_grad_(), action).requires_grad
    with pytest.raises(ShapeError, match="columns x y sin_yaw"):
        model.predict(log.state[0, :3], log.action[0])


def test_what_is_predicted_is_what_sensors_report() -> None:
    """A heading that is read wrong by 0.1 rad is predicted so, by a model with a network as by its equations alone."""
    turned = effect("yaw_bias", MUSHR).substitute(MUSHR.nominal(), {"value": 0.1})
    silent = Composed(turned, lively(MUSHR, (8, 8)))
    with torch.no_grad():
        silent.residual.linears[-1].weight.zero_()
        silent.residual.linears[-1].bias.zero_()
    log = driven(MODELS["equations and network"]())
    np.testing.assert_allclose(silent.predict(log.state, log.action), turned.predict(log.state, log.action), atol=1e-5)
    assert np.abs(turned.predict(log.state, log.action) - MUSHR.nominal().predict(log.state, log.action)).max() > 1e-3
