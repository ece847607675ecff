"""What is there in a part of the logs is not taken for another effect everywhere; what is everywhere, for no part."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from mujoco import MjData, MjModel
from standard_set import standard_run
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis.conclusion import Parts, of_another_form
from sym2real.diagnosis.estimate.fit import Hypothesis
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.score.finding import Finding
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.diagnosis.unexplained.part_of_logs import find_part
from sym2real.effects import effect
from sym2real.experiments.excitation import unlimited
from sym2real.experiments.standard_conditions import sensors
from sym2real.plants import MujocoPlant
from sym2real.protocols import Change
from sym2real.report.leftover import measure, statement
from sym2real.report.summary import summary
from sym2real.robots import ROBOTS

ROBOT = ROBOTS["crazyflie"]
LOAD = 0.1 * ROBOT.mass
LATER = 4.5  # s, of flights of 6 s: a battery that empties does nearly as much
Carries = Callable[[int, float], bool]


def picked_up(_: int, time: float) -> bool:
    return time >= LATER


def in_two(index: int, _: float) -> bool:
    return index >= 4


def always(_: int, __: float) -> bool:
    return True


@cache
def flights(carries: Carries) -> Dataset:
    """Of a Crazyflie in MuJoCo whose body weighs more while it carries a load."""

    def flight(index: int) -> MujocoPlant:
        def load(model: MjModel, data: MjData) -> None:
            model.body_mass[1] = ROBOT.mass + LOAD * carries(index, data.time)

        return MujocoPlant(unlimited(ROBOT), (sensors(ROBOT, np.random.default_rng(index)), Change("", force=load)))

    return Dataset(standard_run(ROBOT, lambda _, i=index: flight(i), 3, index, rows=300) for index in range(6))


def left_of(found: str, carries: Carries) -> tuple[Leftover, ...]:
    """What is said of an effect that was found in such flights, beside a load that might have been."""
    data, equations = flights(carries), ROBOT.nominal()
    library = Library.of(equations, [effect(name, equations) for name in dict.fromkeys(("added_mass", found))])
    problems, tried = weighed_problems(library, data), candidates(library, data)
    chosen = next(candidate for candidate in tried if candidate.name == found)
    selection = Selection(problems, tried, library.null)
    selection.put([chosen], problems.fit([Hypothesis(chosen.free, library.null)])[0])
    return find_part(selection)


def test_a_load_that_is_picked_up_is_no_battery_that_empties() -> None:
    (left,) = left_of("battery_sag", picked_up)
    assert (left.instead, left.channel) == ("added_mass", "battery_sag")
    words, moment, unit = left.explained_by.rsplit(" ", 2)
    assert (words, unit) == ("after about", "s")
    assert float(moment) == pytest.approx(LATER, abs=0.6)
    value, kg = left.term.removeprefix("value ").split()[:2]
    assert (float(value), kg) == (pytest.approx(LOAD, rel=0.1), "kg")
    assert left.matters
    assert not left.unseen


def test_a_load_in_two_of_the_logs_is_no_other_thrust_curve() -> None:
    (left,) = left_of("thrust_curve", in_two)
    names = [log.name for log in flights(in_two)]
    assert left.instead == "added_mass"
    assert left.explained_by == f"in {', '.join(names[4:])} alone"


@pytest.mark.parametrize("carries", [always, in_two])
def test_what_was_found_right_has_no_better_part(carries: Carries) -> None:
    """A load in two logs is a load that differs from log to log, which its interval shows."""
    assert left_of("added_mass", carries) == ()


def test_what_has_something_better_in_its_place_is_no_answer_alone() -> None:
    left = Leftover("after about 4.5 s", "battery_sag", 0.13, "value 0.15 kg there", motion=0.2, instead="added_mass")
    assert statement(left) == "what added_mass after about 4.5 s explains better than battery_sag"
    assert measure(left) == "13 % of the squares"
    sag, drag = (Finding(key, {}, 0.5) for key in ("battery_sag", "linear_drag"))
    assert of_another_form(sag, [left])
    assert not of_another_form(drag, [left])
    assert "battery_sag" in summary("UNEXPLAINED", Parts(findings=(sag,), leftovers=(left,)))
