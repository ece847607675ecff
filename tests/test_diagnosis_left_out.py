"""Who predicts a log that the fit left out, over which horizons, and when an error has risen."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from noisy_flights import flights_with
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis.errors.rungs import HeldOut, Rung, RungError
from sym2real.diagnosis.estimate.fit import Hypothesis, Problems
from sym2real.diagnosis.estimate.whitening import Spread, disturbances, free_start
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.score.held_out import LadderModels
from sym2real.diagnosis.search.near import by_own_starts
from sym2real.diagnosis.search.needed import (
    Predicted,
    by_others,
    fold_of_log,
    judged_horizons,
    keep_needed,
    largest_rise,
    left_out,
    left_out_sets,
    no_worse,
    parts_of_others,
)
from sym2real.diagnosis.search.select import Selection, parameter_set
from sym2real.effects import effect
from sym2real.layout import Layout
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, quadrotor

WIND = {"fx": 0.02, "fy": -0.01}


def selected(data: Dataset) -> Selection:
    """A wind that was found."""
    base = CRAZYFLIE.nominal()
    library = Library.of(base, [effect("wind", base)])
    selection = Selection(weighed_problems(library, data), candidates(library, data), library.null)
    (wind,) = selection.ranked(selection.present, selection.candidates)
    selection.put(wind.chosen, wind.fit)
    return selection


@cache
def four() -> Selection:
    return selected(flights_with("wind", WIND))


@cache
def one() -> Selection:
    return selected(flights_with("wind", WIND, count=1, steps=300))


def test_a_log_without_segments_goes_with_the_one_before_it() -> None:
    first, second, *_ = flights_with("wind", WIND)
    short = [replace(first.rows(0, 30), name=f"short {number}") for number in range(3)]
    assert fold_of_log(selected(Dataset([short[0], first, short[1], second, short[2]]))).tolist() == [0, 0, 0, 1, 1]


def test_every_log_is_left_out_of_the_fit_that_predicts_it() -> None:
    selection = four()
    problems, fit = selection.problems, selection.fit
    assert left_out(selection, problems.library, problems.data).after == 0.0
    for fold, (part, values) in enumerate(zip(
        parts_of_others(selection, problems.problem.segments), by_others(selection, fit), strict=True
    )):  # fmt: skip
        assert part.tolist() == (problems.logs != fold).tolist()
        others = Dataset(log for number, log in enumerate(problems.data) if number != fold)
        alone = Problems(Problem(problems.library, others), replace(
            problems.whitening, lost=problems.whitening.lost[part], trust=problems.whitening.trust[part]
        ))  # fmt: skip
        (refitted,) = alone.fit([Hypothesis(fit.free, problems.library.null)])
        torch.testing.assert_close(values, refitted.values, rtol=0.02, atol=1e-5)


def test_of_a_single_log_the_first_two_thirds_predict_the_last() -> None:
    selection = one()
    (part,), segments = (
        parts_of_others(selection, selection.problems.problem.segments),
        selection.problems.problem.segments,
    )
    assert part.tolist() == [row + segments.length <= 200 for row in segments.row.tolist()]
    assert left_out(selection, selection.problems.library, selection.problems.data).after == pytest.approx(2 / 3)
    (values,) = left_out_sets(selection, selection.chosen, selection.fit)
    assert values[selection.chosen[0].slots].tolist() == pytest.approx(list(WIND.values()), rel=0.2)
    assert not torch.equal(values, selection.fit.values)


def test_a_ladder_of_the_logs_of_the_fit_leaves_each_of_them_out_and_one_of_others_none() -> None:
    selection, single = four(), one()
    library, logs = selection.problems.library, selection.problems.data
    same, others = (LadderModels.of(library, logs, selection, same=own) for own in (True, False))
    assert [name for name, _ in same.models] == ["base", "+ wind"]
    for steps in (same, others):
        assert torch.equal(steps.models[0][1], library.null[None])
    assert torch.equal(same.models[1][1], left_out_sets(selection, selection.chosen, selection.fit))
    assert torch.equal(others.models[1][1], parameter_set(selection, selection.chosen, selection.fit.values)[None])
    assert same.held.fold_of is not None
    assert same.held.fold_of.tolist() == [0, 1, 2, 3]
    assert others.held.fold_of is None
    assert same.names == tuple(log.name for log in logs)
    behind, alone = (LadderModels.of(library, single.problems.data, single, same=own) for own in (True, False))
    assert [own.held.after for own in (same, others, behind)] == [0.0, 0.0, pytest.approx(2 / 3)]
    assert alone.held.after == 0.0
    assert behind.names == (f"{single.problems.data[0].name} (last third)",)


def test_errors_are_judged_as_far_as_a_controller_looks_and_after_a_free_run() -> None:
    library, logs = four().problems.library, four().problems.data
    assert judged_horizons(HeldOut(library, logs)) == (0.8, 2.0)
    assert judged_horizons(HeldOut(library, one().problems.data, after=2 / 3)) == pytest.approx((0.8, 1.98))
    assert judged_horizons(HeldOut(library, Dataset([logs[0].rows(0, 14)]))) == ()


def test_logs_too_short_to_predict_bear_out_whatever_was_chosen() -> None:
    selection = four()
    predicted = Predicted(selection, selection.problems.library, Dataset([selection.problems.data[0].rows(0, 14)]))
    assert predicted.horizons == ()
    assert predicted.bears_out(selection.present)
    assert predicted.small() == ()
    assert predicted.needs_most([selection.present]) is None
    assert keep_needed(predicted) == ()
    assert selection.present.names == {"wind"}


def rung(value: float, low: float, drawn: float | None = None, **more: bool) -> Rung:
    """One error, its lower end, and what every draw of it is."""
    resampled = np.empty(0) if drawn is None else np.full(50, drawn)
    return Rung("", {0.8: {"position": RungError(value, value, low, 2 * value - low, "m", resampled)}}, **more)


@pytest.mark.parametrize(
    ("whole", "without", "factor"),
    [
        (rung(1.0, 0.9), rung(1.05, 1.02), 1.02),
        (rung(1.0, 0.9, 1.0), rung(1.05, 1.02, 1.5), 1.02),  # the ratio says more, and no tenth goes
        (rung(1.0, 0.5, 1.0), rung(2.0, 0.8, 1.5), 1.5),
        (rung(1.0, 0.5, 1.0), rung(2.0, 1.8, 1.5), 1.8),
        (rung(0.0, 0.0), rung(0.0, 0.0), 0.0),
    ],
)
def test_an_error_rises_by_its_own_lower_end_or_by_that_of_the_ratio_where_a_tenth_goes(
    whole: Rung, without: Rung, factor: float
) -> None:
    assert largest_rise(whole, without) == pytest.approx(factor)


@pytest.mark.parametrize(
    ("before", "after", "counts"), [(True, True, True), (True, False, True), (False, True, True), (False, False, False)]
)
def test_an_error_that_rises_counts_where_one_of_both_models_beats_no_change(
    *, before: bool, after: bool, counts: bool
) -> None:
    small, large = rung(1.0, 0.9, beats_hold=before), rung(2.0, 1.5, beats_hold=after)
    assert no_worse(large, small) is not counts
    assert no_worse(small, large)


def test_a_disturbance_of_size_one_goes_with_the_robot_s_mass_and_inertia() -> None:
    light, heavy = (dict(disturbances(quadrotor(mass, (mass * 1e-4,) * 3, dt=0.02))) for mass in (0.03, 0.3))
    assert light.keys() == {"fx", "fy", "fz", "tx", "ty", "tz"}
    for name, size in light.items():
        assert heavy[name] == pytest.approx(10.0 * size)
    assert light["fx"] == pytest.approx(0.01 * 0.03 * 9.81, rel=0.01)  # a hundredth of the weight
    assert light["tx"] == pytest.approx(0.03 * 1e-4)  # that turns by 1 rad/s²
    assert dict(disturbances(MUSHR.nominal())).keys() == {"steer", "speed"}  # nothing pushes it in its equations
    assert len(disturbances(ROBOTS["cart_pole"].nominal())) == 2


def test_a_covariance_by_another_one_s_noise_and_disturbances_has_these() -> None:
    problems = four().problems
    spread = Spread.of(problems.problem, problems.library.null)
    sized = disturbances(problems.library.equations)
    assert list(zip(spread.names, spread.sizes.tolist(), strict=True)) == sized
    other = replace(problems.whitening, disturbances={name: 3.0 * size for name, size in sized})
    alike = spread.like(other)
    assert alike.disturbances == pytest.approx(other.disturbances, rel=1e-12)
    torch.testing.assert_close(alike.sensor, other.sensor, rtol=1e-12, atol=0.0)


def test_a_set_by_its_own_starts_has_the_price_of_what_these_leave() -> None:
    """One that leaves so much that starts do not matter stays as it is."""
    known = four()
    spread = Spread.of(known.problems.problem, known.problems.library.null)
    selection = Selection(replace(known.problems, spread=spread), known.candidates, known.origin)
    selection.put(known.chosen, known.fit)
    by_own = by_own_starts(selection, selection.present)
    assert not torch.equal(by_own.held_out, selection.present.held_out)
    assert by_own.price == pytest.approx(selection.price(float(by_own.held_out.sum()), 1))
    nothing = selection.without(selection.present, selection.chosen[0])
    assert by_own_starts(selection, nothing) is nothing


def test_nothing_that_was_chosen_is_no_number() -> None:
    selection = four()
    assert selection.complexity(selection.without(selection.present, selection.chosen[0])) == (0, 0)


def test_a_free_start_is_as_free_as_its_field_and_one_of_its_own_kind_by_one() -> None:
    layout: Layout = CRAZYFLIE.layouts.state
    free = dict(zip((f.name for f in layout.fields for _ in range(f.tangent_size)), free_start(layout), strict=True))
    assert len(free_start(layout)) == layout.tangent_size
    assert [float(free[name]) for name in ("position", "attitude", "velocity", "rate")] == [0.05, 0.2, 0.5, 2.0]
    assert set(free_start(ROBOTS["cart_pole"].layouts.state).tolist()) == {1.0}
