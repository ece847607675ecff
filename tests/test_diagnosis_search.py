"""What a search does where greedy additions go wrong: rare effects, and effects that hide each other."""

from __future__ import annotations

import pytest
import torch
from noisy_flights import flights_with

from sym2real.diagnosis.estimate.fit import REFIT_STEPS, Hypothesis, Problems, solve
from sym2real.diagnosis.estimate.significance import chance_of_gain, large_in_every_log
from sym2real.diagnosis.estimate.whitening import Spread
from sym2real.diagnosis.faults.checking import Question
from sym2real.diagnosis.pipeline import prepare
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.beam import Beam
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.stages import Stages
from sym2real.experiments.standard_set import Case, simulate_case
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR


def problems_of(logs: int) -> Problems:
    """Healthy flights."""
    library = Library.of(CRAZYFLIE.nominal(), [])
    problem = Problem(library, flights_with("", {}, count=logs, steps=400))
    spread = Spread.of(problem, library.null)
    variances = torch.as_tensor(problem.segments.noise).square(), torch.ones(len(spread.names), dtype=torch.float64)
    return Problems.of(problem, spread.whitening(*variances))


@pytest.mark.parametrize(
    ("logs", "gaining", "enough"), [(3, 3, True), (3, 2, False), (2, 2, False)], ids=["all", "not one", "few logs"]
)
def test_what_acts_for_a_second_shows_in_every_log(logs: int, gaining: int, enough: bool) -> None:
    """One segment of a log falls far; in the others a little is lost, as other parameters move."""
    problems = problems_of(logs)
    before = torch.full((len(problems.logs),), 40.0, dtype=torch.float64)
    after = before + 0.5
    for log in range(gaining):
        first = int((torch.as_tensor(problems.logs) == log).nonzero()[0])
        before[first], after[first] = 400.0, 40.0
    assert large_in_every_log(problems, before, after) is enough
    assert chance_of_gain(problems, before, after) > 0.01  # which ranks of blocks cannot see


@pytest.mark.parametrize("size", [1, 2])
def test_parameters_that_change_nothing_stay_put(size: int) -> None:
    """A dead band where no command is: its predicted loss was no number, and hid that of its other starts."""
    still = solve(torch.zeros(3, size, size, dtype=torch.float64), torch.zeros(3, size, dtype=torch.float64))
    assert still.tolist() == [[0.0] * size] * 3


@pytest.mark.parametrize("arm", [0.08, 0.09])
def test_an_arm_and_slipping_tyres_that_hide_each_other_are_found_together(arm: float) -> None:
    """The longer arm alone saves something, but not beyond chance."""
    hidden = (("lever_arm", {"rx": arm, "ry": 0.0}), ("tyre_slip", {"value": 0.03}))
    selection = selection_of(Case("mushr", hidden, seed=5))
    Beam(selection).search()
    assert {one.name for one in selection.chosen} == {"lever_arm", "tyre_slip"}
    found = [float(selection.fit.values[one.slots[0]] - selection.origin[one.slots[0]]) for one in selection.chosen]
    by_name = dict(zip((one.name for one in selection.chosen), found, strict=True))
    assert by_name == pytest.approx({"lever_arm": arm, "tyre_slip": 0.03}, rel=0.15)


def test_in_a_healthy_car_no_effect_and_no_pair_is_found() -> None:
    selection = selection_of(Case("mushr", seed=5))
    Beam(selection).search()
    assert selection.chosen == []


def test_a_delay_that_stays_where_its_fit_began_is_found_from_its_other_starts() -> None:
    selection = selection_of(Case("mushr", (("delay", {"value": 0.16}),), seed=5))
    (delay,) = (one for one in selection.candidates if one.name == "delay")
    far = selection.origin.clone()
    far[delay.slots] = 0.45
    stuck = selection.problems.fit([Hypothesis(selection.free([delay]), far)], REFIT_STEPS)[0]
    selection.put([delay], stuck)
    assert float(stuck.values[delay.slots[0]]) > 0.4
    Beam(selection).search()
    assert [one.name for one in selection.chosen] == ["delay"]
    assert float(selection.fit.values[delay.slots[0]]) == pytest.approx(0.16, rel=0.05)
    assert selection.fit.total < 0.5 * stuck.total


def selection_of(case: Case) -> Selection:
    question = Question(MUSHR.nominal(), simulate_case(case, 4, 240), MujocoPlant(MUSHR))
    prepared = prepare(question, Stages(lambda _: None))
    return Selection(prepared.problems, prepared.tried, prepared.origin)
