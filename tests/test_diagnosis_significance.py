"""Tests beyond chance: level, power, and clusters that hold all that tells a parameter."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from noisy_flights import flights_with_all
from scipy import stats
from weighed_problems import weighed_problems

from sym2real.diagnosis.estimate.fit import Fit, Hypothesis, Problems
from sym2real.diagnosis.estimate.significance import (
    Distance,
    beyond_chance,
    beyond_trim,
    chance_of,
    collinear,
    half_widths,
    inflation,
    least_gain,
    sizes_beyond_chance,
    standard_error,
)
from sym2real.diagnosis.predict.candidate import Candidate, candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import effect
from sym2real.least_squares import solve
from sym2real.robots import CRAZYFLIE

CLUSTERS = 30


def distance(columns: np.ndarray, noise: np.ndarray, size: float, tested: list[int]) -> Distance:
    """Linear regression of noise and ``size`` in every tested parameter on columns ``# (S, A)``."""
    truth = np.zeros(columns.shape[1])
    truth[tested] = size
    measured = columns @ truth + noise
    best = np.linalg.lstsq(columns, measured, rcond=None)[0]
    gradient = columns * (columns @ best - measured)[:, None]
    curvature = columns[:, :, None] * columns[:, None, :]
    return Distance(torch.as_tensor(best[tested]), tested, torch.as_tensor(gradient), torch.as_tensor(curvature))


@pytest.mark.parametrize(("count", "exact"), [(8, False), (CLUSTERS, True)], ids=["logs", "blocks"])
def test_no_more_is_found_than_by_chance_where_nothing_is_there_though_noise_lasts(count: int, exact: bool) -> None:
    """Noise that is alike within a cluster, as trim is; with few clusters the jackknife finds less."""
    rng, clusters = np.random.default_rng(3), np.repeat(np.arange(count), 4)
    columns = np.repeat(rng.standard_normal((count, 3)), 4, axis=0)
    drawn = [distance(columns, np.repeat(rng.standard_normal(count), 4), 0.0, [0, 1]) for _ in range(400)]
    chances = np.array([one.chance(clusters) for one in drawn])
    shares = [float(np.mean(chances < level)) for level in (0.05, 0.3)]
    assert shares[0] < 0.08
    assert shares[1] < 0.38
    if exact:
        assert shares == [pytest.approx(0.05, abs=0.03), pytest.approx(0.3, abs=0.08)]


@pytest.mark.parametrize(("bursts", "found"), [(1, False), (3, True)], ids=["one", "three"])
def test_a_burst_that_one_cluster_holds_is_chance_and_three_alike_are_none(bursts: int, found: bool) -> None:
    """A limit acts for a second of a drive, and nearly nothing tells it in all other seconds."""
    rng, clusters = np.random.default_rng(5), np.arange(CLUSTERS)
    columns = 0.01 * rng.standard_normal((CLUSTERS, 1))
    columns[:bursts] = 20.0
    noise = rng.standard_normal(CLUSTERS)
    noise[:bursts] *= 0.5
    assert (distance(columns, noise, 1.0, [0]).chance(clusters) < 1e-5) is found


@pytest.mark.parametrize("chance", [1e-4, 0.05])
def test_a_parameter_of_the_size_that_a_chance_asks_for_has_that_chance(chance: float) -> None:
    rng, clusters = np.random.default_rng(7), np.repeat(np.arange(CLUSTERS), 3)
    columns = rng.standard_normal((len(clusters), 2))
    none = distance(columns, rng.standard_normal(len(clusters)), 0.0, [0, 1])
    none = replace(none, gradient=none.gradient + none.curvature @ -none.away, away=torch.zeros(2, dtype=torch.float64))
    for place, size in enumerate(none.sizes_at(chance, clusters)):
        away = torch.zeros(2, dtype=torch.float64)
        away[place] = size
        there = replace(none, away=away, gradient=none.gradient + none.curvature @ away)
        assert there.chance(clusters) == pytest.approx(chance, rel=1e-6)
    assert none.sizes_at(chance, np.arange(len(clusters)) % 2).isinf().all()


