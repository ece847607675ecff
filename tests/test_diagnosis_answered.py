"""A disturbance that a controller answers is distinguished from one that depends on what the controller does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from carriage import Regulator, carriage
from mujoco import MjData

from sym2real.dataset import Dataset
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.whitening import Spread, estimate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.unexplained.dependence import Terms, find_dependences
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Change
from sym2real.robots import Robot
from sym2real.trajectory import Array, Trajectory

LOGS, ROWS, MEMORY = 8, 500, 0.98  # of a push from millisecond to millisecond: 0.05 s


class Lagging(Regulator):
    """A regulator whose force follows late, and trembles."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng, self.force = rng, 0.0

    def reset(self) -> None:
        """It forgets its force."""
        self.force = 0.0

    def act(self, state: Array, step: int, inputs: Array | None = None) -> Array:
        wanted = -6.0 * state[0] - 4.0 * state[1] + self.rng.normal()
        self.force += 0.15 * (wanted - self.force)
        return np.array([self.force])


def driven(robot: Robot, number: int, depends: float) -> Trajectory:
    """A push of its own, and one that goes with the command."""
    rng, push = np.random.default_rng(number), np.zeros(1)

    def force(_: object, data: MjData) -> None:
        push[0] = MEMORY * push[0] + 1.5 * np.sqrt(1.0 - MEMORY**2) * rng.standard_normal()
        data.qfrc_applied[0] = push[0] + depends * data.ctrl[0]

    log = run_episode(MujocoPlant(robot, [Change("", force=force)]), Lagging(rng), start=np.zeros(2), steps=ROWS)
    noise = rng.normal(size=log.state.shape) * np.array([1e-3, 1e-2])
    return replace(log, state=log.state + noise, name=f"log{number}")


def left_in(robot: Robot, depends: float) -> Terms:
    library = Library.of(robot.nominal(), [])
    problem = Problem(library, Dataset(driven(robot, number, depends) for number in range(LOGS)))
    spread, segments = Spread.of(problem, library.null), problem.segments
    whitening = estimate(spread, problem.residuals(library.null[None])[0], segments.noise, segments.channel)
    return Terms.of(Selection(Problems(problem, whitening), [], library.null), spread, None)


@pytest.mark.parametrize("depends", [0.0, -0.8])
def test_what_a_controller_answers_is_no_dependence_on_its_command(depends: float, tmp_path: Path) -> None:
    terms = left_in(carriage(tmp_path, damping=0.5, most=9.0), depends)
    assert len(terms.promising()) > 1  # a command follows the push all the same
    first = [left.explained_by for left in find_dependences(terms)][:1]
    assert first == (["drive"] if depends else [])
