"""Particles of an ensemble: their moments are those of the mixture, worked out by hand for linear members."""

from __future__ import annotations

import math

import pytest
import torch

from sym2real.errors import ShapeError
from sym2real.layout import Layout, Layouts
from sym2real.neural import Ensemble, particle_rollouts
from sym2real.neural.particles import Scheme
from sym2real.robots import CRAZYFLIE

LAYOUTS = Layouts(Layout.of(["x"]), Layout.of(["u"]))
SLOPE, PUSHES, DEVIATION, SCALE = -0.3, (0.5, -0.1, 0.2), 0.2, 2.0
STEPS = 5


def linear() -> Ensemble:
    """Members that say x' = x + SCALE·(SLOPE·x + push + u) and the same deviation; relu(x) - relu(-x) is x."""
    ensemble = Ensemble(LAYOUTS, len(PUSHES), (4,), probabilistic=True)
    (first, _), (last, bias) = ensemble.networks.pairs()
    with torch.no_grad():
        ensemble.output_scale.fill_(SCALE)
        ensemble.lowest.fill_(-20.0)
        ensemble.highest.fill_(20.0)
        first.copy_(torch.tensor([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]]))
        last.copy_(torch.tensor([[SLOPE, 0.0], [-SLOPE, 0.0], [1.0, 0.0], [-1.0, 0.0]]))
        bias[:, 0, 0] = torch.tensor(PUSHES)
        bias[:, 0, 1] = 2.0 * math.log(DEVIATION)
    return ensemble


def expected(scheme: Scheme, start: float, command: float) -> tuple[float, float]:
    """Mean and variance of the mixture after the last step."""
    pull, noise = 1.0 + SCALE * SLOPE, (SCALE * DEVIATION) ** 2
    pushes = SCALE * (torch.tensor(PUSHES, dtype=torch.float64) + command)
    apart = float(pushes.var(unbiased=False)) if scheme == "TS1" else 0.0
    means, variance = torch.full((len(PUSHES),), start, dtype=torch.float64), 0.0
    for _ in range(STEPS):
        means = pull * means + (pushes.mean() if scheme == "TS1" else pushes)
        variance = pull**2 * variance + noise + apart
    return float(means.mean()), variance + float(means.var(unbiased=False))


@pytest.mark.parametrize("scheme", ["TSinf", "TS1"])
def test_moments_are_those_of_the_mixture(scheme: Scheme) -> None:
    count, starts = 60_000, (0.7, -1.5)
    actions = torch.full((2, STEPS, 1), 0.1)
    found = particle_rollouts(linear(), torch.tensor(starts)[:, None], actions, count, scheme=scheme, seed=3)
    assert found.shape == (count, 2, STEPS, 1)
    for place, start in enumerate(starts):
        mean, variance = expected(scheme, start, 0.1)
        last = found[:, place, -1, 0].double()
        assert float(last.mean()) == pytest.approx(mean, abs=5 * math.sqrt(variance / count))
        assert float(last.var()) == pytest.approx(variance, rel=5 * math.sqrt(2 / count))
    assert expected("TSinf", 0.7, 0.1)[1] > 1.1 * expected("TS1", 0.7, 0.1)[1]


def test_a_seed_gives_the_same_particles_and_another_others() -> None:
    ensemble = linear()
    start, actions = torch.tensor([0.3]), torch.zeros(STEPS, 1)
    first, again, other = (
        particle_rollouts(ensemble, start, actions, 6, scheme="TS1", seed=seed) for seed in (1, 1, 2)
    )
    assert torch.equal(first, again)
    assert not torch.equal(first, other)


def test_particles_of_a_deterministic_ensemble_are_its_members() -> None:
    """One step from one state: particle and member are the same, and their mean is the ensemble's prediction."""
    ensemble = Ensemble(CRAZYFLIE.layouts, 3, (8,), seed=2)
    state = CRAZYFLIE.layouts.state.normalise(torch.rand(4, 13, dtype=torch.float64, generator=torch.manual_seed(0)))
    state, action = state.float(), torch.full((4, 1, 4), 0.1)
    found = particle_rollouts(ensemble, state, action, 3)[:, :, 0]
    members = ensemble.manifold(state + ensemble.members(state, action[:, 0]))
    torch.testing.assert_close(found, members.detach())
    torch.testing.assert_close(found[..., 3:7].norm(dim=-1), torch.ones(3, 4))


def test_what_members_cannot_share_is_refused() -> None:
    with pytest.raises(ShapeError, match="a multiple of the 3 members as the number of particles, found 20"):
        particle_rollouts(linear(), torch.zeros(1), torch.zeros(STEPS, 1), 20)
    with pytest.raises(ShapeError, match="TSinf or TS1, found 'TS2'"):
        particle_rollouts(linear(), torch.zeros(1), torch.zeros(STEPS, 1), 6, scheme="TS2")  # type: ignore[arg-type]
