"""Weights of effects against none and others in their place, and which of them predictions need."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch
from noisy_flights import flights_with, flights_with_all
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis.estimate.fit import Hypothesis, Problems, nuisance_of
from sym2real.diagnosis.estimate.whitening import Spread
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.intervals import estimates, none_within
from sym2real.diagnosis.search.near import Near, Place, _nearly, as_good, groups_of, left_its_part
from sym2real.diagnosis.search.needed import Predicted, keep_needed
from sym2real.diagnosis.search.select import EffectSet, Selection
from sym2real.diagnosis.search.settled import join_narrow, plainer_set, refuted, settle
from sym2real.effects import effect
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.tasks import make_task

WIND = {"fx": 0.02, "fy": -0.01}
DRAG = {"cx": 0.01, "cy": 0.01, "cz": 0.01}


def chosen(keys: tuple[str, ...], *names: str, flights: Dataset | None = None) -> Selection:
    """Some of the effects put into a selection for flights, four in wind by default, whatever they gain."""
    base, data = CRAZYFLIE.nominal(), flights_with("wind", WIND) if flights is None else flights
    library = Library.of(base, [effect(key, base) for key in keys])
    tried = candidates(library, data)
    selection = Selection(weighed_problems(library, data), tried, library.null)
    for name in names:
        (one,) = (other for other in tried if other.name == name)
        (scored,) = selection.ranked(selection.present, [one])
        selection.put([*selection.chosen, one], scored.fit)
    return selection


def plainer(selection: Selection, gone: tuple[str, ...] = ()) -> EffectSet | None:
    """A plainer set than the one that was chosen, one exchange away."""
    near = Near.of(selection)
    return plainer_set(near, [other for place in near.places for other in place.worth_it], gone)


def test_what_an_unknown_start_does_is_no_error_of_a_hypothesis() -> None:
    """Rates that answer by a third forget a start three times as slowly as those of the covariance's base."""
    base, data = CRAZYFLIE.nominal(), flights_with("", {})
    plain = Problem(Library.of(base, [effect("rate_loop_gain", base)]), data)
    layout, slow = plain.segments.layout, torch.full_like(plain.library.null, 0.3)
    moves = torch.zeros(len(plain.segments), layout.tangent_size, dtype=torch.float64)
    moves[:, -3:] = 0.3 * torch.randn(len(moves), 3, generator=torch.Generator().manual_seed(0))  # rad/s
    begun = replace(plain.segments, start=layout.retract(plain.segments.start, moves))
    measured = Problem(plain.library, data, begun).states(slow[None])[0]
    problem = Problem(plain.library, data, replace(plain.segments, measured=measured))
    spread = Spread.of(problem, plain.library.null)
    variances = torch.as_tensor(problem.segments.noise).square(), torch.zeros(len(spread.names), dtype=torch.float64)
    problems = Problems(problem, spread.whitening(*variances), spread=spread)
    (fit,) = problems.quadratics([Hypothesis((), slow)])
    left = problems.by_fold(fit).loss + problems.by_own_starts(fit)
    assert (left < 1e-2 * problems.by_fold(fit).loss).all()
    (at_null,) = problems.quadratics([Hypothesis((), plain.library.null)])
    torch.testing.assert_close(
        problems.by_own_starts(at_null), torch.zeros_like(left), rtol=0, atol=1e-6 * at_null.total
    )


def test_an_effect_that_is_there_outweighs_drag_and_nothing() -> None:
    near = Near.of(chosen(("wind", "linear_drag"), "wind"))
    assert near.probabilities()["wind"] > 0.99
    assert len(near.sets_with(near.places[0].candidate)[0]) == 1  # nothing stands beside it


def test_an_interval_covers_what_one_effect_more_would_make_of_a_value() -> None:
    """A delay that stands for a motor's lag as well is too long, whatever the noise says of it."""
    flights = flights_with_all({"delay": {"value": 0.02}, "motor_lag": {"value": 0.03}})
    selection = chosen(("delay", "motor_lag"), "delay", flights=flights)
    near = Near.of(selection)
    (delay,) = selection.chosen
    assert [larger.candidate.name for larger in near.larger] == ["motor_lag"]
    too_long = float(selection.fit.values[delay.slots]) - 0.02
    assert too_long > 0.01
    wide, narrow = (
        estimates(selection, delay, selection.fit, around)["value"] for around in (near, replace(near, larger=()))
    )
    assert wide.low < 0.02 < narrow.low
    assert wide.high == pytest.approx(narrow.high, rel=1e-6)


