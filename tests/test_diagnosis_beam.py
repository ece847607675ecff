"""A search over sets of effects: whatever it begins with, whatever the order of what competes."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from noisy_flights import flights_with_all
from weighed_problems import weighed_problems

from sym2real.diagnosis.estimate.fit import Hypothesis, Problems
from sym2real.diagnosis.estimate.significance import standard_error
from sym2real.diagnosis.predict.candidate import Candidate, candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.search import beam as beam_module
from sym2real.diagnosis.search.beam import Beam
from sym2real.diagnosis.search.needed import Predicted
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.search.settled import settle
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import effect
from sym2real.robots import CRAZYFLIE

HIDDEN = {"wind": {"fx": 0.02, "fy": -0.01}, "added_mass": {"value": 0.003}}
KEYS = ("linear_drag", "wind", "added_mass", "quadratic_drag")


@cache
def problems() -> tuple[Problems, tuple[Candidate, ...]]:
    """Flights with a mass more and in wind, and what competes to explain them."""
    base, data = CRAZYFLIE.nominal(), flights_with_all(HIDDEN)
    library = Library.of(base, [effect(key, base) for key in KEYS])
    return weighed_problems(library, data), candidates(library, data)


def selection_of(tried: Sequence[Candidate]) -> Selection:
    weighed, _ = problems()
    return Selection(weighed, tried, weighed.problem.library.null)


def with_names(names: Sequence[str]) -> Selection:
    """Effects put in one after the other, whatever they gain."""
    tried = problems()[1]
    selection = selection_of(tried)
    for candidate in (candidate for name in names for candidate in tried if candidate.name == name):
        (joined,) = selection.ranked(selection.present, [candidate])
        selection.put(joined.chosen, joined.fit)
    return selection


@pytest.mark.parametrize("begun_with", [(), ("linear_drag",), ("quadratic_drag", "wind")], ids=str)
def test_whatever_it_begins_with_a_search_ends_with_what_is_there(begun_with: tuple[str, ...]) -> None:
    selection = with_names(begun_with)
    Beam(selection).search()
    assert {candidate.name for candidate in selection.chosen} == set(HIDDEN)
    library = selection.problems.problem.library
    found = {library.slots[slot].parameter.name: float(selection.fit.values[slot]) for slot in slots(selection)}
    assert found == pytest.approx({"fx": 0.02, "fy": -0.01, "value": 0.003}, rel=0.1)


def slots(selection: Selection) -> list[int]:
    return [slot for candidate in selection.chosen for slot in candidate.slots]


def test_where_nothing_else_helps_the_only_effect_that_does_is_the_answer() -> None:
    """All at once may leave less all the same; without that effect there is then nowhere to go on to."""
    (wind,) = (candidate for candidate in problems()[1] if candidate.name == "wind")
    selection = selection_of([wind])
    Beam(selection).search()
    assert selection.chosen == [wind]


def test_the_order_of_what_competes_does_not_matter() -> None:
    tried = problems()[1]
    forwards, backwards = selection_of(tried), selection_of(tried[::-1])
    for selection in (forwards, backwards):
        Beam(selection).search()
    assert {candidate.name for candidate in forwards.chosen} == {candidate.name for candidate in backwards.chosen}
    assert forwards.present.loss == pytest.approx(backwards.present.loss, rel=1e-4)


def test_no_set_that_was_looked_at_is_cheaper_than_the_answer_and_beyond_chance() -> None:
    selection = selection_of(problems()[1])
    beam = Beam(selection)
    beam.search()
    own = selection.price(selection.present.loss, len(selection.chosen))
    for effects in (effects for effects in beam.sets.values() if effects.price < own):
        doubtful = {member.name for member in effects.chosen if not selection.significant(effects.fit, member)}
        assert any(effects.names - {name} in beam.looked_around for name in doubtful)
    assert {
        frozenset(candidate.name for candidate in selection.chosen) - {name} for name in HIDDEN
    } <= beam.looked_around


def test_a_large_set_that_promises_nothing_is_not_looked_around_in() -> None:
    beam = Beam(selection_of(problems()[1]), least=float("inf"))
    beam.search()
    best = beam.sets[frozenset(HIDDEN)]
    around = [beam.sets[names] for names in beam.looked_around if names != best.names]
    assert all(len(effects.chosen) < len(best.chosen) for effects in around)
    assert beam.selection.promise(best) == best.price


def test_a_set_is_surely_cheaper_only_beyond_a_standard_error() -> None:
    beam = Beam(selection_of(problems()[1]))
    beam.search()
    weighed, right = beam.selection.problems, beam.sets[frozenset(HIDDEN)]
    larger, *_ = beam.selection.ranked(right, beam.selection.candidates)
    gain = weighed.held_out_segments(right.fit) - weighed.held_out_segments(larger.fit)
    assert float(gain.sum()) == pytest.approx(right.loss - larger.loss, rel=1e-6)
    for part, surely in ((0.5, False), (2.0, True)):
        wanted = right.price - part * standard_error(weighed, gain)
        cheaper = replace(larger, price=wanted)
        assert beam.selection.surely_cheaper(cheaper, right) is surely
    assert all(beam.selection.surely_cheaper(right, beam.sets[part]) for part in right.smaller)


def test_whoever_ends_a_search_keeps_the_best_set_so_far() -> None:
    def end(message: str) -> None:
        raise KeyboardInterrupt

    selection = selection_of(problems()[1])
    with pytest.raises(KeyboardInterrupt):
        Beam(selection, end).search()
    assert [candidate.name for candidate in selection.chosen] in (["wind"], ["added_mass"])


def test_an_effect_more_costs_a_share_of_the_loss() -> None:
    """Half a hundredth; beside another effect a hundredth, of four logs three."""
    selection = selection_of(problems()[1])
    many = replace(selection.problems, problem=copy(selection.problems.problem))
    many.problem.segments = replace(many.problem.segments, log=np.arange(len(many.problem.segments)) % 8)
    for weighed, beside in ((selection.problems, 0.97), (many, 0.99)):
        selection.problems = weighed
        prices = [selection.price(1000.0, count) for count in range(SETTINGS.most_findings + 1)]
        assert [more / less for less, more in pairwise(prices)] == pytest.approx(
            [1 / 0.995, *[1 / beside] * (SETTINGS.most_findings - 1)]
        )


@pytest.mark.parametrize("last", [False, True])
def test_of_two_effects_that_do_the_same_the_one_without_a_threshold_is_named(last: bool) -> None:
    """A limit that always acts is a load: the same parameter under another name, without a null to start from."""
    _, tried = problems()
    (mass,) = (candidate for candidate in tried if candidate.name == "added_mass")
    threshold = replace(mass, name="always beyond a threshold", starts=(0.003,), needs_start=True)
    selection = selection_of([*tried, threshold] if last else [threshold, *tried])
    Beam(selection).search()
    settle(Predicted(selection, selection.problems.library, selection.problems.data))
    assert {candidate.name for candidate in selection.chosen} == set(HIDDEN)


def test_a_set_in_a_higher_valley_is_fitted_anew_from_the_starts_of_its_effects() -> None:
    """A mass that a fit does not leave, because it says that it has no slope there; larger sets were fitted from it."""
    tried = tuple(
        replace(one, starts=(0.003,)) if one.name == "added_mass" else one
        for one in problems()[1]
        if one.name in HIDDEN or one.name == "linear_drag"
    )
    beam = Beam(selection_of(tried))
    beam.search()
    names, selection = frozenset(HIDDEN), beam.selection
    best = beam.sets[names]
    values = best.fit.values.clone()
    values[[slot for one in best.chosen if one.name == "added_mass" for slot in one.slots]] = 0.02
    (high,) = selection.problems.quadratics([Hypothesis(best.fit.free, values)])
    again = Beam(selection_of(tried))  # knows of no better fit
    stuck = again.selection.set_of(best.chosen, replace(high, gradient=0 * high.gradient))
    again.sets, again.looked_around = {names: stuck}, {names}
    again.selection._larger[names] = [stuck]
    again.search()
    assert again.sets[names].fit.total == pytest.approx(best.fit.total, rel=1e-3)
    assert again.selection.larger(again.sets[names]) != [stuck]


@pytest.mark.parametrize(("least", "found"), [(0.0, set(HIDDEN)), (float("inf"), {"stands for both"})])
def test_what_stands_for_two_effects_gives_way_to_both_where_less_can_be_left(
    least: float, found: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each of the two, put in its place, is worse; that no first effect decides is switched off for once."""
    monkeypatch.setattr(beam_module, "SCREENED", 0)
    mass, wind = (next(one for one in problems()[1] if one.name == name) for name in ("added_mass", "wind"))
    both = replace(mass, name="stands for both", free=(*mass.slots, wind.slots[0]))  # and not for the wind across
    selection = selection_of([mass, wind, both])
    (joined,) = selection.ranked(selection.present, [both])
    assert all(joined.price < other.price for other in selection.ranked(selection.present, [mass, wind]))
    selection.put(joined.chosen, joined.fit)
    Beam(selection, least=least).search()
    assert {candidate.name for candidate in selection.chosen} == found


