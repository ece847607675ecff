"""MPPI against its reference implementation, against the optimum, and at its limits."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import pytorch_mppi
import torch
from torch import Tensor

from sym2real.control import MPPI
from sym2real.control.mppi import shift
from sym2real.control.noise import deviations, sample, smoothing
from sym2real.control.plan import importance_weights
from sym2real.errors import ShapeError
from sym2real.layout import Layout, Layouts
from sym2real.robots import CRAZYFLIE, MUSHR, Limits, MPPISettings, Robot
from sym2real.symbolic import compile_model
from sym2real.symbolic.native_choice import MANY
from sym2real.tasks import Task, make_task

# A cart: position and velocity along x, an acceleration and a brake that does nothing, as actions.
CART: Robot = replace(
    CRAZYFLIE,
    name="cart",
    layouts=Layouts(Layout.of(("x", "vx")), Layout.of(("push", "brake"))),
    dt=0.1,
    limits=Limits(np.array([-2.0, -1.0]), np.array([2.0, 1.0])),
    description=replace(CRAZYFLIE.description, start=np.array([1.0, 0.0]), rest=np.zeros(2)),
    mppi=MPPISettings(samples=64, horizon=1.2, temperature=0.3, noise=(0.8, 0.4)),
)
A = torch.tensor([[1.0, 0.1], [0.0, 1.0]], dtype=torch.float64)
B = torch.tensor([[0.005, 0.0], [0.1, 0.0]], dtype=torch.float64)
Q, R = torch.diag(torch.tensor([1.0, 0.2])).double(), torch.diag(torch.tensor([0.1, 0.1])).double()


def linear(state: Tensor, action: Tensor) -> Tensor:
    return state @ A.T.to(state) + action @ B.T.to(state)


def pendulum(state: Tensor, action: Tensor) -> Tensor:
    push = action[..., 0] - 2.0 * torch.sin(state[..., 0])
    return torch.stack([state[..., 0] + 0.1 * state[..., 1], state[..., 1] + 0.1 * push], dim=-1)


def expected_states(mppi: MPPI, state: np.ndarray) -> Tensor:
    """Rollout ``# (H, state)`` of the mean: the one candidate of a step without noise, which leaves the mean."""
    return mppi.improve(state, 0, torch.zeros_like(mppi.mean)[None]).states[0]


def quadratic(state: Tensor, action: Tensor, reference: Tensor) -> Tensor:
    error = state - reference
    return ((error @ Q.to(error)) * error).sum(-1) + ((action @ R.to(action)) * action).sum(-1)


def cart_task(reference: Callable[[Tensor], Tensor] | None = None) -> Task:
    rest = lambda at: torch.zeros(*at.shape, 2, dtype=at.dtype)  # noqa: E731
    return Task("cart", reference or rest, quadratic, lambda rng: CART.start, 5.0)


def cart_mppi(model: object = linear, **options: object) -> MPPI:
    settings = replace(CART.mppi, **options.pop("settings", {}))
    return MPPI(model, CART, options.pop("task", cart_task()), settings=settings, dtype=torch.float64, **options)


def test_agrees_with_pytorch_mppi_on_the_same_noise() -> None:
    covariance = torch.diag(torch.tensor([0.64, 0.16])).double()
    mine = cart_mppi(pendulum)
    zero = torch.zeros(2, dtype=torch.float64)
    theirs = pytorch_mppi.MPPI(
        pendulum, lambda state, action: quadratic(state, action, zero), 2, covariance,
        num_samples=64, horizon=12, lambda_=0.3, u_min=torch.tensor(CART.low), u_max=torch.tensor(CART.high),
        U_init=torch.zeros(12, 2, dtype=torch.float64),
    )  # fmt: skip
    theirs._compute_action_cost = torch.zeros_like  # a price of noise, which ours has not
    generator = torch.Generator().manual_seed(5)
    state = np.array([2.0, -0.5])
    for _ in range(4):
        noise = torch.randn(64, 12, 2, generator=generator, dtype=torch.float64) * 1.5
        theirs._sample_noise = lambda shape, noise=noise: noise
        theirs.command(torch.from_numpy(state), shift_nominal_trajectory=False)
        plan = mine.improve(state, 0, noise)
        torch.testing.assert_close(plan.costs, theirs.cost_total)
        torch.testing.assert_close(plan.weights, theirs.omega)
        torch.testing.assert_close(mine.mean, theirs.U)
    assert float(mine.mean.abs().max()) > 0.5


