"""Covariance of what is left: recovered from draws of it, and not by pieces in which something odd happens."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import torch
from scipy import stats
from standard_set import Case, simulate_case
from torch import Tensor

from sym2real.diagnosis.estimate.whitening import PIECES, TAILS, Spread, Whitening, estimate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import effect
from sym2real.robots import CRAZYFLIE

SEGMENTS, ROWS, COMPONENTS, SENSOR, PUSH = 60, 25, 3, 0.002, 0.4


@pytest.fixture
def spread() -> Spread:
    """One push that is integrated twice into every component, and a start with position and velocity."""
    time = torch.arange(ROWS, dtype=torch.float64) * 0.02
    eye = torch.eye(COMPONENTS, dtype=torch.float64)
    start = torch.cat([torch.kron(torch.ones(ROWS, 1), eye), torch.kron(time[:, None], eye)], dim=1)
    edges = torch.linspace(0, float(time[-1]), PIECES + 1, dtype=torch.float64)
    after = [(time[:, None] - edge).clamp_min(0) ** 2 / 2 for edge in edges]
    pieces = torch.cat([a - b for a, b in pairwise(after)], dim=1)  # (ROWS, PIECES)
    pushes = torch.einsum("tp,cd->tcdp", pieces, eye).reshape(ROWS * COMPONENTS, COMPONENTS, PIECES)
    return Spread(
        start=start.double().expand(SEGMENTS, -1, -1),
        disturbances=pushes.expand(SEGMENTS, -1, -1, -1),
        names=("fx", "fy", "fz"),
        sizes=torch.ones(COMPONENTS, dtype=torch.float64),
        components=COMPONENTS,
    )


def drawn(spread: Spread, seed: int) -> Tensor:
    """Residuals of the model that the covariance describes ``# (S, R)``."""
    rng = np.random.default_rng(seed)
    start = torch.as_tensor(rng.standard_normal((SEGMENTS, spread.start.shape[-1]))) * 0.1
    push = torch.as_tensor(rng.standard_normal((SEGMENTS, COMPONENTS * PIECES))) * PUSH
    noise = torch.as_tensor(rng.standard_normal((SEGMENTS, ROWS * COMPONENTS))) * SENSOR
    moved = torch.einsum("srn,sn->sr", spread.start, start)
    return moved + torch.einsum("srp,sp->sr", spread.disturbances.flatten(-2), push) + noise


def estimated(spread: Spread, residuals: Tensor) -> Whitening:
    return estimate(spread, residuals, np.full(COMPONENTS, 0.001), (0, 0, 0))


def test_variances_are_recovered_and_every_piece_of_gaussian_data_is_trusted(spread: Spread) -> None:
    for seed in range(5):
        residuals = drawn(spread, seed)
        found = estimated(spread, residuals)
        assert found.sensor.tolist() == pytest.approx([SENSOR] * COMPONENTS, rel=0.05)
        assert list(found.disturbances.values()) == pytest.approx([PUSH] * COMPONENTS, rel=0.25)
        assert bool((found.trust == 1).all())
        assert float(found.loss(residuals[None]).sum()) == pytest.approx(found.freedom, rel=0.05)


def test_few_odd_pieces_are_trusted_less_and_do_not_raise_the_variances(spread: Spread) -> None:
    residuals = drawn(spread, 0)
    odd = torch.arange(0, SEGMENTS, 10)
    residuals[odd] *= 8.0
    found = estimated(spread, residuals)
    others = torch.ones(SEGMENTS, dtype=torch.bool)
    others[odd] = False
    assert float(found.trust[odd].max()) < 0.2
    assert float(found.trust[others].min()) > 0.5
    assert found.sensor.tolist() == pytest.approx([SENSOR] * COMPONENTS, rel=0.2)
    assert found.products(residuals[..., None])[:, 0, 0].tolist() == pytest.approx(
        found.loss(residuals[None])[0].tolist()
    )


def test_odd_pieces_do_not_decide_and_are_seen_all_the_same(spread: Spread) -> None:
    """A tenth of the pieces eight times as far off: what is left is 0.9 + 0.1 · 64 times noise and disturbances."""
    residuals = drawn(spread, 0)
    residuals[::10] *= 8.0
    found = estimated(spread, residuals)
    assert float(found.loss(residuals[None]).sum()) < 1.5 * found.freedom
    assert found.misfit(residuals) == pytest.approx(7.3, rel=0.2)


