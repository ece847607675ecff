"""Tests beyond chance: level, power, and clusters that hold all that tells a parameter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from noisy_flights import flights_with_all
from weighed_problems import weighed_problems

from sym2real.diagnosis.estimate.quadratic import Hypothesis
from sym2real.diagnosis.estimate.significance import Distance
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.effects import effect
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