def finite_horizon_optimum(start: Tensor, steps: int) -> tuple[Tensor, float]:
    """First action and cost of min Σ s_h+1' Q s_h+1 + a_h' R a_h by the Riccati recursion."""
    value = torch.zeros(2, 2, dtype=torch.float64)
    for _ in range(steps):
        ahead = Q + value
        gain = torch.linalg.solve(R + B.T @ ahead @ B, B.T @ ahead @ A)
        value = A.T @ ahead @ (A - B @ gain)
    return -gain @ start, float(start @ value @ start)


def test_comes_near_the_optimum_of_a_linear_quadratic_problem() -> None:
    wide = CART.within(np.full(2, -50.0), np.full(2, 50.0))
    settings = MPPISettings(samples=512, horizon=1.2, temperature=0.01, noise=(0.25, 0.25), correlation=0.3)
    mppi = MPPI(linear, wide, cart_task(), settings=settings, dtype=torch.float64)
    start = np.array([0.6, 0.3])
    for _ in range(60):
        action = mppi.act(start, 0)  # the same step again: the plan is refined
    best_action, best_cost = finite_horizon_optimum(torch.from_numpy(start), mppi.horizon)
    states = expected_states(mppi, start)
    cost = float(quadratic(states, mppi.mean, torch.zeros(2, dtype=torch.float64)).sum())
    assert best_cost <= cost < 1.02 * best_cost
    np.testing.assert_allclose(action, best_action.numpy(), atol=0.1 * float(best_action.abs().max()))


def test_limits_are_never_left() -> None:
    mppi = cart_mppi(settings={"noise": (30.0, 30.0)}, task=cart_task(lambda at: 100 * torch.ones(*at.shape, 2)))
    state = CART.start
    for step in range(10):
        action = mppi.act(state, step)
        for values in (action, mppi.plan.actions.numpy().reshape(-1, 2), mppi.mean.numpy()):
            assert (values >= CART.low).all() and (values <= CART.high).all()
    assert action[0] > 1.5


def test_single_precision_does_not_leave_the_limits_either() -> None:
    robot = CART.within(np.array([-0.1, -0.1]), np.array([0.1, 0.1]))  # 0.1 rounds up in float32
    far = cart_task(lambda at: 100 * torch.ones(*at.shape, 2))
    mppi = MPPI(linear, robot, far, settings=replace(CART.mppi, noise=(30.0, 0.1)))
    assert max(mppi.act(CART.start, step)[0] for step in range(5)) <= 0.1


def test_non_finite_rollouts_have_no_influence_and_are_counted() -> None:
    def explodes(state: Tensor, action: Tensor) -> Tensor:
        return torch.where(action[..., :1] > 0.9, torch.nan, linear(state, action))

    noise = sample(64, *(cart_mppi()._smooth, cart_mppi()._spread), torch.Generator().manual_seed(0))
    bad = (noise[..., 0] > 0.9).any(-1)
    broken, clean = cart_mppi(explodes), cart_mppi()
    plan = broken.improve(CART.start, 0, noise)
    clean.improve(CART.start, 0, noise[~bad])
    assert plan.rejected == int(bad.sum()) > 5
    assert (plan.weights[bad] == 0).all()
    torch.testing.assert_close(broken.mean, clean.mean)
    assert plan.states[plan.costs.isfinite()].isfinite().all()


@pytest.mark.parametrize("value", [torch.nan, torch.inf, -torch.inf])
def test_a_cost_that_is_not_finite_counts_as_a_rollout_that_is_not(value: float) -> None:
    task = replace(cart_task(), cost=lambda s, a, r: torch.where(a[..., 0] > 0.5, value, quadratic(s, a, r)))
    mppi = cart_mppi(task=task)
    mppi.act(CART.start, 0)
    assert 0 < mppi.plan.rejected < 64
    assert mppi.plan.weights.isfinite().all()
    assert (mppi.plan.weights[~mppi.plan.costs.isfinite()] == 0).all()


def test_goes_on_with_the_last_plan_when_no_rollout_is_finite(caplog: pytest.LogCaptureFixture) -> None:
    broken = False

    def model(state: Tensor, action: Tensor) -> Tensor:
        return linear(state, action) * (torch.nan if broken else 1.0)

    mppi = cart_mppi(model)
    mppi.act(CART.start, 0)
    expected = shift(mppi.mean, 1)
    broken = True
    with caplog.at_level(logging.WARNING):
        action = mppi.act(CART.start, 1)
    np.testing.assert_array_equal(action, expected[0].numpy())
    assert mppi.plan.rejected == 64
    assert "step 1" in caplog.text


