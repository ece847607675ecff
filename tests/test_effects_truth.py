"""What effects substitute in equations against what MuJoCo does when it has the effect by its own means."""

from __future__ import annotations

import numpy as np
import pytest
from effects_cases import CASES, Run, both_changes, nominal, one_key_per_kind, run, simulated

from sym2real.effects import EFFECTS, effect
from sym2real.robots import ROBOTS, Robot


@pytest.mark.parametrize(
    ("robot", "key", "values", "cosine", "tolerance"),
    CASES,
    ids=[f"{robot.name}-{key}-{next(iter(values.values()))}" for robot, key, values, *_ in CASES],
)
def test_substitution_does_what_injection_does(
    robot: Robot, key: str, values: dict[str, float], cosine: float, tolerance: float
) -> None:
    truth, hypothesis = both_changes(effect(key, robot), robot, values)
    size = np.linalg.norm(truth)
    assert size > 1.0, "the manoeuvre does not show the effect"
    assert (truth * hypothesis).sum() / (size * np.linalg.norm(hypothesis)) > cosine
    assert np.linalg.norm(hypothesis) / size == pytest.approx(1.0, abs=tolerance)


def test_every_effect_is_held_against_the_simulator() -> None:
    assert {key.partition(":")[0] for _, key, *_ in CASES} == set(EFFECTS)


@pytest.mark.parametrize("name", ROBOTS)
def test_nothing_is_injected_at_the_null_value(name: str) -> None:
    robot = ROBOTS[name]
    one = Run(robot, run(robot).starts[:1], run(robot).actions[:1])
    expected = simulated(one, [])
    for key in one_key_per_kind(robot):
        found = effect(key, robot)
        measured = simulated(one, [found.inject(**found.null)])
        np.testing.assert_allclose(measured, expected, atol=1e-12, err_msg=key)
        assert found.substitute(nominal(robot), found.null) is nominal(robot)
