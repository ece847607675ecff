"""A changed robot, written and read again, moves as the robot with the changes injected."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from sym2real.effects import effect
from sym2real.errors import DataError, ModelError
from sym2real.plants import MujocoPlant, load_plant, save_plant
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.trajectory import Array

FLIGHTS = (
    (("added_mass", {"value": 0.0041234567}), ("com_offset", {"rx": 0.001, "ry": -0.0005})),
    (("delay", {"value": 0.047}), ("limit:thrust", {"upper": 0.29}), ("motor_lag", {"value": 0.03})),
    (("wind", {"fx": 0.01, "fy": -0.02}), ("linear_drag", {"cx": 0.01, "cy": 0.01, "cz": 0.01})),
    (("mounting_tilt", {"roll": 0.02}), ("sensor_bias:wx", {"value": 0.1}), ("payload", {"mass": 0.003, "rx": 0.02})),
)
DRIVES = (
    (("tyre_friction", {"value": 0.3}), ("gain:speed", {"value": 0.9})),
    (("offset:steer", {"value": 0.05}), ("lag:steer", {"value": 0.1}), ("delay", {"value": 0.1})),
    (("slope", {"gx": 0.2}), ("yaw_bias", {"value": 0.03})),
)
CASES = [(CRAZYFLIE, effects) for effects in FLIGHTS] + [(MUSHR, effects) for effects in DRIVES]


def moved(plant: MujocoPlant, steps: int = 40) -> Array:
    robot, rng = plant.robot, np.random.default_rng(0)
    start = robot.start.copy()
    start[: 3 if "z" in robot.layouts.state else 0] = 5.0
    states = [plant.reset(start)]
    for _ in range(steps):
        middle, half = (
            0.5 * (robot.limits.random_high + robot.limits.random_low),
            0.5 * (robot.limits.random_high - robot.limits.random_low),
        )
        states.append(plant.step(middle + 0.5 * half * rng.uniform(-1, 1, len(half))))
    return np.array(states)


@pytest.mark.parametrize(("robot", "effects"), CASES, ids=lambda value: getattr(value, "name", None) or value[0][0])
def test_a_written_plant_moves_as_the_changed_one(robot: Robot, effects: tuple, tmp_path: Path) -> None:
    save_plant(robot, effects, tmp_path)
    injected = moved(MujocoPlant(robot, [effect(key, robot).inject(**values) for key, values in effects]))
    # MuJoCo writes six digits.
    np.testing.assert_allclose(moved(load_plant(tmp_path)), injected, atol=2e-5)
    assert np.abs(injected - moved(MujocoPlant(robot))).max() > 0.01


def test_values_may_be_numbers_of_numpy(tmp_path: Path) -> None:
    """As of a fit or a draw; NumPy writes them as np.float64(…), which is no TOML."""
    save_plant(CRAZYFLIE, [("wind", {"fx": np.float64(0.01), "fy": np.float32(0.5)})], tmp_path)
    assert "fx 0.01, fy 0.5" in load_plant(tmp_path).changes[0].name


def test_the_description_alone_has_mass_and_centre_and_opens_anywhere(tmp_path: Path) -> None:
    description, _ = save_plant(CRAZYFLIE, FLIGHTS[0], tmp_path)
    model = mujoco.MjModel.from_xml_path(str(description))
    assert model.body_mass[1] == pytest.approx(CRAZYFLIE.mass + 0.0041234567, rel=1e-5)
    np.testing.assert_allclose(model.body_ipos[1], [0.001, -0.0005, 0.0])


def test_an_edited_plant_file_is_heeded(tmp_path: Path) -> None:
    _, file = save_plant(CRAZYFLIE, FLIGHTS[2], tmp_path)
    file.write_text(file.read_text().replace("fx = 0.01", "fx = 0.03"))
    changed = (("wind", {"fx": 0.03, "fy": -0.02}), FLIGHTS[2][1])
    injected = [effect(key, CRAZYFLIE).inject(**values) for key, values in changed]
    np.testing.assert_allclose(moved(load_plant(tmp_path)), moved(MujocoPlant(CRAZYFLIE, injected)), atol=2e-5)


@pytest.mark.parametrize(
    ("before", "after", "error", "message"),
    [
        ("robot = ", "robots = ", DataError, "robot"),
        ('"crazyflie"', '"crazyfly"', DataError, "did you mean 'crazyflie'"),
        ('effect = "wind"', 'effect = "winds"', ModelError, r"plant\.toml: unknown effect 'winds'"),
        ("fx = 0.01", 'fx = "strong"', ModelError, r"plant\.toml: wind: expected a number for fx, found 'strong'"),
        ("fx = 0.01", "fx = inf", ModelError, r"plant\.toml: wind: expected a finite number for fx"),
        ("fx = 0.01", "gx = 0.01", ModelError, r"plant\.toml: .*fx"),
        ('"robot.xml"', '"other.xml"', DataError, "other"),
        ("robot = ", "robot ", DataError, "plant.toml"),
    ],
)
def test_a_broken_plant_file_gets_one_clear_error(
    before: str, after: str, error: type[Exception], message: str, tmp_path: Path
) -> None:
    _, file = save_plant(CRAZYFLIE, FLIGHTS[2], tmp_path)
    file.write_text(file.read_text().replace(before, after))
    with pytest.raises(error, match=message):
        load_plant(tmp_path)


def test_a_broken_description_is_named(tmp_path: Path) -> None:
    description, _ = save_plant(CRAZYFLIE, FLIGHTS[0], tmp_path)
    description.write_text("<mujoco><body/></mujoco>")
    with pytest.raises(DataError, match=r"robot\.xml"):
        load_plant(tmp_path)