def test_same_seed_same_actions() -> None:
    runs = {}
    for name, seed in {"first": 1, "again": 1, "other": 2}.items():
        mppi = cart_mppi(seed=seed)
        torch.manual_seed(hash(name) % 1000)  # the global generator plays no part
        runs[name] = np.array([mppi.act(CART.start, step) for step in range(3)])
        mppi.reset()
        np.testing.assert_array_equal(mppi.act(CART.start, 0), runs[name][0])
    np.testing.assert_array_equal(runs["first"], runs["again"])
    assert not np.array_equal(runs["first"], runs["other"])


def test_plan_is_shifted_by_the_steps_that_went_by() -> None:
    mppi = cart_mppi(settings={"noise": (0.0, 0.0)})
    plan = torch.linspace(-1, 1, 12, dtype=torch.float64)[:, None].repeat(1, 2)
    mppi.mean = plan
    first, refined, later = (mppi.act(CART.start, step) for step in (4, 4, 7))
    np.testing.assert_allclose(first, plan[0])
    np.testing.assert_allclose(refined, plan[0])
    np.testing.assert_allclose(later, plan[3])
    torch.testing.assert_close(mppi.mean, torch.cat([plan[3:], plan[-1:].repeat(3, 1)]))
    np.testing.assert_allclose(mppi.act(CART.start, 1000), plan[-1])


