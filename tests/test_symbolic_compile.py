"""Compiled models against SymPy's own evaluation, finite differences, stepping, and each other."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import sympy
import torch
from hypothesis import given, settings, strategies as st
from torch import Tensor

from sym2real.errors import ModelError, ShapeError, UnknownNameError
from sym2real.layout import Layout, Layouts
from sym2real.symbolic import (
    Equations,
    build_module,
    compile_function,
    compile_model,
    lift_constants,
    parse_expression,
    read_back,
    rollout,
    symbol,
)
from sym2real.symbolic.expressions import names_in

NAMES = ("a", "b", "c")
LAYOUTS = Layouts(
    Layout.of(["x", "qw", "qx", "qy", "qz", "vx"]), Layout.of(["thrust", "wx_cmd"]), Layout.of(["fx", "t"])
)
EQUATIONS = Equations.parse(
    LAYOUTS,
    {
        "x": "x + 0.02*vx + sin(0.3*t)*0.1",
        "qw": "qw - 0.01*qx*wx_cmd",
        "qx": "qx + 0.01*qw*wx_cmd*gain",
        "qy": "gain/mass**2",
        "qz": "0.1",
        "vx": "vx + 0.02*(2*(qx*qz + qw*qy)*lift + fx)/mass - 0.001*vx**2*gain",
    },
    0.02,
    quantities={"lift": "thrust*(1 - 0.1*thrust)"},
    parameters={"mass": 0.3, "gain": 1.5},
)


def normal(seed: int, *shape: int) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def by_sympy(expressions: Sequence[sympy.Expr], names: Sequence[str], columns: Sequence[np.ndarray]) -> np.ndarray:
    function = sympy.lambdify([symbol(name) for name in names], list(expressions), "numpy")
    with np.errstate(all="ignore"):
        return np.stack(np.broadcast_arrays(*columns, *function(*columns))[len(columns) :], -1)


def leaves() -> st.SearchStrategy[sympy.Expr]:
    numbers = st.floats(-3, 3, allow_nan=False).filter(lambda value: abs(value) > 1e-3).map(sympy.Float)
    exact = st.sampled_from([sympy.Rational(2, 3), sympy.pi, sympy.E, sympy.Integer(-2), sympy.sin(1)])
    return st.one_of(st.sampled_from([symbol(name) for name in NAMES]), numbers, exact)


def branches(inner: st.SearchStrategy[sympy.Expr]) -> st.SearchStrategy[sympy.Expr]:
    pairs = st.tuples(inner, inner)
    smooth: list[Callable[[sympy.Expr], sympy.Expr]] = [
        sympy.sin,
        sympy.cos,
        sympy.tanh,
        sympy.Abs,
        sympy.sign,
        lambda e: sympy.exp(sympy.sin(e)),
        lambda e: sympy.log(1 + e**2),
        lambda e: sympy.sqrt(1 + e**2),
        lambda e: (2 + sympy.cos(e)) ** sympy.Rational(-3, 2),
        lambda e: sympy.asin(sympy.sin(e) / 2),
        lambda e: sympy.acos(sympy.cos(e) / 2),
        lambda e: sympy.tan(sympy.sin(e)),
        lambda e: e**2,
        lambda e: e**3,
        lambda e: sympy.tanh(e) ** 11,
        lambda e: 1 / (1 + e**2),
        lambda e: (1 + e**2) ** sympy.Float(0.3),
    ]
    return st.one_of(
        pairs.map(lambda p: sympy.Add(*p)),
        pairs.map(lambda p: sympy.Add(p[0], -p[1])),
        pairs.map(lambda p: sympy.Mul(*p)),
        pairs.map(lambda p: p[0] / (1 + p[1] ** 2)),
        pairs.map(lambda p: sympy.atan2(p[0], 1 + p[1] ** 2)),
        pairs.map(lambda p: sympy.Min(*p, evaluate=False)),
        pairs.map(lambda p: sympy.Max(*p, evaluate=False)),
        pairs.map(lambda p: sympy.Piecewise((p[0], p[0] < p[1]), (p[1] * 2, True))),
        st.tuples(inner, st.sampled_from(smooth)).map(lambda p: p[1](p[0])),
    )


EXPRESSIONS = st.recursive(leaves(), branches, max_leaves=12)
POINTS = np.moveaxis(normal(7, 16, 3).numpy(), -1, 0)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.lists(EXPRESSIONS, min_size=2, max_size=3))
def test_generated_source_computes_what_sympy_does(expressions: list[sympy.Expr]) -> None:
    expected = by_sympy(expressions, NAMES, POINTS)
    function = compile_function(expressions, [NAMES])
    points = torch.as_tensor(POINTS.T.copy())
    scale = np.abs(expected).max() + 1.0
    np.testing.assert_allclose(function(points).numpy(), expected, rtol=1e-9, atol=1e-12 * scale)


@pytest.mark.parametrize(
    "written",
    [
        "a/(b + 3) - 2*c*a + 0.25",
        "sin(a)*cos(b) + c**3",
        "exp(-a**2)*(b - c)",
        "2*(a + b)*(a - c)/7",
        "sqrt(a**2 + b**2)",
    ],
)
def test_single_precision_is_good_to_its_last_digits(written: str) -> None:
    expression = parse_expression(written)
    function = compile_function([expression], [NAMES])
    points = torch.as_tensor(np.abs(POINTS.T) + 0.5)
    exact = function(points)
    assert function(points.float()).dtype == torch.float32
    scale = exact.abs().max()
    assert float((function(points.float()).double() - exact).abs().max() / scale) < 1e-6


def test_step_is_what_sympy_says_on_the_manifold() -> None:
    model = compile_model(EQUATIONS, dtype=torch.float64)
    state, action, inputs = normal(0, 7, 6), normal(1, 7, 2), normal(2, 7, 2)
    names = [*EQUATIONS.columns]
    whole = {symbol("lift"): EQUATIONS.quantities["lift"], **{symbol(k): v for k, v in EQUATIONS.parameters.items()}}
    expressions = [expression.subs(whole).subs(whole) for expression in EQUATIONS.next.values()]
    raw = by_sympy(expressions, names, [*state.numpy().T, *action.numpy().T, *inputs.numpy().T])
    expected = LAYOUTS.state.normalise(torch.as_tensor(raw))
    torch.testing.assert_close(model(state, action, inputs), expected, rtol=1e-12, atol=1e-12)


def test_missing_inputs_are_no_wrench_and_time_from_zero() -> None:
    model = compile_model(EQUATIONS, dtype=torch.float64)
    state, actions = normal(0, 7, 6), normal(1, 7, 5, 2)
    torch.testing.assert_close(model(state, actions[:, 0]), model(state, actions[:, 0], torch.zeros(2).double()))
    torch.testing.assert_close(rollout(model, state, actions), rollout(model, state, actions, torch.zeros(2).double()))
    needed = Equations.parse(
        Layouts(Layout.of(["x"]), Layout.of(["thrust"]), Layout.of(["vbat"])), {"x": "x*vbat"}, 0.1
    )
    with pytest.raises(Exception, match="needs its inputs vbat"):
        compile_model(needed)(torch.zeros(1), torch.zeros(1))


@pytest.mark.parametrize("per_step", [False, True])
def test_rollout_is_stepping(per_step: bool) -> None:
    model = compile_model(EQUATIONS, dtype=torch.float64)
    state, actions = normal(0, 7, 6), normal(1, 7, 5, 2)
    inputs = normal(2, 7, 5, 2) if per_step else normal(2, 7, 2)
    found = rollout(model, state, actions, inputs)
    for step in range(5):
        now = inputs[:, step] if per_step else inputs + torch.tensor([0.0, step * EQUATIONS.dt], dtype=torch.float64)
        state = model(state, actions[:, step], now)
        torch.testing.assert_close(found[:, step], state, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("state", "actions", "inputs", "parameters"),
    [
        ((), (), (), ()),
        ((3,), (), (), ()),
        ((), (3,), (1,), (3,)),
        ((2, 3), (3,), (2, 1), ()),
        ((3,), (2, 1), (1, 1), (2, 3)),
    ],
)
def test_leading_dimensions_broadcast(
    state: tuple[int, ...], actions: tuple[int, ...], inputs: tuple[int, ...], parameters: tuple[int, ...]
) -> None:
    model = compile_model(EQUATIONS, dtype=torch.float64)
    batch = torch.broadcast_shapes(state, actions, inputs, parameters)
    full = [normal(0, *state, 6), normal(1, *actions, 4, 2), normal(2, *inputs, 4, 2), normal(3, *parameters, 2).exp()]
    found = model.rollout(*full)
    assert found.shape == (*batch, 4, 6)
    spread = [
        value.expand(*batch, *value.shape[len(lead) :])
        for value, lead in zip(full, (state, actions, inputs, parameters), strict=True)
    ]
    for place in np.ndindex(*batch):
        torch.testing.assert_close(found[place], model.rollout(*(value[place] for value in spread)))
    once = model(full[0], full[1][..., 0, :], full[2][..., 0, :], full[3])
    torch.testing.assert_close(once, found[..., 0, :])


def test_a_parameter_set_is_a_substitution() -> None:
    model = compile_model(EQUATIONS, dtype=torch.float64)
    state, actions = normal(0, 6), normal(1, 5, 2)
    sets = torch.tensor([[0.3, 1.5], [0.5, -2.0], [1.0, 0.1]]).double()
    together = rollout(model, state, actions, parameters=sets)
    for values, found in zip(sets, together, strict=True):
        fixed = EQUATIONS.at(mass=float(values[0]), gain=float(values[1]))
        assert not fixed.parameters
        torch.testing.assert_close(rollout(compile_model(fixed), state, actions), found)


def test_gradients_agree_with_finite_differences() -> None:
    model = compile_model(EQUATIONS, dtype=torch.float64)
    arguments = [normal(0, 2, 6), normal(1, 2, 3, 2), normal(2, 2, 2), torch.tensor([0.4, 1.2]).double()]
    for argument in arguments:
        argument.requires_grad_()
    assert torch.autograd.gradcheck(lambda *given: rollout(model, *given), arguments)


def test_training_finds_the_parameters_and_they_are_read_back() -> None:
    wrong = EQUATIONS.substitute({"mass": symbol("mass")})
    model = compile_model(wrong, dtype=torch.float64)
    model.values.requires_grad_()
    state, actions = normal(0, 30, 6), normal(1, 30, 4, 2)
    truth = rollout(model, state, actions, parameters=torch.tensor([0.4, 1.1]).double())
    optimiser = torch.optim.LBFGS([model.values], line_search_fn="strong_wolfe", max_iter=100, tolerance_change=1e-14)

    def loss() -> Tensor:
        optimiser.zero_grad()
        error = (rollout(model, state, actions) - truth).square().sum()
        error.backward()
        return error

    optimiser.step(loss)
    found = read_back(model, wrong).parameters
    assert found == pytest.approx({"mass": 0.4, "gain": 1.1}, rel=1e-4)


def test_lifted_constants_change_nothing() -> None:
    lifted = lift_constants(EQUATIONS)
    assert not any(expression.atoms(sympy.Float) for expression in lifted.next.values())
    state, actions = normal(0, 3, 6), normal(1, 3, 4, 2)
    found = rollout(compile_model(lifted, dtype=torch.float64), state, actions)
    torch.testing.assert_close(found, rollout(compile_model(EQUATIONS, dtype=torch.float64), state, actions))


def test_the_plain_module_is_the_scripted_one() -> None:
    state, actions = normal(0, 3, 6), normal(1, 3, 4, 2)
    plain = build_module(EQUATIONS)
    torch.testing.assert_close(
        plain.rollout(state, actions), rollout(compile_model(EQUATIONS, dtype=torch.float64), state, actions)
    )


def test_constants_keep_double_precision_in_a_single_precision_model() -> None:
    state, action = normal(0, 3, 6), normal(1, 3, 2)
    fixed = EQUATIONS.at(**EQUATIONS.parameters)
    torch.testing.assert_close(
        compile_model(fixed)(state, action), build_module(fixed)(state, action), rtol=1e-14, atol=1e-14
    )


def test_any_callable_rolls_out() -> None:
    state, actions = normal(0, 3, 2), normal(1, 3, 4, 2)
    found = rollout(lambda s, a: 2 * s + a, state, actions, normalise=lambda s: s / s.norm(dim=-1, keepdim=True))
    assert found.shape == (3, 4, 2)
    torch.testing.assert_close(found.norm(dim=-1), torch.ones(3, 4).double())
    with pytest.raises(ShapeError, match="no parameters"):
        rollout(lambda s, a: s, state, actions, parameters=torch.zeros(1))


def test_functions_broadcast_and_constants_fill_the_batch() -> None:
    function = compile_function([parse_expression("2"), parse_expression("a*p + q")], [("a",), ("p", "q")])
    a, pq = normal(0, 5, 4, 1), normal(1, 4, 2)
    found = function(a, pq)
    assert found.shape == (5, 4, 2)
    torch.testing.assert_close(found[..., 0], torch.full((5, 4), 2.0).double())
    torch.testing.assert_close(found[..., 1], a[..., 0] * pq[..., 0] + pq[..., 1])


def test_what_is_defined_stands_for_its_expression() -> None:
    """One definition may use another; what none defines is still refused."""
    definitions = {"force": parse_expression("k*slip"), "slip": parse_expression("atan2(a, sqrt(p**2 + q**2))")}
    over = [("a",), ("p", "q", "k")]
    function = compile_function([parse_expression("force + slip")], over, definitions)
    put_in = compile_function([parse_expression("(1 + k)*atan2(a, sqrt(p**2 + q**2))")], over)
    given = normal(0, 5, 1), normal(1, 5, 3)
    torch.testing.assert_close(function(*given), put_in(*given))
    with pytest.raises(UnknownNameError, match="slip"):
        compile_function([parse_expression("force")], over, {"force": definitions["force"]})


def test_unknown_names_and_bad_shapes_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'thrust'"):
        Equations.parse(LAYOUTS, {**dict.fromkeys(LAYOUTS.state, "0"), "x": "thurst"}, 0.02)
    with pytest.raises(ModelError, match="an equation for every state column, found none for qw"):
        Equations.parse(LAYOUTS, {"x": "x"}, 0.02)
    with pytest.raises(Exception, match="expected the state columns x qw"):
        compile_model(EQUATIONS)(torch.zeros(5), torch.zeros(2))


@pytest.fixture
def hasty() -> Iterator[None]:
    """Threads that take turns all the time."""
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(usual)


@pytest.mark.usefixtures("hasty")
def test_threads_compile_the_same_equations() -> None:
    layouts = Layouts.of(["x", "vx", "speed"])
    for number in range(5):
        text = Equations.parse(layouts, {"x": f"x + 0.0{number}7*vx", "vx": "speed"}, dt=0.05).to_json()
        with ThreadPoolExecutor(8) as pool:
            models = list(pool.map(lambda _, text=text: compile_model(Equations.from_json(text)), range(8)))
        state, action = torch.ones(2), torch.ones(1)
        assert len({tuple(model(state, action).tolist()) for model in models}) == 1


@pytest.mark.slow
@pytest.mark.usefixtures("hasty")
def test_threads_ask_for_the_names_of_many_expressions() -> None:
    def ask(first: int) -> set[frozenset[str]]:
        return {names_in(sympy.Add(symbol("x"), first + i, evaluate=False)) for i in range(60_000)}

    with ThreadPoolExecutor(4) as pool:
        assert set().union(*pool.map(ask, range(0, 400_000, 100_000))) == {frozenset({"x"})}
