"""Six joints: equations that are the simulator, five hidden effects, the whole way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
import whole_way

from sym2real.cli import main
from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.effects import effect
from sym2real.errors import ShapeError
from sym2real.experiments.noisy_runs import Effects, noisy_runs
from sym2real.plants import MujocoPlant
from sym2real.robots import ROBOTS
from sym2real.symbolic import Equations, compile_model
from sym2real.tasks import make_task

ARM = ROBOTS["arm"]
POSTURES = (
    {"waist": 0.5, "shoulder": 0.7, "elbow": 0.9, "forearm_roll": 0.8, "wrist_bend": 1.0, "wrist_roll": 0.6},
    {"waist": -0.5, "shoulder": 0.1, "elbow": 1.5, "forearm_roll": -0.2, "wrist_bend": 0.2, "wrist_roll": -0.4},
)
HIDDEN = [
    ("joint_friction:elbow", {"value": 0.8}),
    ("armature:elbow", {"value": 0.25}),
    ("load:tool", {"value": 0.3}),
    ("gravity_tilt", {"pitch": 0.05}),
    ("gain:elbow_motor", {"value": 0.85}),
]


@pytest.fixture(scope="module")
def base() -> Equations:
    return ARM.nominal()


def moves(effects: Effects = (), count: int = 3, rows: int = 200) -> Dataset:
    tasks = [make_task("regulate", ARM, goal=posture) for posture in POSTURES]
    return noisy_runs(ARM, tasks, effects, count=count, rows=rows)


@pytest.mark.slow
def test_equations_of_six_joints_are_the_simulator(base: Equations) -> None:
    model, plant, rng = compile_model(base, dtype=torch.float64), MujocoPlant(ARM), np.random.default_rng(0)
    for _ in range(10):
        state = ARM.start + rng.uniform(-0.4, 0.4, 12)
        action = ARM.rest + 0.1 * rng.uniform(-1.0, 1.0, 6) * (ARM.high - ARM.low)
        push = 0.2 * rng.uniform(-1.0, 1.0, 6)
        plant.reset(state)
        plant.push(push)
        after = plant.step(action)
        found = model(*map(torch.as_tensor, (state, action, push))).numpy()
        assert np.linalg.norm(found - after) < 3e-3 * np.linalg.norm(after - state)


def test_it_stands_still_where_it_starts() -> None:
    """The keyframe's torques hold it against gravity."""
    plant = MujocoPlant(ARM)
    start = plant.reset()
    np.testing.assert_allclose(plant.step(ARM.rest), start, atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("key", "values"), HIDDEN, ids=[key for key, _ in HIDDEN])
def test_a_hidden_effect_is_named(key: str, values: dict[str, float], base: Equations) -> None:
    found = diagnose(base, moves([(key, values)]))
    assert found.findings, found.summary
    assert key in (found.findings[0].effect, *found.findings[0].group), found.summary


@pytest.mark.slow
def test_a_plain_arm_misses_nothing(base: Equations) -> None:
    found = diagnose(base, moves(count=4, rows=250))
    assert (found.verdict, found.findings) == ("NOTHING_MISSING", ())


@pytest.mark.slow
def test_the_whole_way_from_the_command_line(tmp_path: Path) -> None:
    main(["learn", "arm", "--out", str(tmp_path / "base")])
    log = moves([("load:tool", {"value": 0.5})], count=1, rows=250)[0]
    whole_way.go(tmp_path / "base", log, "regulate", ["load:tool", "value=0.5"], channel="joint angle", folder=tmp_path)


def test_what_does_not_apply_is_refused_in_words(base: Equations) -> None:
    assert effect("wind", base).why_not(base) == "wind needs vx, vy, which is no column or quantity here"
    assert effect("wheelbase", base).why_not(base) == "wheelbase is an effect of a car"
    with pytest.raises(ShapeError, match="'regulate' is for any robot"):
        make_task("circle", ARM)