@pytest.mark.parametrize("by", ["blocks", "logs"])
def test_the_part_of_an_effect_that_is_there_is_as_sure_as_its_parameter(by: str) -> None:
    """A mass beside a wind, by its value, and by the line between both predictions, as if it had no null."""
    base, data = CRAZYFLIE.nominal(), flights_with_all({"added_mass": {"value": 1e-4}}, count=8)
    library = Library.of(base, [effect(key, base) for key in ("added_mass", "wind")])
    problems, (mass, wind) = weighed_problems(library, data), candidates(library, data)
    (fit,) = problems.fit([Hypothesis((*mass.free, *wind.free), library.null)])
    clusters = problems.blocks if by == "blocks" else problems.logs
    by_value, by_part = (
        Distance.of(problems, fit, candidate, library.null).chance(clusters)
        for candidate in (mass, replace(mass, needs_start=True))
    )
    assert 0.0 < by_value < 0.1
    assert np.log(by_part) == pytest.approx(np.log(by_value), rel=0.02)


def test_of_one_parameter_the_test_is_student_s_and_of_few_clusters_none_is_made() -> None:
    spread = torch.tensor([[0.25]], dtype=torch.float64)
    for count in (3, 12):
        expected = 2 * stats.t.sf(1.4 / 0.5, count - 1)
        assert chance_of(torch.tensor([-1.4], dtype=torch.float64), spread, count) == pytest.approx(expected)
    two = torch.full((2,), 100.0, dtype=torch.float64)
    assert chance_of(two, torch.eye(2, dtype=torch.float64), 3) == 1.0
    assert chance_of(two, torch.eye(2, dtype=torch.float64), 4) < 1.0


@pytest.mark.parametrize("correlation", [0.0, 0.6, 0.999])
def test_what_two_parameters_share_widens_both_intervals(correlation: float) -> None:
    curvature = torch.tensor([[4.0, 2.0 * correlation], [2.0 * correlation, 1.0]], dtype=torch.float64)
    assert inflation(curvature).tolist() == pytest.approx([(1 - correlation**2) ** -0.5] * 2)
    beside = Candidate("one", (0,)), Candidate("other", (1,))
    fit = Fit((0, 1), (), torch.zeros(2), torch.zeros(1), torch.zeros(1, 2), curvature[None])
    assert [collinear(fit, one) for one in beside] == [correlation > 0.99] * 2


@cache
def flown(logs: int, steps: int = 220) -> tuple[Problems, Candidate]:
    """Healthy flights, and a mass that may be there."""
    base, data = CRAZYFLIE.nominal(), flights_with_all({}, count=logs, steps=steps)
    library = Library.of(base, [effect("added_mass", base)])
    return weighed_problems(library, data), candidates(library, data)[0]


def with_size(problems: Problems, size: float) -> Fit:
    """The fit of a mass, were it so large, in units of its scale."""
    (fit,) = problems.quadratics([Hypothesis((0,), problems.library.null)])
    away = torch.tensor([size], dtype=torch.float64)
    values = problems.library.null + away * problems.library.scale
    return replace(fit, values=values, gradient=fit.gradient + fit.curvature @ away)


@pytest.mark.parametrize("logs", [4, 8])
def test_an_effect_is_beyond_chance_from_the_size_on_that_is_announced(logs: int) -> None:
    """By blocks, and by whole logs where these are not few; by the trim of logs where these are not few."""
    problems, mass = flown(logs)
    by_blocks, by_trim = (float(size) for size in sizes_beyond_chance(problems, with_size(problems, 0.0), 20))
    for factor, found in ((0.97, False), (1.03, True)):
        asked = mass, problems.library.null, 20
        assert beyond_chance(problems, with_size(problems, factor * by_blocks), *asked) is found
        if logs == 8:
            assert beyond_trim(problems, with_size(problems, factor * by_trim), *asked) is found
    assert (by_trim == float("inf")) is (logs == 4)
    assert not beyond_trim(flown(4)[0], with_size(flown(4)[0], 1e6), mass, problems.library.null, 20)