@pytest.mark.parametrize(
    ("of_both", "within_chance", "answer"),
    [
        (4.0, (), {"wind", "added_mass"}),
        (6.0, (), {"wind"}),
        (5.0, (), {"wind"}),  # no cheaper
        (4.0, ("both",), {"wind"}),
        (6.0, ("wind",), set()),  # what is beyond chance in a set that is not worth its size is no answer
        (4.0, ("wind",), {"wind", "added_mass"}),
    ],
)
def test_the_answer_is_the_cheapest_set_that_is_beyond_chance_and_worth_its_size(
    of_both: float, within_chance: tuple[str, ...], answer: set[str]
) -> None:
    selection = with_names(("wind", "added_mass"))
    both, mass = selection.present, selection.chosen[1]
    wind = selection.without(both, mass)
    nothing = selection.without(wind, wind.candidate)
    sets = {"nothing": replace(nothing, price=10.0), "wind": replace(wind, price=5.0)}
    sets["both"] = replace(both, price=of_both)
    for name in within_chance:
        selection._significant[sets[name].fit, sets[name].candidate.name] = False
    beam = Beam(selection)
    beam.sets = {own.names: own for own in sets.values()}
    assert beam._best().names == answer


@pytest.mark.parametrize(("most", "found"), [(1, 1), (2, 2)])
def test_no_set_is_larger_than_a_day_s_logs_can_test(most: int, found: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beam_module, "SETTINGS", replace(SETTINGS, most_findings=most))
    beam = Beam(selection_of(problems()[1]))
    beam.search()
    assert len(beam.selection.chosen) == found
    assert max(map(len, beam.sets)) == most