def test_temperature_goes_from_the_best_sample_to_the_average() -> None:
    noise = 0.3 * torch.randn(64, 12, 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    cold, hot = cart_mppi(settings={"temperature": 1e-9}), cart_mppi(settings={"temperature": 1e9})
    plan = cold.improve(CART.start, 0, noise)
    torch.testing.assert_close(cold.mean, plan.actions[plan.costs.argmin()])
    torch.testing.assert_close(expected_states(cold, CART.start), plan.states[plan.costs.argmin()])
    plan = hot.improve(CART.start, 0, noise)
    torch.testing.assert_close(hot.mean, plan.actions.mean(0), atol=1e-6, rtol=0)


def test_weights_know_only_differences_of_cost() -> None:
    costs = torch.tensor([3.0, 1.0, 2.0, 1.5], dtype=torch.float64)
    weights = importance_weights(costs, 0.7)
    torch.testing.assert_close(importance_weights(costs + 1e6, 0.7), weights, atol=1e-9, rtol=1e-6)
    assert float(weights.sum()) == pytest.approx(1.0)
    assert float(weights[0] / weights[1]) == pytest.approx(np.exp(-2 / 0.7))


def test_time_of_the_reference_is_the_step() -> None:
    """Step k on a reference = step 0 on the reference shifted by k dt; the cost is of the state after the action."""
    wave = lambda at: torch.stack([torch.sin(3 * at), torch.cos(3 * at)], dim=-1)  # noqa: E731
    later = cart_mppi(task=cart_task(wave)).act(CART.start, 17)
    shifted = cart_mppi(task=cart_task(lambda at: wave(at + 1.7))).act(CART.start, 0)
    np.testing.assert_allclose(later, shifted, atol=1e-9)
    seen: list[Tensor] = []
    cart_mppi(task=cart_task(lambda at: (seen.append(at), wave(at))[1])).act(CART.start, 5)
    np.testing.assert_allclose(seen[0][:12].numpy(), 0.1 * np.arange(6, 18))


def test_a_model_with_a_rollout_of_its_own_is_rolled_out_by_it() -> None:
    class Simulator:
        calls = 0

        def __call__(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
            raise AssertionError("stepped, not rolled out")

        def rollout(self, state: Tensor, actions: Tensor, inputs: object, parameters: object) -> Tensor:
            assert state.shape == (64, 2) and actions.shape == (64, 12, 2)
            Simulator.calls += 1
            states = []
            for action in actions.unbind(1):
                state = linear(state, action)
                states.append(state)
            return torch.stack(states, dim=1)

    np.testing.assert_allclose(cart_mppi(Simulator()).act(CART.start, 0), cart_mppi().act(CART.start, 0))
    assert Simulator.calls == 1


def test_torch_alone_is_torch_however_much_there_is_to_roll_out() -> None:
    """Equal bits: compiled rollouts would round differently."""
    task, equations = make_task("circle", MUSHR), MUSHR.nominal()
    mppi = MPPI(compile_model(equations), MUSHR, task, backend="torch")
    start = torch.tensor(MUSHR.start).float().expand(mppi.samples, -1)
    for step in range(MANY // (mppi.samples * mppi.horizon) + 2):
        mppi.act(MUSHR.start, step)
    expected = compile_model(equations).rollout(start, mppi.plan.actions)
    torch.testing.assert_close(mppi.plan.states, expected, rtol=0, atol=0)


class Working:
    """Rollouts that take this long a sample; it is its own clock, and nothing else takes time by it."""

    def __init__(self) -> None:
        self.work = self.worked = 0.0  # s

    def perf_counter(self) -> float:
        return self.worked

    def __call__(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        return linear(state, action)

    def rollout(self, state: Tensor, actions: Tensor, inputs: object, parameters: object) -> Tensor:
        self.worked += self.work * len(actions)
        return state[:, None].expand(-1, actions.shape[1], -1)


@pytest.fixture
def working(monkeypatch: pytest.MonkeyPatch) -> Working:
    model = Working()
    for module in ("mppi", "timing"):
        monkeypatch.setattr(f"sym2real.control.{module}.time", model)
    return model


def test_lowers_the_samples_until_the_period_holds(working: Working, caplog: pytest.LogCaptureFixture) -> None:
    working.work = 1e-4
    with caplog.at_level(logging.WARNING):
        mppi = cart_mppi(working, settings={"samples": 512}, period=0.02)  # 51 ms at 512, 12.8 at 128, 6.4 at 64
    assert mppi.samples == 64
    assert "64 samples instead of 512, to act within a period of 20.0 ms (6.4 ms an action)" in caplog.text
    mppi.act(CART.start, 0)
    assert len(mppi.plan.costs) == mppi.samples
    assert mppi.missed == 0
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        hopeless = cart_mppi(working, settings={"samples": 64}, period=1e-4)
    assert hopeless.samples == 16
    assert "not held" in caplog.text
    assert cart_mppi(working, settings={"samples": 64}, period=60.0).samples == 64


@pytest.mark.parametrize(
    ("settings", "neighbours"),
    [
        (MPPISettings(), 0.0),
        (MPPISettings(correlation=0.2), np.exp(-0.02 / 0.2)),
        (MPPISettings(knots=6), None),
    ],
)
def test_noise_has_the_size_and_the_colour_asked_for(settings: MPPISettings, neighbours: float | None) -> None:
    covariance = np.diag([0.04, 0.09])
    spread, smooth = deviations([0.2, 0.3], 2), smoothing(40, 0.02, settings)
    noise = sample(20001, smooth, spread, torch.Generator().manual_seed(0))
    assert (noise[0] == 0).all()
    for step in (0, 13, 39):
        np.testing.assert_allclose(np.cov(noise[1:, step].numpy().T), covariance, atol=0.003)
    values = noise[1:, :, 0].numpy()
    measured = np.corrcoef(values[:, 20], values[:, 21])[0, 1]
    if neighbours is None:
        assert measured > 0.9
    else:
        assert measured == pytest.approx(neighbours, abs=0.02)


def test_impossible_noise_is_refused() -> None:
    with pytest.raises(ShapeError, match="at least 0"):
        deviations([0.1, -0.2], 2)
    with pytest.raises(ShapeError, match="at least 2"):
        smoothing(10, 0.02, MPPISettings(knots=1))


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device")
def test_plans_the_same_on_a_gpu() -> None:
    noise = 0.3 * torch.randn(64, 12, 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    here, there = cart_mppi(), cart_mppi(device="cuda")
    here.improve(CART.start, 0, noise)
    there.improve(CART.start, 0, noise.cuda())
    torch.testing.assert_close(there.mean.cpu(), here.mean)
    assert there.act(CART.start, 1).shape == (2,)


def test_inputs_reach_the_models_that_take_them() -> None:
    def pushed(state: Tensor, action: Tensor, inputs: Tensor) -> Tensor:
        return linear(state, action) + 0.05 * inputs

    calm, windy = (cart_mppi(pushed).act([0.0, 0.0], 0, inputs=[0.0, wind]) for wind in (0.0, 2.0))
    assert windy[0] < calm[0] - 0.1
    np.testing.assert_array_equal(cart_mppi().act([0.0, 0.0], 0, inputs=[0.0, 2.0]), calm)
