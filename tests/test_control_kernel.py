"""The fused step by itself: what it leaves alone, what it refuses."""

from __future__ import annotations

from typing import Any

import pytest
import torch
from reference_models import late

from sym2real.control import MPPI
from sym2real.control.fused_arguments import Call
from sym2real.control.plan import shift
from sym2real.effects.filters import FilterState
from sym2real.errors import ShapeError
from sym2real.native import find_compiler
from sym2real.neural import Composed, ResidualMLP
from sym2real.robots import MUSHR
from sym2real.symbolic import compile_model
from sym2real.tasks import make_task

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def car() -> MPPI:
    return MPPI(compile_model(MUSHR.nominal()), MUSHR, make_task("circle", MUSHR), backend="c")


def given(mppi: MPPI) -> tuple[torch.Tensor, ...]:
    robot = mppi.robot
    reference = mppi._torch.references.after(0)
    inputs = torch.zeros(len(mppi.model.equations.layouts.inputs))
    return torch.tensor(robot.start).float(), inputs, reference, mppi.mean.clone()


def plan(mppi: MPPI, *operands: Any) -> tuple[torch.Tensor, torch.Tensor, int]:
    return mppi._fused(Call(*operands))


def test_it_changes_nothing_that_it_is_given() -> None:
    mppi = car()
    operands = given(mppi)
    before = [tensor.clone() for tensor in operands]
    mean, costs, _ = plan(mppi, *operands, 2, 0, 1)
    kept = mean.clone(), costs.clone()
    plan(mppi, *operands, 0, 0, 2)
    for now, then in zip((*operands, mean, costs), (*before, *kept), strict=True):
        torch.testing.assert_close(now, then, rtol=0, atol=0)


def test_what_does_not_fit_is_refused() -> None:
    mppi = car()
    state, inputs, reference, mean = given(mppi)
    with pytest.raises(ShapeError, match=r"state: expected the shape \(7,\), found \(6,\)"):
        plan(mppi, state[:6], inputs, reference, mean, 0, 0, 1)
    with pytest.raises(ShapeError, match=r"mean: expected contiguous torch.float32 on cpu, found torch.float64"):
        plan(mppi, state, inputs, reference, mean.double(), 0, 0, 1)
    with pytest.raises(ShapeError, match="strided"):
        plan(mppi, state, inputs, reference.T.contiguous().T, mean, 0, 0, 1)


def test_what_was_sent_is_known_to_filters_and_network_alike() -> None:
    model = Composed(late(), ResidualMLP(MUSHR.layouts, (8,), commands=2))
    mppi = MPPI(model, MUSHR, make_task("circle", MUSHR), backend="c", filters=FilterState(model.equations))
    mppi.remember(MUSHR.rest)
    operands = (mppi, *given(mppi), 0, 0, 1, None)
    memory, past = mppi._gone_by.memory(), mppi._gone_by.past(MUSHR.start)
    plan(*operands, memory, past)
    with pytest.raises(ShapeError, match=r"past: expected the shape \(4,\), found \(3,\)"):
        plan(*operands, memory, past[:3])
    with pytest.raises(ShapeError, match=r"hidden: expected the shape \(1,\), found \(2,\)"):
        plan(*operands, memory, past, torch.zeros(2))


@pytest.mark.parametrize("steps", [-3, 2**31 + 5, -(2**40)])
def test_a_plan_is_shifted_by_what_there_is_of_it(steps: int) -> None:
    """Nothing beyond its ends is read, whatever a clock says."""
    mppi = car()
    state, inputs, reference, mean = given(mppi)
    mean[:, 0] = torch.linspace(-0.1, 0.1, len(mean))
    found = plan(mppi, state, inputs, reference, mean, steps, 0, 1)
    wanted = plan(mppi, state, inputs, reference, shift(mean, steps), 0, 0, 1)
    torch.testing.assert_close(found[0], wanted[0], rtol=0, atol=0)
