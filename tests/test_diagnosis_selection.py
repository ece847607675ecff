"""Which effects are tried beside a set, what they promise, and what a set would cost without one of its own."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from noisy_flights import flights_with_all
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import WARM_UP
from sym2real.diagnosis.data.start import ROWS
from sym2real.diagnosis.estimate.fit import Hypothesis, Problems
from sym2real.diagnosis.predict.candidate import Candidate, candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.score.importance import _windows, by_importance
from sym2real.diagnosis.search.needed import Predicted
from sym2real.diagnosis.search.select import REFITTED, Selection, parameter_set
from sym2real.diagnosis.search.settled import _stands
from sym2real.effects import effect
from sym2real.robots import CRAZYFLIE

KEYS = ("wind", "added_mass", "linear_drag", "quadratic_drag")


@cache
def problems() -> tuple[Problems, tuple[Candidate, ...]]:
    """Flights with a mass more and in wind."""
    base = CRAZYFLIE.nominal()
    data = flights_with_all({"wind": {"fx": 0.02, "fy": -0.01}, "added_mass": {"value": 0.003}})
    library = Library.of(base, [effect(key, base) for key in KEYS])
    return weighed_problems(library, data), candidates(library, data)


def selection(*names: str) -> Selection:
    """Some of the effects, fitted together."""
    weighed, tried = problems()
    made = Selection(weighed, tried, weighed.library.null)
    chosen = [one for name in names for one in tried if one.name == name]
    made.put(chosen, made.beside(chosen, weighed.fit([Hypothesis(made.free(tried), made.origin)])[0]).fit)
    return made


@pytest.mark.parametrize(("names", "part"), [((), 0.3 * 0.005), (("wind",), 0.3 * 0.01)])
def test_what_promises_three_tenths_of_the_gain_that_a_finding_needs_is_fitted(
    names: tuple[str, ...], part: float
) -> None:
    own = selection(*names)
    offered = [one for one in own.candidates if one.name not in names]
    losses = [100.0 * (1 - factor * part) for factor in (2.0, 1.01, 0.99)]
    entries = [(loss, one, own.fit.values) for loss, one in zip(losses, offered, strict=False)]
    own._screenings[own.present] = (100.0, entries)
    tried = {larger.candidate.name for larger in own.larger(own.present)}
    assert tried == {one.name for one in offered[:2]}
    losses = [larger.loss for larger in own.larger(own.present)]
    assert losses == sorted(losses)


def test_no_more_are_fitted_than_a_screening_is_trusted_with() -> None:
    own = selection()
    twins = [replace(own.candidates[0], name=f"twin {number}") for number in range(9)]
    own._screenings[own.present] = (100.0, [(50.0 + place, twin, own.origin) for place, twin in enumerate(twins)])
    assert {larger.candidate.name for larger in own.larger(own.present)} == {one.name for one in twins[:REFITTED]}


@pytest.mark.parametrize(
    ("promised", "price"), [((90.0, 95.0), 90.0 / 0.995), ((120.0,), 100.0), ((99.9,), 100.0), ((), 100.0)]
)
def test_a_set_promises_the_price_of_its_best_larger_one_or_its_own(promised: tuple[float, ...], price: float) -> None:
    own = selection()
    present = replace(own.present, price=100.0)
    own._screenings[present] = (100.0, [(loss, own.candidates[0], own.origin) for loss in promised])
    assert own.promise(present) == pytest.approx(price)


def test_the_price_without_an_effect_is_about_that_of_the_set_that_is_fitted_without_it() -> None:
    own = selection("wind", "added_mass")
    for one in own.chosen:
        fitted = own.without(own.present, one)
        assert own.predicted_without(own.present, one) == pytest.approx(fitted.price, rel=0.15)
        assert fitted.price > 1.5 * own.present.price
        assert fitted.names == own.present.names - {one.name}


def test_of_a_set_that_is_fitted_twice_the_better_fit_is_known() -> None:
    own = selection("wind")
    good = own.present
    (bad,) = own.problems.quadratics([Hypothesis(good.fit.free, own.origin)])
    own.set_of(good.chosen, bad)
    assert own.known[good.names].fit is good.fit
    own.known.clear()
    own.set_of(good.chosen, bad)
    assert own.known[good.names].fit is bad
    assert own.set_of(good.chosen, good.fit) is own.known[good.names]


def test_screening_finds_what_is_there_first_and_says_about_what_its_fit_leaves() -> None:
    own = selection("wind")
    reference, screened = own.screening(own.present)
    assert reference == pytest.approx(own.present.loss, rel=1e-6)
    (loss, best, start), *_ = screened
    assert best.name == "added_mass"
    assert float(start[best.slots]) == pytest.approx(0.003, rel=0.15)
    (fitted,) = own.refitted(own.chosen, [(best, own.fit.values)])
    assert loss == pytest.approx(fitted.loss, rel=0.1)
    assert [entry[0] for entry in screened] == sorted(entry[0] for entry in screened)
    assert {one.name for _, one, _ in screened} == {*KEYS} - {"wind"}


def test_a_candidate_with_starts_is_screened_from_the_best_of_them() -> None:
    own = selection("wind")
    (mass,) = (one for one in own.candidates if one.name == "added_mass")
    late = replace(mass, starts=(0.05, 0.003), needs_start=True)
    far = replace(mass, starts=(0.05,), needs_start=True)
    own.candidates = [late]
    ((loss, _, start),) = own.screening(own.present)[1]
    assert float(start[mass.slots]) == pytest.approx(0.003, rel=0.15)
    other = selection("wind")
    other.candidates = [far]
    assert other.screening(other.present)[1][0][0] > loss
    hypotheses = own.started([late], own.fit.values)
    assert [float(one.values[mass.slots]) for one in hypotheses] == [0.05, 0.003]


def test_a_set_of_parameters_holds_the_values_of_what_is_kept_and_nothing_else() -> None:
    own = selection("wind", "added_mass")
    wind, mass = own.chosen
    values = parameter_set(own, [wind], own.fit.values)
    assert values[wind.slots].tolist() == own.fit.values[wind.slots].tolist()
    assert values[mass.slots].tolist() == [0.0]


@pytest.mark.parametrize("names", [("wind", "added_mass"), ("added_mass", "wind")])
def test_the_most_important_effect_is_that_without_which_free_predictions_miss_most(names: tuple[str, ...]) -> None:
    """A tenth of the weight more falls by two metres in two seconds, and the wind blows half as far."""
    own = selection(*names)
    (first, alone), (last, both) = by_importance(own)
    assert (first.name, last.name) == ("added_mass", "wind")
    assert alone.free == first.free
    assert both is own.fit
    assert alone.total > both.total
    assert by_importance(own) is own.order
    own.put(own.chosen, own.fit)
    own.small = (first,)
    assert [one.name for one, _ in by_importance(own)] == ["wind", "added_mass"]  # no prediction would need the first
    only = selection("wind")
    assert [(one.name, fit) for one, fit in by_importance(only)] == [("wind", only.fit)]
    assert by_importance(selection()) == []


def test_in_logs_shorter_than_a_free_run_the_longest_says_how_far_is_predicted() -> None:
    """Those that are a few rows shorter take no part."""
    base, flights = CRAZYFLIE.nominal(), flights_with_all({"wind": {"fx": 0.02, "fy": -0.01}})
    data = Dataset([flights[0].rows(0, 81), *(log.rows(0, 78) for log in flights[1:])])
    library = Library.of(base, [effect(key, base) for key in ("wind", "added_mass")])
    own = Selection(weighed_problems(library, data), candidates(library, data), library.null)
    windows = _windows(own).segments
    assert windows.length == 81 - ROWS - WARM_UP
    assert [*windows.log] == [0]


def test_what_the_next_run_has_anew_comes_last_however_much_it_moves() -> None:
    """A board that is screwed on two degrees askew, beside a fifth of a gram."""
    base = CRAZYFLIE.nominal()
    data = flights_with_all({"mounting_tilt": {"roll": 0.035}, "added_mass": {"value": 2e-4}})
    library = Library.of(base, [effect(key, base) for key in ("mounting_tilt", "added_mass")])
    weighed, (tilt, mass) = weighed_problems(library, data), candidates(library, data)
    own = Selection(weighed, (tilt, mass), library.null)
    own.put([tilt, mass], weighed.fit([Hypothesis(own.free([tilt, mass]), library.null)])[0])
    assert [one for one, _ in by_importance(own)] == [mass, tilt]


@pytest.mark.parametrize(("late", "stands"), [("added_mass", True), ("linear_drag", False)])
def test_what_joins_late_stands_where_no_set_around_refutes_it(late: str, stands: bool) -> None:
    """Of logs too short to predict: nothing else speaks against a drag that is not there."""
    own = selection("wind")
    (joined,) = own.ranked(own.present, [one for one in own.candidates if one.name == late])
    predicted = Predicted(own, own.problems.library, Dataset([own.problems.data[0].rows(0, 14)]))
    assert predicted.bears_out(joined)
    assert _stands(predicted, joined) is stands
    assert own.present.names == {"wind"}  # nobody has joined yet
