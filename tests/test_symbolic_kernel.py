"""Sines and the C rollout, against sampling, NumPy and torch."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np
import pytest
import torch
from reference_models import flying, late, motor_lagged

from sym2real.layout import Layouts
from sym2real.native import find_compiler, library
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import Equations, compile_model, lift_constants, rollout
from sym2real.symbolic.c_functions import preamble
from sym2real.symbolic.native_choice import MANY
from sym2real.symbolic.native_rollout import NativeRollout, edges_of
from sym2real.threads import one_thread

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


APPLIED = """
EXPORTED void apply(const real *from, real *to, int n) {{
    for (int i = 0; i < n; i += WIDTH) {{
        v x, y;
        __builtin_memcpy(&x, from + i, sizeof x);
        y = {}(x);
        __builtin_memcpy(to + i, &y, sizeof y);
    }}
}}
"""


def by_c(call: str, at: np.ndarray) -> np.ndarray:
    """What a function of a kernel's beginning gives at whole vectors of arguments, in their precision."""
    found, kernel = np.zeros_like(at), library(preamble(at.dtype == np.float32) + APPLIED.format(call))
    kernel.apply(*(ctypes.c_void_p(values.ctypes.data) for values in (at, found)), len(at))
    return found


@needs_compiler
@pytest.mark.parametrize(
    ("call", "most", "dtype", "error"),
    [
        *((name, most, np.float32, 2e-6) for most in (4.0, 600.0) for name in ("sine", "cosine")),
        *((name, most, np.float64, 1e-14) for most in (4.0, 600.0) for name in ("sine", "cosine")),
    ],
)
def test_sines_keep_their_error(call: str, most: float, dtype: type, error: float) -> None:
    x = np.linspace(-most, most, 16384).astype(dtype)
    exact = getattr(np, {"s": "sin", "c": "cos"}[call[0]])(x.astype(np.longdouble))
    rounding = np.abs(x) * np.finfo(dtype).eps  # of the argument, and of its turns
    assert (np.abs(by_c(call, x) - exact) <= error + rounding).all()


@needs_compiler
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_sines_of_huge_arguments_are_bounded(dtype: type) -> None:
    x = np.geomspace(1e5, 1e35, 1024).astype(dtype)
    for call in ("sine", "cosine"):
        assert (np.abs(by_c(call, x)) <= 1.00001).all()


def operands(equations: Equations, dtype: torch.dtype) -> tuple[torch.Tensor, ...]:
    generator = torch.Generator().manual_seed(0)
    robot = CRAZYFLIE if equations.robot == "crazyflie" else MUSHR
    layouts = equations.layouts
    noise = lambda *shape: torch.randn(shape, generator=generator, dtype=torch.float64)  # noqa: E731
    state = torch.cat([torch.tensor(robot.start), torch.zeros(len(layouts.state) - robot.start.size).double()])
    state = layouts.state.normalise(state + 0.1 * noise(5, len(layouts.state)))
    scale = torch.tensor(robot.high - robot.low)
    actions = torch.tensor(robot.rest) + 0.1 * scale * noise(3, 1, 40, len(layouts.action))
    known = 1e-3 * noise(3, 5, 40, len(layouts.inputs))
    return tuple(tensor.to(dtype) for tensor in (state, actions, known))


@needs_compiler
@pytest.mark.parametrize("make", [CRAZYFLIE.nominal, MUSHR.nominal, flying, late, motor_lagged])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_the_kernel_rolls_out_as_torch_does(make: object, dtype: torch.dtype) -> None:
    equations = make()
    model, kernel = compile_model(equations, dtype=dtype), NativeRollout(equations, dtype)
    exact = compile_model(equations, dtype=torch.float64)
    state, actions, known = operands(equations, dtype)
    for inputs in (None, known[0, 0, 0], known):
        found = kernel(state, actions, inputs)
        assert found.shape == (3, 5, 40, len(equations.layouts.state)) and found.dtype == dtype
        given = [None if tensor is None else tensor.double() for tensor in (state, actions, inputs)]
        reference = exact.rollout(*given)
        error = (found - reference).abs().amax(dim=(0, 1, 2)) / reference.abs().amax(dim=(0, 1, 2))
        assert float(error.max()) < (1e-4 if dtype == torch.float32 else 1e-12)
        assert float((found - model.rollout(state, actions, inputs)).abs().max()) < 1e-3


