"""Every function that equations may use: torch and C against SymPy's own NumPy code."""

from __future__ import annotations

import numpy as np
import pytest
import sympy
import torch

from sym2real.control import MPPI
from sym2real.errors import ModelError
from sym2real.layout import Layout, Layouts
from sym2real.native import find_compiler
from sym2real.robots import MUSHR
from sym2real.symbolic import Equations, compile_function, compile_model, parse_expression, symbol
from sym2real.symbolic.expressions import FUNCTIONS, text
from sym2real.symbolic.native_rollout import NativeRollout
from sym2real.tasks import make_task

# Arguments over x and y in (-3, 3), such that there is a real value.
INSIDE = {"asin": "x/4", "acos": "x/4", "acosh": "1 + x**2", "atanh": "x/4", "log": "4 + x", "sqrt": "4 + x"}
BINARY = {"atan2": "atan2(x, y)", "Min": "Min(x, y)", "Max": "Max(x, y)", "Mod": "Mod(x, y)"}
WRITTEN = {name: BINARY.get(name) or f"{name}({INSIDE.get(name, 'x')})" for name in FUNCTIONS} | {
    "Mod by a number": "Mod(x, 3)",
    "Heaviside with a value at 0": "Heaviside(x, 0.25)",
    "inside one another": "sinh(floor(x)/2) + cosh(ceiling(y))*frac(x*y)",
    "a sum that leaves floor": "floor(x + 2) - ceiling(2*y)",
}
RANGE = (-3.0, 3.0)
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
of_each = pytest.mark.parametrize("written", WRITTEN.values(), ids=WRITTEN)


def points() -> np.ndarray:
    """Random ones, whole numbers and halves of both signs, and zero ``# (2, N)``."""
    whole = np.arange(-3.0, 3.5, 0.5)
    x, y = np.meshgrid(whole, whole[whole != 0])
    random = np.random.default_rng(0).uniform(*RANGE, (2, 500))
    return np.concatenate([np.stack([x.ravel(), y.ravel()]), random], axis=1)


def by_sympy(written: str, at: np.ndarray) -> np.ndarray:
    function = sympy.lambdify(sympy.symbols("x y", real=True), parse_expression(written), ["numpy", "scipy"])
    with np.errstate(all="ignore"):
        return np.broadcast_to(function(*at), at.shape[1:])


def compared(found: np.ndarray, expected: np.ndarray, tolerance: float) -> None:
    """Where SymPy's code has a finite value; poles are where it has none, or one that rounding makes up."""
    there = np.isfinite(expected) & (np.abs(expected) < 1e6)
    assert there.mean() > 0.9
    np.testing.assert_allclose(found[there], expected[there], rtol=tolerance, atol=tolerance)


def model(written: str) -> Equations:
    """The value as a next state, over its input and another column, without a plant."""
    layouts = Layouts(Layout.of(("x",)), Layout.of(("y",)))
    return Equations.parse(layouts, {"x": written}, 0.1)


@of_each
def test_torch_computes_what_sympy_does(written: str) -> None:
    at = points()
    function = compile_function([parse_expression(written)], [("x", "y")])
    compared(function(torch.as_tensor(at.T.copy())).numpy()[:, 0], by_sympy(written, at), 1e-9)


@needs_compiler
@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
def test_c_computes_what_sympy_does(dtype: torch.dtype) -> None:
    """All in one text: a compiler takes a while to begin."""
    names = {f"s{i}": written for i, written in enumerate(WRITTEN.values())}
    layouts = Layouts(Layout.of(("x", *names)), Layout.of(("y",)))
    equations = Equations.parse(layouts, {"x": "x", **names}, 0.1)
    at = torch.as_tensor(points()).to(dtype)
    state = torch.zeros(at.shape[1], 1 + len(names), dtype=dtype)
    state[:, 0] = at[0]
    found = NativeRollout(equations, dtype)(state, at[1][:, None, None])[:, 0].double().numpy()
    exact = at.double().numpy()
    for column, written in enumerate(names.values(), 1):
        if dtype == torch.float64:
            compared(found[:, column], by_sympy(written, exact), 1e-9)
        else:  # halves are exact in single precision, and their products; elsewhere a value may jump
            compared(found[:156, column], by_sympy(written, exact[:, :156]), 1e-4)


def test_a_sine_over_its_argument_has_a_derivative_at_zero() -> None:
    at = torch.tensor([[-1e-3], [0.0], [1e-12], [0.5]], dtype=torch.float64, requires_grad=True)
    found = compile_function([parse_expression("sinc(x)")], [["x"]])(at)
    (slope,) = torch.autograd.grad(found.sum(), at)
    x = at.detach()
    expected = torch.where(x.abs() > 1e-9, (x.cos() - x.sin() / x) / x, 0.0)
    torch.testing.assert_close(slope, expected, rtol=1e-6, atol=1e-9)


@of_each
def test_texts_read_back_and_a_model_opens_again(written: str) -> None:
    expression = parse_expression(written)
    assert parse_expression(text(expression)) == expression
    equations = model(written)
    assert Equations.from_json(equations.to_json()).next == equations.next


@pytest.mark.parametrize("name", ["gamma", "erf", "zeta", "besselj"])
def test_other_functions_are_refused_by_name(name: str) -> None:
    expression = symbol("x") + sympy.besselj(1, 2.0) if name == "besselj" else getattr(sympy, name)(symbol("x"))
    with pytest.raises(ModelError, match=name):
        compile_function([expression], [("x",)])


def test_a_remainder_of_nothing_is_refused() -> None:
    with pytest.raises(ModelError, match=r"Mod|remainder"):
        compile_function([parse_expression("Mod(x, 0)")], [("x",)])


@needs_compiler
def test_mppi_plans_with_them() -> None:
    """Its kernel rolls out what the module does."""
    base = MUSHR.nominal()
    kinked = Equations(
        next={**base.next, "vx": base.next["vx"] + parse_expression("0.01*sinh(0.1*vx)*frac(x) - 0.02*floor(y/2)")},
        layouts=base.layouts,
        dt=base.dt,
        quantities=base.quantities,
        robot=base.robot,
        numbers=base.numbers,
    )
    mppi = MPPI(compile_model(kinked), MUSHR, make_task("circle", MUSHR), backend="c")
    mppi.act(MUSHR.start, 0)
    start = torch.tensor(MUSHR.start).float().expand(mppi.samples, -1)
    expected = compile_model(kinked).rollout(start, mppi.plan.actions)
    torch.testing.assert_close(mppi.plan.states, expected, rtol=1e-3, atol=1e-3)
