"""How many past commands a residual needs: against delays that MuJoCo makes, and where there is nothing to remember."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from sym2real.control import MPPI
from sym2real.dataset import Dataset, Transitions
from sym2real.effects import compose, effect
from sym2real.errors import ModelError
from sym2real.experiments.standard_conditions import sensors
from sym2real.neural.memory_order import memory_length
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import compile_model
from sym2real.tasks import make_task

both_robots = pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR], ids=lambda robot: robot.name)
Effects = tuple[tuple[str, tuple[tuple[str, float], ...]], ...]


@lru_cache(maxsize=8)
def flown(robot: Robot, effects: Effects, noisy: bool = False) -> Transitions:
    """An episode under MPPI that knows nothing of the effects."""
    changes = [effect(key, robot).inject(**dict(values)) for key, values in effects]
    changes += [sensors(robot, np.random.default_rng(1))] if noisy else []
    task = make_task("circle", robot)
    few = replace(robot.mppi, samples=256)
    controller = MPPI(compile_model(robot.nominal()), robot, task, settings=few)
    return Dataset([run_episode(MujocoPlant(robot, changes), controller, task, steps=300)]).transitions()


def late(seconds: float) -> Effects:
    return (("delay", (("value", seconds),)),)


@both_robots
@pytest.mark.parametrize("noisy", [False, True], ids=["clean", "noisy"])
@pytest.mark.parametrize("periods", [2.0, 4.0])
def test_a_delay_of_whole_periods_asks_for_as_many_commands(robot: Robot, noisy: bool, periods: float) -> None:
    found = memory_length(flown(robot, late(periods * robot.dt), noisy), robot.nominal())
    assert periods <= found <= periods + noisy  # velocities by differences are late themselves


def test_200_ms_at_20_hz_are_four_commands() -> None:
    assert MUSHR.dt == 0.05
    assert memory_length(flown(MUSHR, late(0.2)), MUSHR.nominal()) >= 4


@both_robots
def test_a_part_of_a_period_asks_for_one_more(robot: Robot) -> None:
    found = memory_length(flown(robot, late(3.5 * robot.dt)), robot.nominal())
    assert found == 4


@both_robots
def test_a_lag_asks_for_what_has_not_faded(robot: Robot) -> None:
    """Of a lag of two periods, a command still acts by e^-1 two periods later, and by e^-4 eight periods later."""
    found = memory_length(flown(robot, (("lag", (("value", 2 * robot.dt),)),)), robot.nominal())
    assert 2 <= found <= 8


NOTHING: Sequence[tuple[Robot, Effects]] = [
    (CRAZYFLIE, ()),
    (CRAZYFLIE, (("added_mass", (("value", 0.005),)),)),
    (CRAZYFLIE, (("wind", (("fx", 0.02), ("fy", 0.01))),)),
    (CRAZYFLIE, (("com_offset", (("rx", 0.003),)),)),
    (MUSHR, ()),
    (MUSHR, (("wind", (("fx", 2.0), ("fy", 1.0))),)),
]


@pytest.mark.parametrize(("robot", "effects"), NOTHING, ids=lambda value: getattr(value, "name", str(value)))
@pytest.mark.parametrize("noisy", [False, True], ids=["clean", "noisy"])
def test_without_a_delay_there_is_nothing_to_remember(robot: Robot, effects: Effects, noisy: bool) -> None:
    assert memory_length(flown(robot, effects, noisy), robot.nominal()) == 0


@both_robots
def test_a_base_that_delays_needs_no_memory_of_it(robot: Robot) -> None:
    base = compose(robot.nominal(), [(effect("delay", robot.nominal()), {"value": 3 * robot.dt})])
    found = memory_length(flown(robot, late(3 * robot.dt)), base)
    assert found == 0


def test_too_few_rows_are_refused() -> None:
    whole = flown(MUSHR, ())
    with pytest.raises(ModelError, match="at least 100 transitions, found 50"):
        memory_length(whole.where(whole.step < 50), MUSHR.nominal())
