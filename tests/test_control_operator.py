"""The fused step as a torch operator: from scripts, with what it refuses, and gone with its controller."""

from __future__ import annotations

import gc

import numpy as np
import pytest
import torch
from reference_models import late, motor_lagged

from sym2real.control import MPPI, operator
from sym2real.control.plan import shift
from sym2real.effects.filters import FilterState
from sym2real.errors import ShapeError, UnknownNameError
from sym2real.native import find_compiler
from sym2real.neural import Composed, ResidualMLP
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import compile_model
from sym2real.tasks import make_task

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def car() -> MPPI:
    return MPPI(compile_model(MUSHR.nominal()), MUSHR, make_task("circle", MUSHR), backend="c")


def given(mppi: MPPI) -> tuple[torch.Tensor, ...]:
    robot = mppi.robot
    reference = mppi._torch.reference(0).contiguous()
    inputs = torch.zeros(len(mppi.model.equations.layouts.inputs))
    return torch.tensor(robot.start).float(), inputs, reference, mppi.mean.clone()


def test_scripts_plan_with_it_as_the_controller_does() -> None:
    mppi = car()

    @torch.jit.script
    def act(kernel: str, state: torch.Tensor, rest: list[torch.Tensor]) -> torch.Tensor:
        mean = rest[2]
        for call in range(3):
            mean = torch.ops.sym2real.plan(kernel, state, rest[0], rest[1], mean, 0, 0, 1 + call)[0]
        return mean

    state, *rest = given(mppi)
    found = act(mppi.kernel, state, rest)
    for _ in range(3):
        mppi.act(MUSHR.start, 0)
    torch.testing.assert_close(found, mppi.mean, rtol=0, atol=0)


def test_it_changes_nothing_that_it_is_given() -> None:
    mppi = car()
    operands = given(mppi)
    before = [tensor.clone() for tensor in operands]
    mean, costs, _ = torch.ops.sym2real.plan(mppi.kernel, *operands, 2, 0, 1)
    kept = mean.clone(), costs.clone()
    torch.ops.sym2real.plan(mppi.kernel, *operands, 0, 0, 2)
    for now, then in zip((*operands, mean, costs), (*before, *kept), strict=True):
        torch.testing.assert_close(now, then, rtol=0, atol=0)


def test_what_does_not_fit_is_refused() -> None:
    mppi = car()
    state, inputs, reference, mean = given(mppi)
    plan = torch.ops.sym2real.plan
    with pytest.raises(UnknownNameError, match="unknown kernel 'plan x'"):
        plan("plan x", state, inputs, reference, mean, 0, 0, 1)
    with pytest.raises(ShapeError, match=r"state: expected the shape \(7,\), found \(6,\)"):
        plan(mppi.kernel, state[:6], inputs, reference, mean, 0, 0, 1)
    with pytest.raises(ShapeError, match=r"mean: expected contiguous torch.float32 on cpu, found torch.float64"):
        plan(mppi.kernel, state, inputs, reference, mean.double(), 0, 0, 1)
    with pytest.raises(ShapeError, match="strided"):
        plan(mppi.kernel, state, inputs, reference.T.contiguous().T, mean, 0, 0, 1)


def test_what_was_sent_is_known_to_filters_and_network_alike() -> None:
    model = Composed(late(), ResidualMLP(MUSHR.layouts, (8,), commands=2))
    mppi = MPPI(model, MUSHR, make_task("circle", MUSHR), backend="c", filters=FilterState(model.equations))
    mppi.remember(MUSHR.rest)
    operands = (mppi.kernel, *given(mppi), 0, 0, 1, None)
    memory, past = mppi._gone_by.memory(), mppi._gone_by.past(MUSHR.start)
    torch.ops.sym2real.plan(*operands, memory, past)
    with pytest.raises(ShapeError, match="expected both"):
        torch.ops.sym2real.plan(*operands, memory)
    with pytest.raises(ShapeError, match=r"past: expected the shape \(4,\), found \(3,\)"):
        torch.ops.sym2real.plan(*operands, memory, past[:3])


@pytest.mark.parametrize("steps", [-3, 2**31 + 5, -(2**40)])
def test_a_plan_is_shifted_by_what_there_is_of_it(steps: int) -> None:
    """Nothing beyond its ends is read, whatever a clock says."""
    mppi = car()
    state, inputs, reference, mean = given(mppi)
    mean[:, 0] = torch.linspace(-0.1, 0.1, len(mean))
    found = torch.ops.sym2real.plan(mppi.kernel, state, inputs, reference, mean, steps, 0, 1)
    wanted = torch.ops.sym2real.plan(mppi.kernel, state, inputs, reference, shift(mean, steps), 0, 0, 1)
    torch.testing.assert_close(found[0], wanted[0], rtol=0, atol=0)


def test_a_kernel_is_forgotten_with_its_controller() -> None:
    mppi = car()
    name = mppi.kernel
    assert name in operator.KERNELS
    del mppi
    gc.collect()
    assert name not in operator.KERNELS


def test_a_compiled_model_with_hidden_states_is_planned_with_on_every_back_end() -> None:
    """Its hidden thrust starts where the equations say, as in a model of the visible columns."""
    model, task = compile_model(motor_lagged()), make_task("circle", CRAZYFLIE)
    fused, slow = (MPPI(model, CRAZYFLIE, task, backend=backend) for backend in ("c", "torch"))
    fused.act(CRAZYFLIE.start, 0)
    plan = slow.improve(CRAZYFLIE.start, 0, fused._fused.noise(0, 1))
    torch.testing.assert_close(fused.plan.costs, plan.costs, rtol=2e-5, atol=1e-5)
    assert np.isfinite(fused.mean.numpy()).all()