def test_a_torque_s_interval_holds_what_it_is_where_inertia_makes_the_loop_soft() -> None:
    """A loop k times as stiff divides torques by k; one that turns 1/k times the inertia gives a torque of 1/k."""
    flights = flights_with_all({"torque_bias": {"ty": 2e-5}, "rate_loop_gain": {"value": 0.7}})
    selection = chosen(("torque_bias", "rate_loop_gain"), "torque_bias", "rate_loop_gain", flights=flights)
    stiff = estimates(selection, selection.chosen[0], selection.fit, None)["ty"]
    selection.problems = replace(selection.problems, nuisance=nuisance_of(selection.problems.library, selection.origin))
    either = estimates(selection, selection.chosen[0], selection.fit, None)["ty"]
    factor = float(selection.fit.values[selection.chosen[1].slots[0]])
    assert factor == pytest.approx(0.7, rel=0.1)
    assert either.value == stiff.value
    assert either.low == pytest.approx(stiff.low)
    assert either.high == pytest.approx(stiff.high / factor)


@pytest.mark.parametrize(("times", "none"), [(3.0, False), (0.001, True)])
def test_another_value_beside_another_effect_is_none_only_where_it_is_none(times: float, none: bool) -> None:
    """Of a mass, a gain of thrust and a scale of torques any two do: each has two values, and none of them is none."""
    near = Near.of(chosen(("wind", "linear_drag"), "wind"))
    (place,), (wind,) = near.places, near.selection.chosen
    values = near.present.fit.values.clone()
    values[wind.slots] *= times
    other = replace(near.present, fit=replace(near.present.fit, values=values))
    beside = Place(replace(wind, name="another"), other, (), outdone=False)
    assert not none_within(near, wind)
    assert none_within(replace(near, places=(place, beside)), wind) == none


def test_a_set_is_its_best_fit_whatever_it_was_fitted_from() -> None:
    """A joint's friction that was left of a friction and an armature was .9 N m instead of .5, and was given up."""
    selection = chosen(("wind", "linear_drag"), "wind")
    best, (wind,) = selection.present, selection.chosen
    (worse,) = selection.problems.quadratics([Hypothesis(selection.free([wind]), selection.origin)])
    assert worse.total > 2 * best.fit.total
    assert selection.set_of([wind], worse).fit is best.fit
    selection.put([wind], worse)
    assert selection.fit is best.fit
    assert selection.known[best.names].fit is best.fit


@pytest.mark.parametrize(("price", "nearly"), [(10.0, True), (30.0, False)])
def test_what_saves_nearly_as_much_is_not_outdone_by_what_is_not_likely(price: float, *, nearly: bool) -> None:
    """Damping beyond all likelihood did a little more than a friction that did 99 %, and left nothing."""
    present = chosen(("wind", "linear_drag"), "wind").present
    here, unlikely, none = (replace(present, price=other) for other in (price, 5.0, 100.0))
    assert _nearly(here, unlikely, none) == nearly


def test_an_effect_that_is_not_there_weighs_little_against_the_one_that_is() -> None:
    assert Near.of(chosen(("wind", "linear_drag"), "linear_drag")).probabilities()["linear_drag"] < 0.01


def test_what_else_is_missing_does_not_stand_in_an_effects_place() -> None:
    """Rates that answer by half leave more behind than a wind does, and neither explains the other."""
    flights = flights_with_all({"wind": {"fx": 0.005}, "rate_loop_gain": {"value": 0.5}})
    selection = chosen(("wind", "rate_loop_gain", "linear_drag"), "wind", flights=flights)
    near = Near.of(selection)
    assert near.probabilities()["wind"] > 0.99
    assert "rate_loop_gain" not in groups_of(near)["wind"]


