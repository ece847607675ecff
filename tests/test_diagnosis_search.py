"""What a search does where greedy additions go wrong: rare effects, and effects that hide each other."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
import torch
from standard_set import Case, simulate_case
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis.estimate.fit import Hypothesis, Problems
from sym2real.diagnosis.pipeline import prepare
from sym2real.diagnosis.predict.candidate import Candidate, candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.question import Question
from sym2real.diagnosis.search import beam
from sym2real.diagnosis.search.beam import Beam
from sym2real.diagnosis.search.intervals import none_within
from sym2real.diagnosis.search.near import Near
from sym2real.diagnosis.search.pairs import hidden_pairs
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.search.settled import refuted
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import effect
from sym2real.least_squares import solve
from sym2real.plants import MujocoPlant
from sym2real.robots import MUSHR
from sym2real.stages import Stages


@pytest.mark.parametrize("size", [1, 2])
def test_parameters_that_change_nothing_stay_put(size: int) -> None:
    """A dead band where no command is: its predicted loss was no number, and hid that of its other starts."""
    still = solve(torch.zeros(3, size, size, dtype=torch.float64), torch.zeros(3, size, dtype=torch.float64))
    assert still.tolist() == [[0.0] * size] * 3


@pytest.mark.slow
@pytest.mark.parametrize("arm", [0.08, 0.09])
def test_an_arm_and_slipping_tyres_that_hide_each_other_are_found_together(arm: float) -> None:
    """The longer arm alone saves something, but not beyond chance. Tyres that slip in turns brake the simulated car."""
    hidden = (("lever_arm", {"rx": arm, "ry": 0.0}), ("tyre_slip", {"value": 0.03}))
    selection = selection_of(Case("mushr", hidden, seed=5))
    Beam(selection).search()
    found = [float(selection.fit.values[one.slots[0]] - selection.origin[one.slots[0]]) for one in selection.chosen]
    by_name = dict(zip((one.name for one in selection.chosen), found, strict=True))
    assert 0.0 <= by_name.pop("quadratic_drag", 0.0) < 0.3
    assert by_name == pytest.approx({"lever_arm": arm, "tyre_slip": 0.03}, rel=0.15)


@cache
def arm_and_tyres() -> tuple[Problems, tuple[Candidate, ...]]:
    """Drives whose place is ahead of the axle by as much as soft tyres slide inwards, and what competes."""
    hidden = (("lever_arm", {"rx": 0.07, "ry": 0.0}), ("tyre_slip", {"value": 0.03}))
    base, data = MUSHR.nominal(), simulate_case(Case("mushr", hidden, seed=5), 4, 160)
    library = Library.of(base, [effect(key, base) for key, _ in hidden])
    return weighed_problems(library, data), candidates(library, data)


@pytest.mark.parametrize("beside", [0, 1])
def test_of_two_effects_that_hide_each_other_neither_saves_anything_and_both_together_are_the_answer(
    beside: int,
) -> None:
    """Under two names the arm is in two pairs that save the same, and none with itself; nor does a threshold pair."""
    problems, (arm, slip) = arm_and_tyres()
    twin, late = replace(arm, name="twin"), replace(slip, name="late", needs_start=True)
    selection = Selection(problems, (arm, slip, twin, late)[: 4 * beside or 2], problems.library.null)
    nothing = selection.present
    assert all(alone.price > nothing.price for alone in selection.ranked(nothing, [arm, slip]))
    pairs = hidden_pairs(selection, nothing)
    assert {pair.names for pair in pairs} == {frozenset({name, slip.name}) for name in (arm.name, "twin")[: 1 + beside]}
    assert all(pair.loss < 0.2 * nothing.loss for pair in pairs)
    if not beside:
        Beam(selection).search()
        found = {one.name: float(selection.fit.values[one.slots[0]]) for one in selection.chosen}
        assert found == pytest.approx({"lever_arm": 0.07, "tyre_slip": 0.03}, rel=0.1)
        assert hidden_pairs(selection, selection.present) == []


@pytest.mark.parametrize(("tested", "most"), [(10**300, 8), (2, 1)], ids=["within chance", "too many"])
def test_a_pair_is_not_kept_within_chance_or_beyond_the_largest_set(
    tested: int, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    problems, tried = arm_and_tyres()
    selection = Selection(problems, tried, problems.library.null)
    selection.tested = tested
    monkeypatch.setattr(beam, "SETTINGS", replace(SETTINGS, most_findings=most))
    Beam(selection).search()
    assert selection.chosen == []


@pytest.mark.slow
def test_in_a_healthy_car_no_effect_and_no_pair_is_found() -> None:
    selection = selection_of(Case("mushr", seed=5))
    Beam(selection).search()
    assert selection.chosen == []


@pytest.mark.slow
def test_a_delay_that_stays_where_its_fit_began_is_found_from_its_other_starts() -> None:
    selection = selection_of(Case("mushr", (("delay", {"value": 0.16}),), seed=5))
    (delay,) = (one for one in selection.candidates if one.name == "delay")
    far = selection.origin.clone()
    far[delay.slots] = 0.45
    stuck = selection.problems.fit([Hypothesis(selection.free([delay]), far)])[0]
    selection.put([delay], stuck)
    assert float(stuck.values[delay.slots[0]]) > 0.3
    Beam(selection).search()
    assert [one.name for one in selection.chosen] == ["delay"]
    assert float(selection.fit.values[delay.slots[0]]) == pytest.approx(0.16, rel=0.05)
    assert selection.fit.total < 0.5 * stuck.total


@pytest.mark.slow
def test_a_lag_of_no_time_is_none_whatever_of_it_a_gyro_would_show() -> None:
    """What a lag leaves of the gyro is nothing without the lag, however far from none it lies."""
    selection = selection_of(Case("mushr", (("offset:steer", {"value": 0.05}),), seed=5))
    (lag,) = (one for one in selection.candidates if one.name == "lag:steer")
    slots = selection.problems.library.slots
    values = selection.origin.clone()
    for slot in lag.slots:
        values[slot] = {"value": 1e-4, "mean_share": 0.9}[slots[slot].parameter.name]
    (fit,) = selection.problems.quadratics([Hypothesis(selection.free([lag]), values)])
    selection.put([lag], fit)
    assert none_within(Near.of(selection), lag)


@pytest.mark.slow
def test_a_share_may_be_nothing_or_all_and_a_time_at_the_end_of_what_is_likely_is_no_time() -> None:
    selection = selection_of(Case("mushr", (("lag:steer", {"value": 0.1}),), seed=5))
    (lag,) = (one for one in selection.candidates if one.name == "lag:steer")
    selection.put(
        [lag], selection.problems.fit([Hypothesis(selection.free([lag]), lag.started(selection.origin, 0.1))])[0]
    )
    library = selection.problems.library
    assert {library.slots[slot].parameter.acts_alone for slot in lag.slots} == {True, False}
    for slot in lag.slots:
        values = selection.fit.values.clone()
        values[slot] = library.bounds[1][slot]
        ends = selection.at_bound(replace(selection.fit, values=values), lag)
        assert ends is library.slots[slot].parameter.acts_alone


@pytest.mark.slow
def test_what_is_none_within_its_interval_does_not_stand_beside_what_is_there() -> None:
    selection = selection_of(Case("mushr", (("offset:steer", {"value": 0.05}),), seed=5))
    offset, gain = (one for name in ("offset:steer", "gain:speed") for one in selection.candidates if one.name == name)
    hypothesis = Hypothesis(selection.free([offset, gain]), selection.origin)
    selection.put([offset, gain], selection.problems.fit([hypothesis])[0])
    near = Near.of(selection)
    assert none_within(near, gain)
    assert not none_within(near, offset)
    found = refuted(near)
    assert found is not None
    assert found.candidate is gain
    alone = selection.without(selection.present, gain)
    selection.put(alone.chosen, alone.fit)
    assert refuted(Near.of(selection)) is None


@pytest.mark.slow
def test_nothing_that_comes_before_the_search_depends_on_the_order_of_the_logs() -> None:
    """The base is a lag behind its simulator, which a delay explains as well: the choice was left to rounding."""
    slow = MujocoPlant(MUSHR, [effect("lag:speed", MUSHR).inject(value=0.01)])
    logs = simulate_case(Case("mushr", (), 1), 5, 340)
    answers = []
    for order in ((0, 1, 2, 3, 4), (1, 3, 2, 4, 0)):
        question = Question(MUSHR.nominal(), Dataset(logs[place] for place in order), slow)
        answers.append(prepare(question, Stages(lambda _: None)))
    first, other = answers
    assert not torch.equal(first.origin, first.searched.null)
    assert other.origin.tolist() == pytest.approx(first.origin.tolist(), rel=1e-4, abs=1e-9)
    assert other.whitening.sensor.tolist() == pytest.approx(first.whitening.sensor.tolist(), rel=1e-4)
    assert other.whitening.disturbances == pytest.approx(first.whitening.disturbances, rel=1e-4)


def selection_of(case: Case) -> Selection:
    question = Question(MUSHR.nominal(), simulate_case(case, 4, 240), MujocoPlant(MUSHR))
    prepared = prepare(question, Stages(lambda _: None))
    return Selection(prepared.problems, prepared.candidates, prepared.origin)
