"""Learners by name, and a simulated robot whose sensors are noisy."""

from dataclasses import replace

import numpy as np
import pytest

from sym2real.control import RandomCommands, geometric_controller
from sym2real.dataset import Dataset
from sym2real.effects import effect
from sym2real.errors import UnknownNameError
from sym2real.experiments.learners import LEARNERS, Remembering, make_learner
from sym2real.experiments.noisy_runs import NoisyPlant
from sym2real.neural import Descent, ResidualTraining
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.tasks import make_task
from sym2real.trajectory import Trajectory

QUICK = Remembering(ResidualTraining(widths=(16,), steps=2, penalties=(1e-3,), descent=Descent(steps=50)))


def late_drive(delay: float) -> Dataset:
    task = make_task("circle", MUSHR)
    plant = MujocoPlant(MUSHR, [effect("delay", MUSHR).inject(value=delay)])
    return Dataset([run_episode(plant, RandomCommands(MUSHR, seed=1), task, steps=300)])


def test_a_network_sees_as_far_back_as_the_delay() -> None:
    data = late_drive(0.2)
    late, report = QUICK.fit_reported(data.transitions(), MUSHR.nominal())
    assert late.past_rows[0] >= 4
    assert late.past_rows[1] == 0
    assert report.penalty == 1e-3
    # A start of the same memory is gone on from, one of another is left aside.
    again = QUICK.fit(data.transitions(), MUSHR.nominal(), late)
    assert again.past_rows == late.past_rows
    short = replace(QUICK.training, commands=1).fit(data.transitions(), MUSHR.nominal())
    assert QUICK.fit(data.transitions(), MUSHR.nominal(), short).past_rows == late.past_rows
    few = Dataset([data[0].rows(0, 60)])
    assert QUICK.fit(few.transitions(), MUSHR.nominal()).past_rows == (0, 0)


def test_learners_are_made_by_name() -> None:
    for name in LEARNERS:
        assert make_learner(name, 3, memory=0) == LEARNERS[name](3, ())
    remembering = make_learner("residual", 3, memory="auto")
    assert isinstance(remembering, Remembering)
    assert remembering.training.seed == 3
    assert make_learner("residual", 3, memory=4) == ResidualTraining(seed=3, commands=4)
    assert make_learner("none", 0, memory="auto") == LEARNERS["none"](0, ())
    with pytest.raises(UnknownNameError, match="did you mean 'residual'"):
        make_learner("residul", 0, memory="auto")


def test_noise_belongs_to_the_episodes_seed() -> None:
    task = make_task("circle", CRAZYFLIE)
    plant = NoisyPlant(MujocoPlant(CRAZYFLIE))

    def flown(seed: int) -> Trajectory:
        controller = geometric_controller(CRAZYFLIE, task.reference)
        return run_episode(plant, controller, task, seed=seed, steps=60)

    first, other, again = flown(1), flown(2), flown(1)
    np.testing.assert_array_equal(first.state, again.state)
    difference = (first.state - other.state)[:10, :3]
    assert 0.1e-3 < difference.std() < 2e-3  # two draws of 0.5 mm
    assert not plant.crashed
    assert plant.sent == pytest.approx(again.action[-1])
