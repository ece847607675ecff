"""A healthy robot: nothing is found, nothing is left over, and nothing goes wrong on the way to saying so."""

from __future__ import annotations

import numpy as np
import pytest
from standard_set import Case, simulate_case

from sym2real.control import geometric_controller
from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.experiments import standard_conditions
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.tasks import make_task
from sym2real.trajectory import Trajectory


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR], ids=lambda robot: robot.name)
def test_of_a_healthy_robot_nothing_is_missing(robot: Robot) -> None:
    """A car has no parameter that is free beside the findings: without any of them there is no unknown at all."""
    found = diagnose(robot.nominal(), simulate_case(Case(robot.name, seed=3), 4, 200), MujocoPlant(robot))
    assert found.verdict == "NOTHING_MISSING"
    assert found.findings == found.leftovers == found.faults == ()


def drive(task: str, seed: int) -> Trajectory:
    """A healthy car with noisy sensors on a task, as ``sym2real simulate mushr TASK --noise`` writes it."""
    rng, chosen = np.random.default_rng(seed), make_task(task, MUSHR)
    plant = MujocoPlant(MUSHR, (standard_conditions.sensors(MUSHR, rng),))
    controller = geometric_controller(MUSHR, chosen.reference)
    return run_episode(
        plant, controller, chosen, seed=seed, steps=round(chosen.duration / MUSHR.dt), name=f"{task} {seed}"
    )


@pytest.mark.slow
@pytest.mark.parametrize("tasks", [("lemniscate", "lemniscate"), ("circle", "lemniscate")])
def test_the_base_is_asked_about_the_whole_manoeuvre(tasks: tuple[str, ...]) -> None:
    """Half a figure of eight turns one way; of that half the base's own errors look like an arm to one side."""
    logs = Dataset([drive(task, seed) for seed, task in enumerate(tasks, 10)])
    found = diagnose(MUSHR.nominal(), logs, MujocoPlant(MUSHR))
    assert found.verdict == "NOTHING_MISSING", found.summary