def test_equations_whose_sensors_err_by_known_values_make_a_problem() -> None:
    """A finding put into equations leaves an output without a parameter."""
    tilted = effect("mounting_tilt", CRAZYFLIE).substitute(CRAZYFLIE.nominal(), {"roll": 0.02})
    data = simulate_case(Case("crazyflie", (), 1), 1, 100)
    problem = Problem(Library.of(tilted, []), data)
    residuals = problem.residuals(torch.zeros(1, 0, dtype=torch.float64))
    assert bool(residuals.isfinite().all())


def test_the_deviance_is_that_of_the_normal_distribution_with_this_covariance(spread: Spread) -> None:
    few = replace(spread, start=spread.start[:3], disturbances=spread.disturbances[:3])
    whitening = few.whitening(
        torch.full((COMPONENTS,), SENSOR**2).double(), torch.full((COMPONENTS,), PUSH**2).double()
    )
    trust = torch.tensor([1.0, 0.5, 2.0], dtype=torch.float64)
    whitening, residuals = replace(whitening, trust=trust), drawn(spread, 1)[:3]
    columns = torch.cat([few.start, few.disturbances.flatten(-2) * PUSH], dim=-1)[0]
    covariance = (columns @ columns.T).numpy() + SENSOR**2 * np.eye(len(columns))
    expected = sum(
        -2 * stats.multivariate_normal(cov=covariance / float(factor)).logpdf(residual)
        for factor, residual in zip(trust, residuals.numpy(), strict=True)
    )
    constant = residuals.numel() * math.log(2 * math.pi)
    assert whitening.deviance(residuals) + constant == pytest.approx(expected, rel=1e-6)


def test_moves_have_as_many_directions_however_the_axes_lie(spread: Spread) -> None:
    whitening = estimated(spread, drawn(spread, 0))
    rng = np.random.default_rng(1)
    along = torch.as_tensor(rng.standard_normal((SEGMENTS, ROWS, 1, 1)))
    turned, _ = np.linalg.qr(rng.standard_normal((COMPONENTS, COMPONENTS)))
    for axes in (np.eye(COMPONENTS), turned):
        for directions in range(1, COMPONENTS + 1):
            moves = (along * torch.as_tensor(axes[:, :directions])).flatten(1, 2)
            assert whitening.directions(moves) == pytest.approx(directions / COMPONENTS, rel=0.02)


@pytest.mark.parametrize("degrees", [3.0, 8.0, 40.0, math.inf])
def test_pieces_are_trusted_as_the_likeliest_of_student_s_distributions_says(spread: Spread, degrees: float) -> None:
    """Squares of n components, by n, have Fisher's distribution with n and ν, unless tails are not clearly heavy."""
    rng = np.random.default_rng(int(min(degrees, 99.0)))
    factor = np.ones(SEGMENTS) if math.isinf(degrees) else rng.chisquare(degrees, SEGMENTS) / degrees
    residuals = drawn(spread, 4) / torch.as_tensor(factor).sqrt()[:, None]
    found = estimated(spread, residuals)
    plain = replace(found, trust=torch.ones_like(found.trust))
    squares, size = plain.loss(residuals[None])[0].numpy(), found.freedom / SEGMENTS
    likely = {nu: stats.f.logpdf(squares / size, size, nu).sum() - SEGMENTS * math.log(size) for nu in TAILS}
    nu = max(likely, key=likely.__getitem__)
    heavy = 2 * (likely[nu] - stats.chi2.logpdf(squares, size).sum()) >= SETTINGS.heavy_tails
    assert bool(heavy) is not math.isinf(degrees)
    expected = (nu + size) / (nu + squares) if heavy else np.ones(SEGMENTS)
    np.testing.assert_allclose(found.trust.numpy(), expected, rtol=1e-6)


def test_tails_compete_from_the_heaviest_that_have_a_variance_to_hardly_heavy_ones() -> None:
    """Between neighbours no more than twice as many degrees of freedom."""
    assert TAILS[0] <= 3.0
    assert TAILS[-1] >= 80.0
    assert all(1.0 < more / less <= 2.0 for less, more in pairwise(TAILS))