def test_what_leaves_an_effect_its_part_is_not_in_its_place_however_much_more_it_saves() -> None:
    """Motors that are slow explain much more of an estimator's attitude than the ground's effect does of the height."""
    flights = flights_with_all({"wind": {"fx": 0.003}, "rate_loop_gain": {"value": 0.5}})
    selection = chosen(("wind", "rate_loop_gain", "linear_drag"), "wind", flights=flights)
    (wind,), empty = selection.chosen, selection.without(selection.present, selection.chosen[0])
    others = {larger.candidate.name: larger for larger in selection.larger(empty)}
    assert others["rate_loop_gain"].loss < selection.present.loss
    assert left_its_part(selection, wind, empty, others["rate_loop_gain"])
    windy = chosen(("wind", "linear_drag"), "linear_drag")
    (drag,), empty = windy.chosen, windy.without(windy.present, windy.chosen[0])
    assert not left_its_part(windy, drag, empty, windy.larger(empty)[0])


def test_a_set_in_which_two_effects_are_others_stands_for_both() -> None:
    """As play and a lag do for a gain and a delay: what takes one effect's place alone takes it there."""
    keys = ("wind", "added_mass", "linear_drag", "quadratic_drag")
    flights = flights_with_all({"wind": WIND, "added_mass": {"value": 0.003}})
    near = Near.of(chosen(keys, "wind", "added_mass", flights=flights))
    near = replace(near, places=tuple(replace(place, alternatives=()) for place in near.places))
    others = [other for other in near.selection.candidates if "drag" in other.name]
    twin = replace(near.present, chosen=tuple(others))
    both = replace(near, elsewhere=(twin,))
    assert {key: {*keys[2:]} <= {*group} for key, group in groups_of(both).items()} == dict.fromkeys(keys[:2], True)
    wind, mass = near.places
    alone = replace(mass, alternatives=(replace(mass.empty, chosen=(*mass.empty.chosen, others[0])),))
    known = groups_of(replace(both, places=(wind, alone)))
    assert (others[0].name in known["wind"], others[0].name in known["added_mass"]) == (False, True)
    assert (others[1].name in known["wind"], others[1].name in known["added_mass"]) == (True, False)
    worse = replace(twin, held_out=2 * twin.held_out)
    assert groups_of(replace(near, elsewhere=(worse,))) == groups_of(near)
    # Each has half of the weight, until it counts that the other does the same.
    assert both.probabilities()["wind"] == pytest.approx(0.5, abs=0.01)
    assert both.probabilities(groups_of(both))["wind"] > 0.99


def test_sets_further_away_are_those_that_were_fitted_and_hold_the_cheapest_first() -> None:
    """A load in the wind, and drag: a drag alone leaves so much that it is not beyond chance, a quadratic one is."""
    keys = ("wind", "added_mass", "linear_drag", "quadratic_drag")
    flights = flights_with_all({"wind": WIND, "added_mass": {"value": 0.003}, "linear_drag": DRAG})
    near = Near.of(chosen(keys, "wind", "added_mass", flights=flights))
    assert near.elsewhere == ()
    known = [{"linear_drag", "added_mass"}, {"wind", "quadratic_drag"}, set()]
    assert [own.names for own in near.with_elsewhere().elsewhere] == known
    drags = [own for own in near.selection.candidates if "drag" in own.name]
    for drag in drags:
        near.selection.beside([drag], near.selection.fit)
    assert [own.names for own in near.with_elsewhere().elsewhere] == [*known[:2], {"quadratic_drag"}, set()]


