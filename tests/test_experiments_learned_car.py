"""What pushes do to the learned car, against MuJoCo: along the heading, and by effects that resist a turn."""

import numpy as np
import pytest
import torch

from sym2real.effects import compose, effect
from sym2real.experiments.models import cached_base
from sym2real.plants import MujocoPlant
from sym2real.robots import MUSHR
from sym2real.symbolic import Equations, compile_model
from sym2real.trajectory import Array

SETTLED = 60  # steps, 3 s
TURNS = [(0.2, 1.0), (-0.2, 1.0), (0.3, 1.0), (0.2, 1.8), (0.1, 1.8)]


@pytest.fixture(scope="module")
def learned() -> Equations:
    return cached_base(MUSHR)


def _forward(state: Array) -> float:
    return float(state[4] * state[3] + state[5] * state[2])


def _driven(action: tuple[float, float], plant: MujocoPlant, force: float = 0.0) -> float:
    """Forward speed of the simulated car after a while, pushed along its heading by so many N."""
    state = plant.reset(MUSHR.start)
    for _ in range(SETTLED):
        plant.push(np.array([force * state[3], force * state[2], 0.0]))
        state = plant.step(np.array(action))
    return _forward(state)


def _predicted(action: tuple[float, float], equations: Equations, force: float = 0.0) -> float:
    """The same by equations."""
    model, state = compile_model(equations, dtype=torch.float64), torch.as_tensor(MUSHR.start)
    for _ in range(SETTLED):
        wrench = torch.stack([force * state[3], force * state[2], 0.0 * state[2]])
        state = MUSHR.layouts.state.normalise(model(state, torch.tensor(action, dtype=torch.float64), wrench))
    return _forward(state.numpy())


@pytest.mark.parametrize("action", [(0.0, 1.0), *TURNS])
def test_a_force_along_the_heading_changes_the_speed_as_in_the_simulator(
    learned: Equations, action: tuple[float, float]
) -> None:
    plant = MujocoPlant(MUSHR)
    truth = _driven(action, plant, 3.0) - _driven(action, plant)
    found = _predicted(action, learned, 3.0) - _predicted(action, learned)
    assert found == pytest.approx(truth, rel=0.1)


@pytest.mark.parametrize(("key", "value"), [("yaw_drag", 4.0), ("lateral_slip", 5.0)])
def test_what_resists_a_turn_costs_the_speed_that_it_costs_in_the_simulator(
    learned: Equations, key: str, value: float
) -> None:
    informed = compose(learned, [(effect(key, learned), {"value": value})])
    plain, braked = MujocoPlant(MUSHR), MujocoPlant(MUSHR, [effect(key, MUSHR).inject(value=value)])
    for action in TURNS:
        truth = _driven(action, braked) - _driven(action, plain)
        assert _predicted(action, informed) - _predicted(action, learned) == pytest.approx(truth, rel=0.12)
