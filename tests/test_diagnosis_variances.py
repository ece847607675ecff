"""Variances from sums over rows are those of the whole covariance, however far a base runs away from its log."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from sym2real.diagnosis.estimate.variances import LEAST, MOST, STEPS, Products, most_likely
from sym2real.logs.noise import SMALLEST_NOISE

SEGMENTS, ROWS, STARTS, PUSHES, PIECES = 6, 24, 3, 2, 4


Drawn = tuple[Tensor, Tensor, Tensor, Tensor]


def drawn(error: float) -> Drawn:
    """Sensitivities to start and pushes, residuals of this size that pushes explain but for noise, channels."""
    rng = torch.Generator().manual_seed(3)
    normal = lambda *shape: torch.randn(*shape, generator=rng, dtype=torch.float64)  # noqa: E731
    start, pushes = normal(SEGMENTS, ROWS, STARTS), normal(SEGMENTS, ROWS, PUSHES, PIECES)
    residuals = error * torch.einsum("srdp,sdp->sr", pushes, normal(SEGMENTS, PUSHES, PIECES))
    return start, pushes, residuals + 1e-3 * normal(SEGMENTS, ROWS), torch.arange(ROWS) % 2


def by_the_whole_covariance(terms: Drawn, sensor: Tensor, power: Tensor) -> tuple[Tensor, Tensor]:
    """The same steps with every segment's covariance written out and inverted."""
    start, pushes, residuals, channel = terms
    for _ in range(STEPS):
        parts = [pushes[:, :, kind] @ pushes[:, :, kind].mT for kind in range(PUSHES)]
        noise = torch.diag_embed(sensor[channel].expand(SEGMENTS, ROWS))
        inverse = torch.linalg.inv(
            noise + start @ start.mT + sum(p * part for p, part in zip(power, parts, strict=True))
        )
        weighted = (inverse @ residuals[..., None])[..., 0]
        diagonal = inverse.diagonal(dim1=1, dim2=2)
        of_channels = [weighted[:, channel == c].square().sum() / diagonal[:, channel == c].sum() for c in (0, 1)]
        of_disturbances = [
            torch.einsum("sr,srq,sq->", weighted, part, weighted) / (inverse * part).sum() for part in parts
        ]
        sensor = sensor * torch.stack(of_channels).sqrt()
        power = (power * torch.stack(of_disturbances).sqrt()).clamp(LEAST, MOST)
    return sensor, power


@pytest.mark.parametrize("error", [1e-3, 1.0, 1e4], ids=["noise alone", "disturbed", "a base that runs away"])
def test_variances_are_those_of_the_whole_covariance(error: float) -> None:
    terms = drawn(error)
    sensor, power = torch.tensor([1e-6, 1e-7], dtype=torch.float64), torch.full((PUSHES,), 0.25, dtype=torch.float64)
    found = most_likely(Products.of(*terms), sensor, power)
    expected = by_the_whole_covariance(terms, sensor, power)
    for one, other in zip(found, expected, strict=True):
        torch.testing.assert_close(one, other, rtol=1e-3, atol=0.0)


def test_what_stands_still_and_is_predicted_so_has_the_smallest_noise() -> None:
    """A goal that is two slides of a robot's file, logged as the constant that it is."""
    start, pushes, residuals, channel = drawn(1.0)
    still = channel == 1
    terms = start.clone(), pushes.clone(), residuals.clone(), channel
    for part in terms[:3]:
        part[:, still] = 0.0
    sensor, power = torch.tensor([1e-6, 1e-18], dtype=torch.float64), torch.full((PUSHES,), 0.25, dtype=torch.float64)
    variances, _ = most_likely(Products.of(*terms), sensor, power)
    assert float(variances[1]) == SMALLEST_NOISE**2
    assert 0.0 < float(variances[0]) < 1.0
