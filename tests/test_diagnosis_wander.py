"""Noise that goes on from row to row: its covariance, where logs show it, and that it hides nothing that is there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy import stats
from standard_set import Case, simulate_case
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.diagnosis.errors.floor import floor_of_explained
from sym2real.diagnosis.errors.rungs import HeldOut
from sym2real.diagnosis.estimate.wander import Wander
from sym2real.diagnosis.estimate.whitening import Spread, Whitening, estimate, with_wander
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.logs.noise import APART, growth
from sym2real.robots import CRAZYFLIE

STEP = 0.003  # m a row, as of an estimator's position that wanders by centimetres in a second
PLACES = slice(0, 3)


def wandering(data: Dataset, step: float = STEP) -> Dataset:
    """The logs with positions that walk at random; velocities stay what they were."""
    made = []
    for number, log in enumerate(data):
        state = log.state.copy()
        state[:, PLACES] += step * np.random.default_rng(number).standard_normal((len(log), 3)).cumsum(0)
        made.append(replace(log, state=state))
    return Dataset(made)


@pytest.fixture(scope="module")
def flights() -> Dataset:
    return simulate_case(Case("crazyflie", (), seed=3), trajectories=4, rows=300)


@pytest.fixture(scope="module")
def spread(flights: Dataset) -> Spread:
    return Spread.of(*_problem(flights))


def _problem(data: Dataset) -> tuple[Problem, Tensor]:
    library = Library.of(CRAZYFLIE.nominal(), [])
    return Problem(library, data), library.null


def _covariance(spread: Spread, whitening: Whitening, segment: int, shares: Tensor) -> Tensor:
    """The definition, entry by entry: white noise, walks, the start, disturbances."""
    length = spread.start.shape[1] // spread.components
    rows = torch.arange(1.0, length + 1, dtype=torch.float64)
    noise = torch.zeros(length, spread.components, length, spread.components, dtype=torch.float64)
    for place, (size, share) in enumerate(zip(whitening.sensor.tolist(), shares.tolist(), strict=True)):
        noise[:, place, :, place] = size**2 * (torch.eye(length) + share * torch.minimum(rows, rows[:, None]))
    deviations = torch.tensor([whitening.disturbances[name] for name in spread.names]) / spread.sizes
    disturbed = (spread.disturbances[segment] * deviations[:, None]).flatten(-2)
    columns = torch.cat([spread.start[segment], disturbed], dim=-1)
    return noise.reshape(len(columns), -1) + columns @ columns.T


def test_a_covariance_with_walks_is_inverted_as_its_definition_says(spread: Spread) -> None:
    generator, count = torch.Generator().manual_seed(0), spread.components
    shares = torch.where(torch.arange(count) < 3, 2.0, 0.0).double()
    length = spread.start.shape[1] // count
    other = replace(spread, wander=Wander(shares, length))
    variances = torch.full((count,), 1e-4).double(), torch.full((len(spread.names),), 0.3).double()
    whitening = other.whitening(*variances)
    residuals = 0.02 * torch.randn(spread.start.shape[:2], generator=generator, dtype=torch.float64)
    dense = _covariance(spread, whitening, 0, shares)
    density = stats.multivariate_normal(cov=dense.numpy())
    first, second = residuals[0], residuals[1] * 0.5
    squares = [float(row @ torch.linalg.solve(dense, row)) for row in (first, second)]
    sets = torch.stack([torch.cat([row[None], residuals[1:]]) for row in (first, second)])
    assert whitening.loss(sets)[:, 0].tolist() == pytest.approx(squares, rel=1e-6)
    both = torch.stack([first, second], dim=-1)[None].expand(len(residuals), -1, -1)
    product = both[0].T @ torch.linalg.solve(dense, both[0])
    torch.testing.assert_close(whitening.products(both)[0], product, rtol=1e-6, atol=1e-9)
    times = whitening.inverse_times(both)[0]
    torch.testing.assert_close(times, torch.linalg.solve(dense, both[0]), rtol=1e-5, atol=1e-6)
    difference = whitening.deviance(sets[1]) - whitening.deviance(sets[0])
    assert difference == pytest.approx(2 * (density.logpdf(first) - density.logpdf(second)), rel=1e-6)
    unwalked = spread.whitening(*variances)
    plain = _covariance(spread, unwalked, 0, torch.zeros(count))
    change = torch.linalg.slogdet(dense).logabsdet - torch.linalg.slogdet(plain).logabsdet
    assert Wander(shares, length).determinant > 0.0
    one = [replace(own, start=own.start[:1], disturbances=own.disturbances[:1]) for own in (other, spread)]
    still = torch.zeros(1, residuals.shape[1], dtype=torch.float64)
    walks, none = (own.whitening(*variances).deviance(still) for own in one)
    assert walks - none == pytest.approx(float(change), rel=1e-6)


def test_noise_that_walks_grows_with_the_rows_white_noise_does_not_and_motion_faster(flights: Dataset) -> None:
    noise = np.random.default_rng(1).standard_normal((300, 3))
    along = np.linspace(0.0, 3.0, 300)[:, None]
    kinds = {"white": noise, "walk": noise.cumsum(0), "motion": np.sin(along + np.arange(3))}
    grown = {}
    for name, places in kinds.items():
        logs = (replace(log, state=np.concatenate([places, log.state[:, 3:]], axis=1)) for log in flights)
        data = Dataset(logs)
        grown[name] = np.median(growth(data, APART)[PLACES])
        assert name != "walk" or np.median(growth(data, 2)[PLACES]) == pytest.approx(2.0, rel=0.2)
    assert grown["white"] == pytest.approx(1.0, rel=0.2)
    assert grown["walk"] == pytest.approx(APART, rel=0.25)
    assert grown["motion"] > 100.0


def test_a_walk_is_found_where_there_is_one_and_in_what_walks(flights: Dataset) -> None:
    for data, walks in ((flights, False), (wandering(flights), True)):
        problem, null = _problem(data)
        residuals, segments = problem.residuals(null[None])[0], problem.segments
        found = with_wander(Spread.of(problem, null), residuals, segments, data).wander
        assert found.walks == walks
        if walks:
            places = [segments.compared.index(place) for place in range(3)]
            whitening = estimate(
                replace(Spread.of(problem, null), wander=found), residuals, segments.noise, segments.channel
            )
            steps = found.shares.sqrt() * whitening.sensor
            assert steps[places].tolist() == pytest.approx([STEP] * 3, rel=0.25)
            assert found.shares.count_nonzero() == 3


def test_the_floor_rises_by_what_walks_until_the_prediction_ends(flights: Dataset) -> None:
    problem, null = _problem(flights)
    spread, segments = Spread.of(problem, null), problem.segments
    still = estimate(spread, problem.residuals(null[None])[0], segments.noise, segments.channel)
    shares = torch.where(torch.arange(spread.components) < 3, 4.0, 0.0).double()
    walking = replace(still, wander=Wander(shares, segments.length))
    horizons = (0.2, 0.8)
    held = HeldOut(problem.library, flights)
    levels = (floor_of_explained(held, null, own, horizons) for own in (still, walking))
    for before, after in zip(*levels, strict=True):
        added = after.errors["position"][0] ** 2 - before.errors["position"][0] ** 2
        assert after.noise["position"] > before.noise["position"]
        steps = before.horizon / flights.dt
        assert added == pytest.approx(4.0 * steps * float(still.sensor[:3].square().sum()), rel=1e-6)
        # A model that has been rolled out often goes to C in between, which is the same but for rounding.
        assert after.errors["attitude"][0] == pytest.approx(before.errors["attitude"][0], rel=1e-9)


@pytest.mark.slow
def test_what_an_estimator_gets_wrong_hides_no_drag_and_makes_none() -> None:
    """Walks of 3 mm a row moved the disturbances to a weight and more, beside which nothing counted."""
    drag = (("linear_drag", {"cx": 0.012, "cy": 0.012, "cz": 0.0}),)
    with_drag, healthy = (wandering(simulate_case(Case("crazyflie", effects, seed=5))) for effects in (drag, ()))
    found = diagnose(CRAZYFLIE.nominal(), with_drag)
    assert found.verdict == "EFFECT"
    assert "linear_drag" in {name for finding in found.findings[:1] for name in (finding.effect, *finding.group)}
    assert diagnose(CRAZYFLIE.nominal(), healthy).verdict == "NOTHING_MISSING"
