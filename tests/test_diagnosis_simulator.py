"""Which of the logs' manoeuvres the plain simulator flies, how long, and where they then lead."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from carriage import Regulator, carriage
from noisy_flights import flights_with
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis.estimate.simulator import NO_SIMULATOR, NOT_FLOWN, flown_along, with_effects_of
from sym2real.effects import effect
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS


@pytest.mark.parametrize(("times", "slower"), [(0.5, 1.0), (1.01, 1.0), (3.0, 3.0)])
def test_a_robot_is_commanded_no_faster_than_its_own_period_and_no_faster_than_its_logs(
    times: float, slower: float
) -> None:
    plant, why = with_effects_of(MUSHR.nominal(), MujocoPlant(MUSHR), times * MUSHR.dt)
    assert plant is not None
    assert plant.dt == pytest.approx(slower * MUSHR.dt)
    assert why == ""
    assert with_effects_of(MUSHR.nominal(), None, MUSHR.dt) == (None, NO_SIMULATOR)


def test_what_a_simulator_has_already_it_keeps() -> None:
    changes = (effect("lag:speed", MUSHR).inject(value=0.2),)
    plant, _ = with_effects_of(MUSHR.nominal(), MujocoPlant(MUSHR, changes), MUSHR.dt)
    assert plant is not None
    assert plant.changes == changes


def test_no_more_than_eight_logs_are_flown_and_of_each_the_first_eight_seconds() -> None:
    """A car's 400 rows are longer; where it is then is known by a tenth of how far it moves, in squares."""
    logs = simulate_case(Case("mushr", (), seed=2), 9, 120)
    long = simulate_case(Case("mushr", (), seed=2), 1, 420)
    flown, why = flown_along(MUSHR.nominal(), MujocoPlant(MUSHR), Dataset([*long, *logs]))
    assert flown is not None
    assert why == ""
    assert [len(own) for own in flown] == [400, *[120] * 7]
    for own, log in zip(flown, [*long, *logs], strict=False):
        assert own.name == log.name
        flight, drive = (np.stack([part.column(axis)[: len(own)] for axis in "xy"]) for part in (own, log))
        assert np.square(flight - drive).sum() < 0.1 * np.square(drive - drive.mean(1, keepdims=True)).sum()
    fast = replace(long[0], time=0.0195 * np.arange(420))
    quick, _ = flown_along(MUSHR.nominal(), MujocoPlant(MUSHR), Dataset([fast]))
    assert quick is not None
    assert len(quick[0]) == 410


@pytest.mark.parametrize(("rows", "flies"), [(99, False), (100, True)])
def test_a_flight_of_less_than_a_hundred_rows_calibrates_nothing(rows: int, *, flies: bool) -> None:
    (log,) = flights_with("", {}, count=1)
    flown, why = flown_along(CRAZYFLIE.nominal(), MujocoPlant(CRAZYFLIE), Dataset([log.rows(0, rows)]))
    assert (flown is not None, why) == (flies, "" if flies else NOT_FLOWN)
    assert flown is None or [own.name for own in flown] == [log.name]


class Sent(Regulator):
    """Commands one after the other, whatever happens."""

    def __init__(self, commands: np.ndarray) -> None:
        self.commands = commands

    def act(self, state: np.ndarray, step: int, inputs: np.ndarray | None = None) -> np.ndarray:
        return self.commands[step]


def test_what_was_driven_in_reverse_is_driven_in_reverse() -> None:
    """Along the path of a robot that reverses a controller may drive forwards, as near in its places."""
    robot, rng = ROBOTS["differential_drive"], np.random.default_rng(0)
    wheels = np.repeat(rng.uniform(-0.5, 0.5, (10, 2)) * np.array(robot.high), 20, axis=0)
    log = run_episode(MujocoPlant(robot), Sent(wheels), steps=len(wheels))
    flown, _ = flown_along(robot.nominal(), MujocoPlant(robot), Dataset([log]))
    assert flown is not None
    np.testing.assert_allclose(flown[0].state, log.state[: len(flown[0])], atol=1e-6)


@pytest.mark.parametrize(("place", "tremble"), [(1.0, 0.3), (0.02, 0.0)], ids=["far", "near, and still"])
def test_where_a_regulator_does_something_else_what_was_sent_is_sent_again(
    place: float, tremble: float, tmp_path: Path
) -> None:
    """A carriage on a spring of 2 N/m is held where it does not rest, by a force that trembles or does not."""
    robot, rng = carriage(tmp_path, damping=1.0, most=5.0, stiffness=2.0), np.random.default_rng(0)
    pushes = 2.0 * place + tremble * np.repeat(rng.uniform(-1.0, 1.0, (8, 1)), 20, axis=0)
    log = run_episode(MujocoPlant(robot), Sent(pushes), start=np.array([place, 0.0]), steps=len(pushes))
    flown, _ = flown_along(robot.nominal(), MujocoPlant(robot), Dataset([log]))
    assert flown is not None
    np.testing.assert_allclose(flown[0].column("rail"), log.column("rail"), atol=1e-3)
