"""The running cost is eq. (5) of the paper."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.rotation import normalise
from sym2real.symbolic import compile_function
from sym2real.tasks import make_task

Array = np.ndarray


def quadrotor_cost(s: Array, r: Array, w: dict[str, float]) -> float:
    spread = 1.0 - (s[3] * r[3] + s[4] * r[4] + s[5] * r[5] + s[6] * r[6]) ** 2
    return (
        w["position"] * np.linalg.norm(s[:3] - r[:3])
        + w["orientation"] * spread
        + w["velocity"] * np.linalg.norm(s[7:10] - r[7:10])
        + w["rate"] * np.linalg.norm(s[10:] - r[10:])
    )


def car_cost(s: Array, r: Array, w: dict[str, float]) -> float:
    return (
        w["position"] * np.hypot(s[0] - r[0], s[1] - r[1])
        + w["orientation"] * (abs(s[2] - r[2]) + abs(s[3] - r[3]))
        + w["velocity"] * np.hypot(s[4] - r[4], s[5] - r[5])
        + w["rate"] * abs(s[6] - r[6])
    )


CASES = [(CRAZYFLIE, "circle", quadrotor_cost), (MUSHR, "park", car_cost)]


def compiled(robot: Robot, name: str) -> torch.nn.Module:
    states = robot.layouts.state.columns
    references = [f"ref_{column}" for column in states]
    arguments = [states, robot.layouts.action.columns, references]
    return compile_function([make_task(name, robot).cost], arguments)


@pytest.mark.parametrize(("robot", "name", "formula"), CASES)
def test_cost_is_the_formula_of_the_paper(robot: Robot, name: str, formula) -> None:
    robot_weights = {"position": 1.3, "orientation": 0.7, "velocity": 0.4, "rate": 0.2}
    generator = torch.Generator().manual_seed(0)
    shape = (30, robot.layouts.state.size)
    state, reference = (
        robot.layouts.state.normalise(torch.randn(shape, generator=generator, dtype=torch.float64)) for _ in range(2)
    )
    weighted = replace(robot, recipe=replace(robot.recipe, cost_weights=robot_weights))
    cost = compiled(weighted, name)
    action = torch.zeros(30, robot.layouts.action.size, dtype=torch.float64)
    expected = [formula(s, r, robot_weights) for s, r in zip(state.numpy(), reference.numpy(), strict=True)]
    np.testing.assert_allclose(cost(state, action, reference)[:, 0].numpy(), expected, rtol=1e-9)


@pytest.mark.parametrize(("robot", "name", "formula"), CASES)
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_cost_vanishes_on_the_reference_with_a_finite_gradient(
    robot: Robot, name: str, formula, dtype: torch.dtype
) -> None:
    reference = make_task(name, robot).reference(torch.linspace(0, 4, 9, dtype=dtype))
    state = reference.clone().requires_grad_()
    cost = compiled(robot, name)(state, torch.zeros(9, robot.layouts.action.size, dtype=dtype), reference)
    assert float(cost.detach().abs().max()) < 1e-5
    (gradient,) = torch.autograd.grad(cost.sum(), state)
    assert gradient.isfinite().all()


def test_cost_of_a_quaternion_is_the_same_with_the_other_sign() -> None:
    cost = compiled(CRAZYFLIE, "hover")
    state = torch.randn(20, 13, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    other = state.clone()
    state[:, 3:7] = normalise(state[:, 3:7])
    other[:, 3:7] = -state[:, 3:7]
    reference = torch.from_numpy(CRAZYFLIE.start)
    action = torch.zeros(20, 4, dtype=torch.float64)
    torch.testing.assert_close(cost(state, action, reference), cost(other, action, reference))


@pytest.mark.parametrize(("robot", "name", "formula"), CASES)
def test_horizons_and_samples_are_one_call(robot: Robot, name: str, formula) -> None:
    cost = compiled(robot, name)
    generator = torch.Generator().manual_seed(2)
    states = torch.randn(5, 7, robot.layouts.state.size, generator=generator, dtype=torch.float64)
    actions = torch.randn(5, 7, robot.layouts.action.size, generator=generator, dtype=torch.float64)
    references = make_task(name, robot).reference(0.1 * torch.arange(7, dtype=torch.float64))
    together = cost(states, actions, references)
    assert together.shape == (5, 7, 1)
    torch.testing.assert_close(together[3, 4], cost(states[3, 4], actions[3, 4], references[4]))