def test_of_few_pieces_nobody_can_say_what_is_chance() -> None:
    problems, mass = flown(1, 150)
    assert problems.block_count < 10
    assert beyond_chance(problems, with_size(problems, 0.0), mass, problems.library.null, 20)
    assert float(sizes_beyond_chance(problems, with_size(problems, 0.0), 20)[0]) == 0.0


def test_what_half_of_eight_logs_show_is_no_effect_however_many_pieces_show_it() -> None:
    """A trim of these runs; of four logs nobody could say so."""
    problems, mass = flown(8)
    (fit,) = problems.quadratics([Hypothesis((0,), problems.library.null)])
    rng, own = np.random.default_rng(0), torch.as_tensor(problems.logs % 8 < 4)
    pulled = torch.where(own, 1.0, 0.0)[:, None] + 0.001 * torch.as_tensor(rng.standard_normal((len(own), 1)))
    size = (fit.curvature[:, 0] * pulled).sum() / fit.curvature.sum()
    gradient = fit.curvature[:, 0] * (size - pulled)
    values = problems.library.null + size * problems.library.scale
    shown = replace(fit, values=values, gradient=gradient)
    assert not beyond_chance(problems, shown, mass, problems.library.null, 1)
    few = replace(problems, problem=copy(problems.problem))
    few.problem.segments = replace(few.problem.segments, log=problems.logs % 4)
    assert beyond_chance(few, shown, mass, problems.library.null, 1)


def test_a_sum_is_as_unsure_as_its_blocks_scatter_and_of_one_block_nobody_knows() -> None:
    problems, _ = flown(8)
    by_block = torch.as_tensor(np.random.default_rng(0).standard_normal(problems.block_count))
    first = np.unique(problems.blocks, return_index=True)[1]
    difference = torch.zeros(len(problems.blocks), dtype=torch.float64)
    difference[first] = by_block
    expected = float(by_block.numpy().std(ddof=1)) * problems.block_count**0.5
    assert standard_error(problems, difference) == pytest.approx(expected)
    single = replace(problems, problem=copy(problems.problem))
    single.problem.segments = problems.problem.segments.of(torch.tensor([0]))
    assert standard_error(single, difference[:1]) == float("inf")


def test_an_interval_is_student_s_on_blocks_and_no_narrower_than_on_logs() -> None:
    for logs in (4, 8):
        problems, _ = flown(logs)
        fit = with_size(problems, 0.0)
        (step,) = solve(fit.curvature.sum(0), -fit.gradient.sum(0))
        at_best = replace(fit, gradient=fit.gradient + fit.curvature[:, 0] * step)
        scores = np.bincount(problems.blocks, at_best.gradient[:, 0])
        error = float(scores.std(ddof=1)) * len(scores) ** 0.5 / float(fit.curvature.sum())
        by_blocks = error * float(stats.t.ppf(0.975, len(scores) - 1))
        half = float(half_widths(problems, at_best))
        assert half == pytest.approx(by_blocks) if logs == 4 else half >= by_blocks * (1 - 1e-9)


def test_an_effect_that_moves_few_directions_needs_their_part_of_the_gain() -> None:
    """A mass pushes along the thrust: one direction of nine, and a little of those that follow."""
    for logs in (4, 8):
        problems, mass = flown(logs)
        gain = least_gain(problems, mass, problems.library.null, 2)
        assert SETTINGS.gain_of(2) / 9 <= gain < SETTINGS.gain_of(2) / 3
    problems, mass = flown(8)
    late = replace(mass, needs_start=True)
    assert least_gain(problems, late, problems.library.null, 1) == SETTINGS.gain_of(1)


def test_a_parameter_that_one_cluster_alone_tells_is_none_without_that_cluster() -> None:
    """So n values, all alike but one that is none: their jackknife has one deviation, n/(n - 1) times as small."""
    columns = np.zeros((CLUSTERS, 1))
    columns[0] = 3.0
    noise = 0.1 * np.random.default_rng(0).standard_normal(CLUSTERS)
    chance = distance(columns, noise, 1.0, [0]).chance(np.arange(CLUSTERS))
    assert chance == pytest.approx(2 * stats.t.sf(CLUSTERS / (CLUSTERS - 1), CLUSTERS - 1))