def test_where_nothing_is_beyond_chance_cheaper_sets_are_looked_around_in_without_what_is_not() -> None:
    selection = selection_of(problems()[1])
    selection.tested = 10**300
    beam = Beam(selection)
    beam.search()
    assert selection.chosen == []
    cheaper = [own for own in beam.sets.values() if own.price < selection.present.price and beam._worth_its_size(own)]
    for size in {len(own.chosen) for own in cheaper}:
        best = min((own for own in cheaper if len(own.chosen) == size), key=lambda own: own.price)
        assert min(best.smaller, key=lambda names: beam.sets[names].price) in beam.looked_around


def test_a_set_that_is_fitted_better_from_other_starts_is_looked_around_in_anew() -> None:
    tried = tuple(replace(one, starts=(0.003,)) for one in problems()[1] if one.name == "added_mass")
    selection = selection_of(tried)
    (best,) = selection.ranked(selection.present, tried)
    values = best.fit.values.clone()
    values[tried[0].slots] = 0.02
    (high,) = selection.problems.quadratics([Hypothesis(best.fit.free, values)])
    selection = selection_of(tried)  # knows of no better fit
    beam = Beam(selection)
    beam.sets[best.names] = selection.set_of(best.chosen, replace(high, gradient=0 * high.gradient))
    beam.looked_around.add(best.names)
    assert beam._fitted_better()
    assert best.names not in beam.looked_around
    assert beam.sets[best.names].fit.total == pytest.approx(best.fit.total, rel=1e-3)
    beam.looked_around.add(best.names)
    assert not beam._fitted_better()  # nothing that was not tried
    assert best.names in beam.looked_around


@pytest.mark.parametrize(("fall", "kept"), [(0.02, True), (1e-5, False)])
def test_a_fit_of_a_known_set_is_another_one_where_it_leaves_less_beyond_rounding(fall: float, kept: bool) -> None:
    selection = with_names(("wind",))
    beam, known = Beam(selection), selection.present
    beam._keep(known)
    selection._larger[known.names] = [known]
    other = replace(known, fit=replace(known.fit, loss=(1 - fall) * known.fit.loss))
    beam._keep(other)
    assert (beam.sets[known.names] is other) is kept
    assert (known.names in selection._larger) is not kept


def test_a_search_does_not_look_around_twice_in_one_set() -> None:
    selection = selection_of(problems()[1][:1])
    beam = Beam(selection)
    beam._keep(selection.present)
    assert next(beam._waiting()) is selection.present
    beam._look_around(selection.present)
    assert selection.present.names not in {effects.names for effects in beam._waiting()}
