"""What ``simulate`` writes: exact states, or a log with sensor noise that the seed draws."""

from pathlib import Path

import numpy as np
import pytest
from cli_results import Refused

from sym2real.cli import main
from sym2real.experiments.standard_conditions import POSITION_NOISE
from sym2real.logs import read_log
from sym2real.logs.noise import noise_level
from sym2real.plants import save_plant
from sym2real.robots import CRAZYFLIE, ROBOTS


def test_the_seed_draws_the_noise_of_a_simulated_log(tmp_path: Path) -> None:
    """The same seed gives the same file, another one other noise on the same flight; without noise states are exact."""
    logs = {}
    for name, options in (
        ("exact", []),
        ("first", ["--noise"]),
        ("again", ["--noise"]),
        ("other", ["--noise", "--seed", "1"]),
    ):
        log = tmp_path / f"{name}.csv"
        main(["simulate", "crazyflie", "circle", "--seconds", "4", "--out", str(log), *options])
        logs[name] = read_log(log)
    assert (tmp_path / "first.csv").read_bytes() == (tmp_path / "again.csv").read_bytes()
    positions = {name: log.state[:, :3] for name, log in logs.items()}
    # Two flights with noise of 0.5 mm each; the controller's answer to it moves them apart more slowly.
    apart = noise_level(positions["first"] - positions["other"])
    np.testing.assert_allclose(apart, np.sqrt(2) * POSITION_NOISE, rtol=0.25)
    assert noise_level(positions["exact"], 6).max() < 1e-7


def test_a_sensors_bias_stays_beneath_the_noise(tmp_path: Path) -> None:
    """Velocities are differences of noisy positions: an effect on them must come after that."""
    logs = {}
    for name, options in (("plain", []), ("biased", ["--effects", "sensor_bias:vx", "value=0.3"])):
        main(["simulate", "crazyflie", "hover", "--noise", "--out", str(tmp_path / f"{name}.csv"), *options])
        logs[name] = read_log(tmp_path / f"{name}.csv")
    off = logs["biased"].column("vx")[:50].mean() - np.gradient(logs["biased"].column("x"), 0.02)[:50].mean()
    assert off == pytest.approx(0.3, abs=0.02)


def test_a_written_simulator_is_measured_with_the_same_noise(tmp_path: Path) -> None:
    """A robot that is heavier by its description flies as one that is made heavier, noise and all."""
    save_plant(CRAZYFLIE, [("added_mass", {"value": 0.004})], tmp_path / "simulator")
    robots = {"written": [str(tmp_path / "simulator")], "made": ["crazyflie"]}
    states = {}
    for name, robot in robots.items():
        effects = ["--effects", "added_mass", "value=0.004"] if name == "made" else []
        log = tmp_path / f"{name}.csv"
        main(["simulate", *robot, "circle", "--seconds", "2", "--noise", *effects, "--out", str(log)])
        states[name] = read_log(log).state
    # MuJoCo writes the description with six digits.
    np.testing.assert_allclose(states["written"], states["made"], atol=2e-5)


def test_the_manoeuvre_that_a_plan_looks_at_can_be_recorded(tmp_path: Path) -> None:
    """To a goal, with noise on the commands that the seed draws and that is no sensor's."""
    logs = {}
    for name, options in (("still", []), ("dithered", ["--dither", "1"]), ("again", ["--dither", "1"])):
        log = tmp_path / f"{name}.csv"
        main(["simulate", "cart_pole", "regulate", "slider=0.3", "--noise", "--out", str(log), *options])
        logs[name] = read_log(log, layouts=ROBOTS["cart_pole"].layouts)
    assert logs["still"].column("slider")[-100:].mean() == pytest.approx(0.3, abs=0.05)
    assert (tmp_path / "dithered.csv").read_bytes() == (tmp_path / "again.csv").read_bytes()
    np.testing.assert_array_equal(logs["still"].state[0], logs["dithered"].state[0])
    first = logs["dithered"].action[0] - logs["still"].action[0]  # of equal states
    assert 0.01 < abs(float(first[0])) < 2.0  # a fiftieth of 20 N is usual


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("crazyflie circle radus=0.4", "did you mean 'radius'"),
        ("crazyflie circle 0.4", "expected `circle OPTION=0.4`"),
        ("crazyflie circle hover", "expected OPTION=VALUE behind the task, found 'hover'"),
        ("cart_pole regulate slidr=0.3", "unknown column 'slidr'; did you mean 'slider'"),
    ],
)
def test_what_is_no_option_of_a_task_is_refused(arguments: str, said: str, refused: Refused, tmp_path: Path) -> None:
    assert said in refused(f"simulate {arguments} --out {tmp_path / 'log.csv'}")
