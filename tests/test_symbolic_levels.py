"""Rollouts level by level against torch's own, operation by operation; what a level may read; what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from reference_models import flying

from sym2real.control import MPPI
from sym2real.errors import ModelError
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations, compile_model, parse_expression
from sym2real.symbolic.level_rollout import LevelRollout
from sym2real.symbolic.levels import cut
from sym2real.symbolic.native_choice import MANY
from sym2real.symbolic.source import function_program, step_program
from sym2real.tasks import make_task

SAMPLES, HORIZON = 33, 40
MODELS = [(CRAZYFLIE, flying), (CRAZYFLIE, CRAZYFLIE.nominal), (MUSHR, MUSHR.nominal)]


def operands(robot: Robot, equations: Equations) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(0)
    state = torch.tensor(robot.start) + 0.1 * torch.randn(robot.start.size, generator=generator).double()
    noise = torch.randn(SAMPLES, HORIZON, len(robot.rest), generator=generator).double()
    actions = torch.tensor(robot.rest) + 0.1 * torch.tensor(robot.high - robot.low) * noise
    inputs = 1e-3 * torch.randn(len(equations.layouts.inputs), generator=generator).double()
    return robot.layouts.state.normalise(state), actions, inputs


@pytest.mark.parametrize(("robot", "make"), MODELS)
def test_levels_roll_out_as_the_module_does(robot: Robot, make: object) -> None:
    equations = make()
    exact = compile_model(equations, dtype=torch.float64)
    level = LevelRollout(equations, SAMPLES, HORIZON)
    state, actions, known = operands(robot, equations)
    for inputs in (None, known) if len(known) else (None,):
        given = [None if tensor is None else tensor.float() for tensor in (state, actions, inputs)]
        found = level(*given)
        expected = exact.rollout(state.expand(SAMPLES, -1), actions, inputs)
        scale = expected.abs().amax(dim=(0, 1))
        assert float(((found - expected).abs().amax(dim=(0, 1)) / scale).max()) < 1e-4
        torch.testing.assert_close(level(*given), found, rtol=0, atol=0)  # its memory carries nothing over


def test_a_clock_advances_by_the_period() -> None:
    equations = MUSHR.nominal()
    layouts = equations.layouts
    clocked = Equations.parse(
        replace(layouts, inputs=type(layouts.inputs).of(("t",))),
        {column: f"{column} + 0.02*sin(3*t)" for column in layouts.state},
        MUSHR.dt,
    )
    state, actions, _ = operands(MUSHR, clocked)
    start = torch.tensor([0.4])
    found = LevelRollout(clocked, SAMPLES, HORIZON)(state.float(), actions.float(), start)
    expected = compile_model(clocked, dtype=torch.float64).rollout(state.expand(SAMPLES, -1), actions, start.double())
    torch.testing.assert_close(found.double(), expected, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize(("robot", "make"), MODELS)
def test_a_level_reads_what_stands_above_it_and_every_row_is_written_once(robot: Robot, make: object) -> None:
    program = step_program(make())
    levels = cut(program)
    written = len(program.inputs) + len(levels.numbers)
    for level in levels.batches:
        end = written
        for batch in level:
            assert all(0 <= row < written for read in batch.operands for row in read)
            assert batch.first == end
            assert {len(read) for read in batch.operands} == {batch.size}
            end += batch.size
        written = end
    assert written == levels.rows
    calls = len(levels.batches) + sum(map(len, levels.batches))
    assert calls < len(program.instructions) / 2


@pytest.mark.parametrize(
    "written",
    [
        "a - b*c",
        "b*c - a",
        "a - 0.3*b",
        "2 - a",
        "-a",
        "a*b - c*a",
        "a + a",
        "sqrt(a*a + 1)/b - 3",
        "Min(a, b)*exp(-c)",
    ],
)
def test_sums_and_differences_have_the_right_signs(written: str) -> None:
    program = function_program([parse_expression(written)], ["a", "b", "c"])
    levels = cut(program)
    rows = np.zeros((levels.rows, 7))
    rng = np.random.default_rng(0)
    rows[:3] = rng.uniform(0.5, 2.0, (3, 7))
    rows[3 : 3 + len(levels.numbers)] = np.array(levels.numbers)[:, None]
    functions = {"addcmul": lambda a, b, c: a + b * c, "rsqrt": lambda a: 1 / np.sqrt(a), "minimum": np.minimum}
    for level in levels.batches:
        for batch in level:
            function = functions.get(batch.kind) or getattr(np, batch.kind)
            rows[batch.first : batch.first + batch.size] = function(*(rows[list(read)] for read in batch.operands))
    names = dict(zip("abc", rows[:3], strict=True))
    expected = eval(
        written.replace("sqrt", "np.sqrt").replace("exp", "np.exp").replace("Min", "np.minimum"), {"np": np}, names
    )
    np.testing.assert_allclose(rows[levels.outputs[0]], expected, rtol=1e-12)


def test_conditions_are_refused_and_stay_with_the_module() -> None:
    with pytest.raises(ModelError, match="cannot be computed level by level"):
        cut(function_program([parse_expression("Piecewise((a, a < b), (b, True))")], ["a", "b"]))
    base = MUSHR.nominal()
    kinked = {**base.next, "x": parse_expression("Piecewise((x, x < 3), (3, True))")}
    mppi = MPPI(compile_model(replace(base, next=kinked)), MUSHR, make_task("circle", MUSHR), backend="torch")
    assert np.isfinite(mppi.act(MUSHR.start, 0)).all()


def test_mppi_plans_by_levels_what_it_plans_by_the_module() -> None:
    task = make_task("circle", CRAZYFLIE)
    quick = MPPI(compile_model(flying()), CRAZYFLIE, task, backend="torch")
    plain = MPPI(compile_model(flying()).forward, CRAZYFLIE, task, backend="torch")
    assert quick._torch.levels(1024) is not None and plain._torch.levels(1024) is None
    for step in range(2):
        np.testing.assert_allclose(quick.act(CRAZYFLIE.start, step), plain.act(CRAZYFLIE.start, step), atol=1e-4)


def test_torch_alone_is_torch_however_much_there_is_to_roll_out() -> None:
    """Equal bits: compiled rollouts would round differently."""
    task, equations = make_task("circle", MUSHR), MUSHR.nominal()
    settings = replace(MUSHR.mppi, samples=2048)  # more than are rolled out by levels
    mppi = MPPI(compile_model(equations), MUSHR, task, settings=settings, backend="torch")
    start = torch.tensor(MUSHR.start).float().expand(2048, -1)
    for step in range(MANY // (2048 * mppi.horizon) + 2):
        mppi.act(MUSHR.start, step)
    expected = compile_model(equations).rollout(start, mppi.plan.actions)
    torch.testing.assert_close(mppi.plan.states, expected, rtol=0, atol=0)