def test_equal_losses_weigh_alike_and_a_lower_one_more() -> None:
    near = Near.of(chosen(("wind",)))
    folds = torch.rand(8, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    assert near.weights(folds, folds).tolist() == pytest.approx([0.5, 0.5])
    left = max(1.0, near.selection.fit.total / near.selection.problems.whitening.freedom)
    worse = folds + 2 * left * math.log(3.0) / 8  # a likelihood three times smaller, whatever folds are drawn
    assert near.weights(folds, worse).tolist() == pytest.approx([0.75, 0.25])


def test_what_no_prediction_needs_is_dropped_and_what_it_needs_stays() -> None:
    selection = chosen(("wind", "linear_drag"), "wind", "linear_drag")
    problem = selection.problems.problem
    predicted = Predicted(selection, problem.library, problem.data)
    (dropped,) = keep_needed(predicted)
    assert dropped.name == "linear_drag"
    assert [one.name for one in selection.chosen] == ["wind"]
    assert not predicted.small()
    wind = selection.fit.values[selection.chosen[0].slots]
    assert wind.tolist() == pytest.approx([WIND["fx"], WIND["fy"]], rel=0.1)


def test_of_two_effects_that_stand_for_each_other_one_at_most_is_small() -> None:
    """Neither drag is missed alone, the other fitted again; both are."""
    flights = flights_with_all({"linear_drag": DRAG, "quadratic_drag": {"value": 0.005}})
    selection = chosen(("linear_drag", "quadratic_drag"), "linear_drag", "quadratic_drag", flights=flights)
    problem = selection.problems.problem
    predicted = Predicted(selection, problem.library, problem.data)
    whole, others = predicted.without_each()
    for left_out in others:
        assert left_out.horizons[0.8]["position"].value < 1.1 * whole.horizons[0.8]["position"].value
    assert len(predicted.small()) == 1


@pytest.mark.slow
def test_what_stays_once_another_has_gone_gives_way_to_what_the_logs_ask_for() -> None:
    """Drag stands for a wind, beside 80 mg that no prediction needs."""
    flights = flights_with_all({"wind": WIND, "added_mass": {"value": 8e-5}})
    selection = chosen(("wind", "linear_drag", "added_mass"), "linear_drag", "added_mass", flights=flights)
    problem = selection.problems.problem
    dropped = settle(Predicted(selection, problem.library, problem.data))
    assert [one.name for one in selection.chosen] == ["wind"]
    assert [one.name for one in dropped] == ["added_mass"]


def test_what_predictions_need_is_asked_for_once_what_they_do_not_need_has_gone() -> None:
    """80 mg stood first, as what explains a few hundredths of a second as well as a wind may."""
    flights = flights_with_all({"wind": WIND, "added_mass": {"value": 8e-5}})
    selection = chosen(("wind", "added_mass", "linear_drag"), "added_mass", flights=flights)
    problem = selection.problems.problem
    predicted = Predicted(selection, problem.library, problem.data)
    assert [one.name for one in settle(predicted)] == ["added_mass"]
    assert [one.name for one in selection.chosen] == ["wind"]
    assert predicted.small() == ()


def test_once_others_have_gone_what_costs_less_takes_the_place_of_what_the_logs_do_not_refute() -> None:
    """A linear drag stands for a small quadratic one beyond chance, and with a tenth of the weight."""
    keys, flights = ("linear_drag", "quadratic_drag"), flights_with("quadratic_drag", {"value": 0.003})
    linear, quadratic = (chosen(keys, key, flights=flights) for key in keys)
    assert refuted(Near.of(linear)) is None
    found = refuted(Near.of(linear), gone=())
    assert found is not None
    assert found.candidate.name == "linear_drag"
    assert refuted(Near.of(linear), gone=("quadratic_drag",)) is None
    assert refuted(Near.of(quadratic), gone=()) is None
    drag, other = linear.candidates
    begins_late = replace(other, needs_start=True, starts=(0.002,))  # as what acts from a threshold on
    beside = Selection(linear.problems, (drag, begins_late), linear.origin)
    beside.put([drag], linear.fit)
    assert [other.candidate for other in Near.of(beside).places[0].alternatives] == [begins_late]
    assert refuted(Near.of(beside), gone=()) is None


def test_numbers_count_that_differ_from_none() -> None:
    """Of a wind along one axis one number; of few blocks of data, which do not tell, no number."""
    along = chosen(("wind",), "wind", flights=flights_with("wind", {"fx": 0.02, "fy": 0.0}))
    both = chosen(("wind",), "wind")
    assert (along.complexity(along.present), both.complexity(both.present)) == ((0, 1), (0, 2))
    short = chosen(("wind",), "wind", flights=flights_with("wind", WIND, count=1, steps=100))
    assert short.problems.block_count < 10
    assert short.complexity(short.present) == (0, 0)


def test_a_share_that_goes_with_another_parameter_is_no_number_of_its_own() -> None:
    """Of a delay the part by which a command's mean acts: at none, at all of it, it is one delay."""
    base, tasks = MUSHR.nominal(), [make_task("circle", MUSHR)]
    data = noisy_runs(MUSHR, tasks, [("delay", {"value": 0.1})], count=4, rows=200, dither=1.0, seed=0)
    library = Library.of(base, [effect("delay", base)])
    selection = Selection(weighed_problems(library, data), candidates(library, data), library.null)
    (delay,) = selection.candidates
    (scored,) = selection.ranked(selection.present, [delay])
    selection.put([delay], scored.fit)
    shares = [slot for slot in delay.slots if not library.slots[slot].parameter.acts_alone]
    assert shares
    counts = []
    for share in (0.0, 1.0):
        values = selection.fit.values.clone()
        values[shares] = share
        known = replace(selection.fit, values=values, curvature=1e6 * selection.fit.curvature)  # to the last digit
        counts.append(selection.complexity(replace(selection.present, fit=known)))
    assert counts == [(0, 1), (0, 1)]


@pytest.mark.slow
def test_an_effect_that_saves_no_more_than_the_standard_error_gives_way_to_a_plainer_one() -> None:
    """A linear drag has three numbers; of a small quadratic one it explains as much, of a linear one surely more."""
    keys, flights = ("linear_drag", "quadratic_drag"), flights_with("quadratic_drag", {"value": 0.003})
    linear, quadratic = (chosen(keys, key, flights=flights) for key in keys)
    found = plainer(linear)
    assert found is not None
    assert found.candidate.name == "quadratic_drag"
    assert plainer(linear, gone=("quadratic_drag",)) is None
    assert plainer(quadratic) is None
    strong = flights_with("linear_drag", {"cx": 0.03, "cy": 0.03, "cz": 0.03})
    assert plainer(chosen(keys, "linear_drag", flights=strong)) is None


@pytest.mark.parametrize("worse", [False, True])
def test_a_plainer_set_of_which_two_effects_are_others_takes_the_place_of_what_stands(
    worse: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A quadratic drag that joins neither a mass nor a gain of the thrust, and is known beside the gain.

    Where predictions are worse by it, it does not.
    """
    flights = flights_with_all({"quadratic_drag": {"value": 0.008}, "added_mass": {"value": 0.002}})
    selection = chosen(("linear_drag", "added_mass", "gain:thrust", "quadratic_drag"), flights=flights)
    linear, mass, gain, drag = selection.candidates
    mass, gain = (replace(own, excludes=(drag.name,)) for own in (mass, gain))
    selection.candidates = [linear, mass, gain, drag]
    for own in (mass, linear):
        (scored,) = selection.ranked(selection.present, [own])
        selection.put(scored.chosen, scored.fit)
    predicted = Predicted(selection, selection.problems.problem.library, selection.problems.problem.data)
    settle(predicted)
    assert selection.present.names == {mass.name, linear.name}
    selection.beside([gain, drag], selection.fit)
    if worse:
        monkeypatch.setattr(Predicted, "no_worse", lambda *_: False)
    assert settle(predicted) == ()
    plain = ({gain.name, drag.name}, {mass.name, drag.name})
    assert {own.name for own in selection.chosen} in (({mass.name, linear.name},) if worse else plain)


def test_predictions_say_which_of_two_sets_is_worse() -> None:
    selection = chosen(("wind", "added_mass"), "wind")
    predicted = Predicted(selection, selection.problems.problem.library, selection.problems.problem.data)
    windy, calm = selection.present, selection.without(selection.present, selection.chosen[0])
    assert predicted.no_worse(windy, calm)
    assert not predicted.no_worse(calm, windy)
    assert predicted.no_worse(calm, calm)


@pytest.mark.parametrize(("logs", "stays"), [(4, False), (8, True)], ids=["four logs", "eight logs"])
def test_what_whole_logs_establish_stays_beside_what_predictions_need(logs: int, stays: bool) -> None:
    """80 mg, in flights without trim: too little for a prediction among noise, and there in every flight."""
    flights = flights_with_all({"wind": WIND, "added_mass": {"value": 8e-5}}, count=logs)
    selection = chosen(("wind", "added_mass"), "wind", "added_mass", flights=flights)
    problem = selection.problems.problem
    predicted = Predicted(selection, problem.library, problem.data)
    keep_needed(predicted)
    assert [one.name for one in selection.chosen] == ["wind", "added_mass"][: 1 + stays]
    assert [one.name for one in predicted.small()] == ["added_mass"][:stays]


@pytest.mark.parametrize(
    ("added", "late", "borne_out"),
    [(0.003, "added_mass", True), (8e-5, "added_mass", True), (0.0, "linear_drag", False)],
    ids=["3 g", "80 mg", "nothing"],
)
def test_what_joins_late_is_established_by_whole_logs(added: float, late: str, borne_out: bool) -> None:
    """80 mg are, though no prediction needs them."""
    flights = flights_with_all({"wind": WIND, "added_mass": {"value": added}}, count=8)
    selection = chosen(("wind", late), "wind", flights=flights)
    problem = selection.problems.problem
    alternatives = [one for one in selection.candidates if one.name == late]
    (larger,) = selection.ranked(selection.present, alternatives)
    assert Predicted(selection, problem.library, problem.data).bears_out(larger) is borne_out


@pytest.mark.parametrize(("logs", "joins"), [(4, False), (8, True)], ids=["four logs", "eight logs"])
def test_what_moves_little_joins_what_was_chosen_where_logs_are_not_few(logs: int, joins: bool) -> None:
    """80 mg beside a wind; drag, which is not there, does not join."""
    flights = flights_with_all({"wind": WIND, "added_mass": {"value": 8e-5}}, count=logs)
    selection = chosen(("wind", "added_mass", "linear_drag"), "wind", flights=flights)
    predicted = Predicted(selection, selection.problems.problem.library, selection.problems.problem.data)
    join_narrow(predicted)
    assert [one.name for one in selection.chosen] == ["wind", "added_mass"][: 1 + joins]
    assert [one.name for one in predicted.small()] == ["added_mass"][:joins]


def test_where_nothing_was_chosen_no_effect_is_small() -> None:
    selection = chosen(("wind",))
    predicted = Predicted(selection, selection.problems.problem.library, selection.problems.problem.data)
    assert predicted.horizons
    assert predicted.small() == ()


@pytest.mark.parametrize(("value", "times"), [(1e-6, 1), (-0.02, 2)], ids=["tiny, in few logs", "wrong"])
def test_what_is_not_needed_goes_where_few_logs_show_it_or_predictions_are_worse(value: float, times: int) -> None:
    """A wind at a value that no fit corrects."""
    logs = list(flights_with("wind", WIND))
    flights = Dataset([replace(log, name=f"{log.name} {time}") for time in range(times) for log in logs])
    selection = chosen(("wind", "linear_drag"), "wind", flights=flights)
    values = selection.fit.values.clone()
    values[selection.chosen[0].slots] = value
    selection.put(selection.chosen, replace(selection.fit, values=values, gradient=0 * selection.fit.gradient))
    problem = selection.problems.problem
    keep_needed(Predicted(selection, problem.library, problem.data))
    assert not selection.chosen


def test_the_end_of_what_is_likely_is_a_bound_and_none_of_an_effect_is_not() -> None:
    selection = chosen(("wind", "linear_drag"), "wind")
    wind, drag = selection.candidates
    low, high = selection.problems.problem.library.bounds
    assert not selection.at_bound(selection.fit, wind)
    assert not selection.at_bound(selection.fit, drag)  # no drag, which is the least that there can be
    for slot, bound in ((wind.slots[0], low), (wind.slots[1], high), (drag.slots[2], high)):
        values = selection.fit.values.clone()
        values[slot] = bound[slot]
        one = wind if slot in wind.slots else drag
        assert selection.at_bound(replace(selection.fit, values=values), one)


def test_what_shares_a_number_or_cannot_stand_beside_what_is_chosen_is_not_open() -> None:
    selection = chosen(("wind", "linear_drag", "quadratic_drag"))
    wind, drag, other = selection.candidates
    assert selection.open([wind], selection.candidates) == [drag, other]
    apart = replace(drag, excludes=(other.name,))
    assert selection.open([apart], selection.candidates) == [wind]


def test_in_an_effects_place_stands_another_that_is_not_at_its_bound() -> None:
    keys, flights = ("linear_drag", "quadratic_drag"), flights_with("quadratic_drag", {"value": 0.003})
    selection = chosen(keys, "quadratic_drag", flights=flights)
    (place,) = Near.of(selection).places
    assert [other.candidate.name for other in place.alternatives] == ["linear_drag"]
    least = 0.1 * float(place.alternatives[0].fit.values[selection.candidates[0].slots].abs().max())
    narrow = narrowed(selection, "linear_drag", least)
    narrow.put(selection.chosen, selection.fit)
    assert Near.of(narrow).places[0].alternatives == []


@pytest.mark.parametrize("surely", [False, True])
def test_what_costs_less_beside_an_effect_is_in_its_place_unless_it_surely_does(surely: bool) -> None:
    """Of a quadratic drag a linear one explains as much."""
    keys, flights = ("linear_drag", "quadratic_drag"), flights_with("quadratic_drag", {"value": 0.003})
    selection = chosen(keys, "quadratic_drag", flights=flights)
    (other,) = Near.of(selection).places[0].alternatives
    (both,) = selection.ranked(selection.present, [other.candidate])
    selection.known[both.names] = replace(both, price=other.price - (1e6 if surely else 1e-6))
    assert len(Near.of(selection).places[0].alternatives) == 1 - surely


def test_an_effect_that_is_larger_than_what_is_likely_is_told() -> None:
    """Half of the wind that there is."""
    selection = chosen(("wind",))
    assert not selection.driven_to_bounds()
    assert narrowed(selection, "wind", 0.01).driven_to_bounds() == ["wind"]


@pytest.mark.slow
@pytest.mark.parametrize(("hidden", "stays"), [({"wind": WIND}, False), ({"linear_drag": DRAG}, True)], ids=str)
def test_what_stands_for_an_effect_that_is_larger_than_likely_gives_way_to_nothing(
    hidden: dict[str, dict[str, float]], stays: bool
) -> None:
    """A drag in its own flights stays, and one in a wind of 0.02 N does not where no more than 0.015 N is likely."""
    selection = narrowed(chosen(("wind", "linear_drag"), flights=flights_with_all(hidden, count=8)), "wind", 0.015)
    drag = selection.candidates[1]
    selection.put([drag], selection.beside([drag], selection.fit).fit)
    settle(Predicted(selection, selection.problems.problem.library, selection.problems.problem.data))
    assert selection.chosen == [drag][:stays]


def narrowed(selection: Selection, key: str, most: float) -> Selection:
    """Nothing chosen, and the parameters of an effect within ± ``most``."""
    problems, library = selection.problems, selection.problems.problem.library
    slots = tuple(
        replace(slot, parameter=replace(slot.parameter, low=-most, high=most)) if slot.effect == key else slot
        for slot in library.slots
    )
    problem = Problem(replace(library, slots=slots), problems.problem.data, problems.problem.segments)
    return Selection(replace(problems, problem=problem), selection.candidates, selection.origin)


@pytest.mark.parametrize(
    ("without", "alternative", "good"),
    [
        ([2.0] * 4, [1.005] * 4, True),  # less than what any finding needs, however sure
        ([2.0] * 4, [1.05] * 4, False),
        ([2.0] * 4, [0.6, 1.5, 0.6, 1.5], True),  # folds do not agree
        ([2.0] * 4, [2.1] * 4, False),  # no better than nothing in that place
        ([1.002] * 4, [1.0001] * 4, True),  # worth little, as the finding is: nearly all of it
        ([1.002] * 4, [1.0005] * 4, False),
    ],
)
def test_an_alternative_is_as_good_where_it_saves_what_the_finding_does_and_is_worth_its_place(
    without: list[float], alternative: list[float], good: bool
) -> None:
    near = Near.of(chosen(("wind",), "wind"))
    folds = torch.ones(4, dtype=torch.float64)
    near = replace(near, present=replace(near.present, held_out=1e4 * folds))
    assert as_good(near, 1e4 * torch.tensor(without) * folds, 1e4 * torch.tensor(alternative) * folds) is good
