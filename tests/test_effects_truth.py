"""What effects substitute in equations against what MuJoCo does when it has the effect by its own means."""

from __future__ import annotations

from functools import cache

import motor_flights
import numpy as np
import pytest
from effects_cases import (
    CASES,
    Run,
    both_changes,
    change,
    nominal,
    one_key_per_kind,
    predicted,
    run,
    simulated,
    wander,
)
from paper_robots import PAPER_ROBOTS

from sym2real.effects import EFFECTS, effect
from sym2real.errors import ModelError
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, ROBOTS, Robot
from sym2real.robots.crazyflie import ROTOR_THRUST

# Key, values, least direction cosine, how far the ratio of sizes may be from 1.
OF_MOTORS = [
    ("torque_scale", {"kx": 0.5, "ky": 1.5, "kz": 0.1}, 0.999, 0.01),
    ("torque_scale", {"kz": 4.0}, 0.999, 0.01),
    ("rotor_loss", {"rotor": 2, "value": 0.02}, 0.999, 0.02),
    ("limit", {"upper": 1530.0}, 0.999, 0.01),
    ("rotor_reaction", {"value": 2e-8}, 0.99, 0.05),
    ("rate_damping", {"dx": 2e-5, "dy": 4e-5, "dz": 2e-5}, 0.999, 0.02),
    ("flapping_moment", {"a": 2e-6, "b": -3e-6}, 0.999, 0.03),
]


@cache
def run_of_motors() -> Run:
    """Starts of the robot with a rate loop; motors about hover, 0.5 s at 50 Hz."""
    rng, robot, starts = np.random.default_rng(2), motor_flights.SPINNING, run(CRAZYFLIE).starts
    hover = np.sqrt(CRAZYFLIE.rest[0] / 4 / ROTOR_THRUST)
    commands = [hover * (1 + wander(rng, 25, [0.02] * 4, 2.0)) for _ in starts]
    return Run(robot, starts, np.array(commands))


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
    """Those of joints in test_robots_from_mjcf.py, of wheels on one axle in test_robots_differential_drive.py.

    No simulated robot is told an attitude: see test_effects_attitude_loop.py. A softer speed loop gives way to a turn's
    scrub, which the first-principles car lacks: see test_effects_speed_loop.py, straight ahead. Named parameters are
    those of equations of one's own, which no description has: see test_diagnosis_parameters.py.
    """
    keys = [key for _, key, *_ in CASES] + [key for key, *_ in OF_MOTORS]
    of_joints = {name for name, kind in EFFECTS.items() if kind.robot == "robot with joints"}
    assert {key.partition(":")[0] for key in keys} == set(EFFECTS) - of_joints - {
        "attitude_loop",
        "attitude_trim",
        "attitude_gain",
        "speed_loop",
        "parameter",
        "turning_friction",
        "wheel_radius",
        "track_width",
        "wheel_grip",
        "carried_mass",
    }


@pytest.mark.parametrize(("key", "values", "cosine", "tolerance"), OF_MOTORS)
def test_substitution_does_what_injection_does_to_a_robot_of_motors(
    key: str, values: dict[str, float], cosine: float, tolerance: float
) -> None:
    """Four actuators at four sites, whose speeds are known, against equations of motor speeds."""
    given, base, own = run_of_motors(), motor_flights.equations(unit="rad/s"), motor_flights.description()
    plain, truth = (simulated(given, changes, own) for changes in ([], [effect(key, given.robot).inject(**values)]))
    changed = change(given.robot, truth, plain)
    hypothesis = effect(key, base).substitute(base, values)
    predictions = [predicted(equations, given) for equations in (hypothesis, base)]
    expected = change(given.robot, *predictions)
    size = np.linalg.norm(changed)
    assert size > 1.0
    assert (changed * expected).sum() / (size * np.linalg.norm(expected)) > cosine
    assert np.linalg.norm(expected) / size == pytest.approx(1.0, abs=tolerance)


def test_a_rate_loop_has_no_motors_whose_torque_could_be_scaled() -> None:
    with pytest.raises(ModelError, match="rate loop"):
        MujocoPlant(CRAZYFLIE, [effect("torque_scale", CRAZYFLIE).inject(kx=2.0)])
    assert "torque_x" in effect("torque_scale", CRAZYFLIE).why_not(nominal(CRAZYFLIE))


@pytest.mark.parametrize("name", PAPER_ROBOTS)
def test_nothing_is_injected_at_the_null_value(name: str) -> None:
    robot = ROBOTS[name]
    one = Run(robot, run(robot).starts[:1], run(robot).actions[:1])
    expected = simulated(one, [])
    for key in one_key_per_kind(robot):
        found = effect(key, robot)
        measured = simulated(one, [found.inject(**found.null)])
        np.testing.assert_allclose(measured, expected, atol=1e-12, err_msg=key)
        assert found.substitute(nominal(robot), found.null) is nominal(robot)