@needs_compiler
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_what_is_no_number_is_not_hidden_by_a_limit(dtype: torch.dtype) -> None:
    layouts = Layouts.of(["x", "y", "vx", "vy", "speed"])
    limited = {"x": "Max(Min(vx, 1), -1)", "y": "Max(x, speed)", "vx": "Min(speed, vx)", "vy": "Min(vx, speed, y)"}
    equations = Equations.parse(layouts, limited, dt=0.1)
    state = torch.tensor([[0.0, 0.0, torch.nan, 0.0], [torch.nan, 0.0, 0.0, 0.0]], dtype=dtype)
    actions = torch.tensor([0.0, torch.nan], dtype=dtype)[:, None, None]
    expected = compile_model(equations, dtype=dtype).rollout(state, actions)
    assert expected.isnan().sum() == 6  # three columns of each sample
    torch.testing.assert_close(NativeRollout(equations, dtype)(state, actions), expected, equal_nan=True)


@needs_compiler
@pytest.mark.parametrize(
    ("state", "actions", "parameters"),
    [((), (), ()), ((3,), (), ()), ((), (3,), (3,)), ((2, 3), (3,), ()), ((3,), (2, 1), (2, 3)), ((0,), (1,), ())],
)
def test_every_broadcast_is_the_one_of_torch(state: tuple, actions: tuple, parameters: tuple) -> None:
    equations = lift_constants(CRAZYFLIE.nominal())
    model, kernel = compile_model(equations, dtype=torch.float64), NativeRollout(equations, torch.float64)
    generator = torch.Generator().manual_seed(0)
    values = torch.tensor(list(equations.parameters.values())).double()
    given = (
        torch.randn(*state, 13, generator=generator, dtype=torch.float64),
        0.3 + 0.1 * torch.randn(*actions, 6, 4, generator=generator, dtype=torch.float64),
        None,
        values * (1 + 0.05 * torch.randn(*parameters, len(values), generator=generator, dtype=torch.float64)),
    )
    torch.testing.assert_close(kernel(*given), model.rollout(*given), rtol=1e-10, atol=1e-10)


@needs_compiler
def test_strided_operands_are_read() -> None:
    equations = MUSHR.nominal()
    kernel = NativeRollout(equations, torch.float64)
    state, actions, _ = operands(equations, torch.float64)
    wide = torch.zeros(7, 10).double()
    wide[:, ::2][:, :5] = state.T
    turned = actions.movedim(-1, 0).contiguous().movedim(0, -1)
    torch.testing.assert_close(kernel(wide[:, ::2][:, :5].T, turned), kernel(state, actions))


@needs_compiler
@pytest.mark.parametrize("threads", [2, 3])
def test_threads_share_samples_and_change_no_bit(threads: int, set_threads: Callable[[int], None]) -> None:
    equations = lift_constants(MUSHR.nominal())
    kernel = NativeRollout(equations, torch.float64)
    state, actions, _ = operands(equations, torch.float64)
    values = kernel.values * torch.linspace(0.9, 1.1, 331).double()[:, None, None, None]
    set_threads(1)
    alone = kernel(state, actions, None, values)
    set_threads(threads)
    with one_thread():
        together = kernel(state, actions, None, values)
    assert torch.equal(alone, together) and len(edges_of(alone[..., 0, 0].numel())) == threads + 1
    assert not torch.equal(alone[0], alone[-1])


@needs_compiler
def test_models_that_work_much_go_to_c_and_say_the_same() -> None:
    equations = lift_constants(CRAZYFLIE.nominal())
    model = compile_model(equations, dtype=torch.float64)
    state = torch.tensor(CRAZYFLIE.start).double().expand(200, -1)
    actions = torch.tensor(CRAZYFLIE.rest) + 0.1 * torch.randn(200, 40, 4, dtype=torch.float64)
    first = rollout(model, state, actions)
    for _ in range(MANY // 8000 + 1):
        last = rollout(model, state, actions)
    torch.testing.assert_close(first, last, rtol=1e-10, atol=1e-10)
    assert not torch.equal(first, last), "torch and C round differently; equal bits mean that C did not run"
    values = torch.tensor(list(equations.parameters.values())).double().requires_grad_()
    rollout(model, state, actions, parameters=values).sum().backward()
    assert values.grad.isfinite().all()
