"""Forces on robots whose tyres hold: what equations without wrench inputs make of them, against MuJoCo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import add, compare
from sym2real.effects import injected
from sym2real.effects.body import Body
from sym2real.effects.wrench import with_force_inputs
from sym2real.layout import Layout
from sym2real.plants import MujocoPlant
from sym2real.robots import MUSHR, ROBOTS
from sym2real.symbolic import Equations, compile_model

FORCE = 0.1 * 9.81 * MUSHR.mass


@pytest.fixture(scope="module")
def wrenchless() -> Equations:
    """The nominal car as if it had been learned from logs, in which nobody writes a wrench."""
    nominal = MUSHR.nominal()
    bare = nominal.substitute(dict.fromkeys(nominal.layouts.inputs, 0.0))
    return replace(bare, layouts=replace(bare.layouts, inputs=Layout()))


@pytest.mark.parametrize("yaw", [0.0, np.pi / 2], ids=["along", "across"])
def test_a_force_moves_a_car_along_its_heading_alone(yaw: float, wrenchless: Equations) -> None:
    pushed = add(wrenchless, "wind", {"fx": FORCE})
    start = MUSHR.start.copy()
    start[MUSHR.layouts.state.indices(("sin_yaw", "cos_yaw"))] = np.sin(yaw), np.cos(yaw)
    plant = MujocoPlant(MUSHR, injected(pushed, MUSHR))
    model, still = compile_model(pushed, dtype=torch.float64), np.zeros(2)
    plant.reset(start)
    state = torch.as_tensor(start[None])
    for _ in range(20):
        truth = plant.step(still)
        state = model(state, torch.zeros(1, 2, dtype=torch.float64), torch.zeros(1, 0, dtype=torch.float64))
    moved, true = (np.asarray(end)[:2] - start[:2] for end in (state[0], truth))
    assert np.abs(true).max() > 0.01 if yaw == 0.0 else np.abs(true).max() < 2e-3
    np.testing.assert_allclose(moved, true, atol=0.1 * np.abs(true).max() if yaw == 0.0 else 2e-3)


@pytest.mark.slow
def test_a_slope_in_noisy_drives_is_predicted_without_a_wrench(wrenchless: Equations) -> None:
    data = simulate_case(Case("mushr", (("slope", {"gx": 0.685, "gy": -0.07}),), seed=8), trajectories=4)
    bare = Dataset(replace(log, inputs=np.zeros((len(log), 0)), layouts=wrenchless.layouts) for log in data)
    slope = {"gx": 0.685, "gy": -0.07}
    exact, before, after = (
        compare(model, logs).at(0.8).errors["position"].value
        for model, logs in (
            (add(MUSHR.nominal(), "slope", slope), data),
            (wrenchless, bare),
            (add(wrenchless, "slope", slope), bare),
        )
    )
    assert exact < 0.75 * before
    assert after < 1.1 * exact


@pytest.mark.parametrize("robot", ROBOTS)
def test_cars_and_driven_wheels_hold_and_flying_robots_do_not(robot: str) -> None:
    assert Body.of(ROBOTS[robot]).on_wheels == (robot in ("mushr", "differential_drive"))


@pytest.mark.parametrize("robot", ["crazyflie", "mushr"])
def test_inputs_of_a_force_are_what_adding_one_is(robot: str) -> None:
    nominal = ROBOTS[robot].nominal()
    bare = nominal.substitute(dict.fromkeys(nominal.layouts.inputs, 0.0))
    bare = replace(bare, layouts=replace(bare.layouts, inputs=Layout()))
    with_inputs, known = with_force_inputs(bare), {"fx": 0.2 * FORCE, "fy": -0.1 * FORCE}
    names = with_inputs.layouts.inputs.columns
    assert names == (("fx", "fy") if robot == "mushr" else ("fx", "fy", "fz"))
    rng = np.random.default_rng(0)
    state, action = rng.normal(size=(5, len(bare.layouts.state))), rng.uniform(0.1, 0.3, (5, len(bare.layouts.action)))
    state = bare.layouts.state.normalise(torch.as_tensor(state)).numpy()
    force = np.tile([known.get(name, 0.0) for name in names], (5, 1))
    none = np.zeros((5, 0))
    np.testing.assert_allclose(
        with_inputs.predict(state, action, 0 * force), bare.predict(state, action, none), atol=1e-9
    )
    pushed = add(bare, "wind", known).predict(state, action, none)
    np.testing.assert_allclose(with_inputs.predict(state, action, force), pushed, atol=1e-9)
    assert np.abs(pushed - bare.predict(state, action, none)).max() > 1e-3
    assert with_force_inputs(nominal) is nominal
