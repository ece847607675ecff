"""A disturbance that a controller answers is distinguished from one that depends on what the controller does."""

from __future__ import annotations

import numpy as np
import pytest

from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.leftover import Rest, find_leftovers
from sym2real.trajectory import Array

LOGS, PIECES, PARTS = 8, 150, 5


def first_order(rng: np.random.Generator, memory: float) -> Array:
    """A stationary series of unit variance ``# (PIECES,)``."""
    noise = rng.standard_normal(PIECES)
    found = np.empty(PIECES)
    found[0] = noise[0]
    for row in range(1, PIECES):
        found[row] = memory * found[row - 1] + np.sqrt(1 - memory**2) * noise[row]
    return found


def answers(disturbances: Array, gain: float, lag: float) -> Array:
    """Mean command of every piece, of a lagging loop that works against the rate of disturbances ``# (PIECES,)``."""
    rate, command, means = 0.0, 0.0, []
    for disturbance in disturbances:
        sent = []
        for _ in range(PARTS):
            command += (-gain * rate - command) / (lag * PARTS)
            rate += (disturbance + command) / PARTS
            sent.append(command)
        means.append(np.mean(sent))
    return np.array(means)


def rest_of(disturbances: Array, commands: Array) -> Rest:
    """Of logs ``# (LOGS, PIECES)`` each, with noise in what was estimated of the disturbance."""
    rng = np.random.default_rng(7)
    noisy = disturbances + rng.standard_normal(disturbances.shape)
    other = rng.standard_normal(commands.shape)
    moved = [np.roll(np.stack([commands, other], axis=-1), -away, axis=1).reshape(-1, 2) for away in (-1, 0, 1)]
    groups = np.repeat(np.arange(LOGS), PIECES)
    around = moved[0], moved[2]
    return Rest(("tz",), ("N m",), (1.0,), noisy.reshape(-1, 1), (0.5,), ["wz_cmd", "x"], moved[1], around, groups)


@pytest.mark.parametrize(
    ("memory", "gain", "lag"), [(0.5, 2.0, 0.3), (0.5, 2.0, 1.0), (0.7, 1.0, 1.0), (0.7, 2.0, 0.3)]
)
def test_a_disturbance_that_a_controller_answers_depends_on_nothing(memory: float, gain: float, lag: float) -> None:
    rng = np.random.default_rng(1)
    disturbances = np.stack([first_order(rng, memory) for _ in range(LOGS)])
    rest = rest_of(disturbances, np.stack([answers(own, gain, lag) for own in disturbances]))
    assert rest.explained("tz")[0] > SETTINGS.worth_saying  # the command follows the disturbance all the same
    assert find_leftovers(rest) == ()


@pytest.mark.parametrize("memory", [0.0, 0.7, 0.95])
def test_a_disturbance_that_depends_on_a_command_is_left(memory: float) -> None:
    rng = np.random.default_rng(2)
    commands = np.stack([first_order(rng, memory) for _ in range(LOGS)])
    (found,) = find_leftovers(rest_of(-0.8 * commands, commands))
    assert found.explained_by == "wz_cmd"
    assert found.r2 > SETTINGS.worth_saying
