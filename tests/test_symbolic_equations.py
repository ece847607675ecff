"""Equations as an object: reading untrusted text, exact round trips, substitution, node counts, factoring."""

from __future__ import annotations

import copy
import json
import math
import pickle
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from inspect import isgenerator
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given, settings, strategies as st
from reference_models import motor_lagged

from sym2real.errors import ModelError, Sym2RealError, UnknownNameError
from sym2real.layout import Layout, Layouts
from sym2real.symbolic import Equations, complexity, expressions, factor_horner, parse_expression, symbol, text
from sym2real.symbolic.expressions import names_in
from sym2real.symbolic.program import Program
from sym2real.symbolic.shared_parts import distinct
from sym2real.symbolic.source import function_program

LAYOUTS = Layouts(Layout.of(["x", "vx"]), Layout.of(["motor1", "motor2"]), Layout.of(["fx"]))
EQUATIONS = Equations.parse(
    LAYOUTS,
    {"x": "x + 0.1*vx", "vx": "vx + 0.1*(thrust + fx)/mass"},
    0.1,
    output={"x": "-x"},
    quantities={"thrust": "k*(motor1**2 + motor2**2)"},
    parameters={"mass": 0.1 + 0.2, "k": 1e-7},
    robot="sled",
    notes=("two motors",),
)
a, b, c, d = (symbol(name) for name in "abcd")


@pytest.mark.parametrize(
    "attack",
    [
        "__import__('os').system('touch /tmp/owned')",
        "(lambda: 1)()",
        "[x for x in (1, 2)]",
        "x.__class__",
        "x if x else 1",
        "x[0]",
        "'text'",
        "f'{x}'",
        "eval('1')",
        "open('f')",
        "Symbol('y')",
        "sin(x, evaluate=False)",
        "sin(*x)",
        "sin",
        "9**9**9**9",
        "x ^ 2",
        "1e999",
        "1j",
        "x/0",
        "0**(-1)",
        "sqrt(-1)",
        "x < 1",
        "x; x",
        "",
        "(" * 3000 + "x" + ")" * 3000,
        "-" * 100_000 + "x",
        "x" * 300_000,
        "gamma(x)",
        "atan2(x)",
        "Piecewise(x)",
        "Piecewise()",
        "Piecewise((1, x), (2, True))",
        "Piecewise((1, x & 2), (2, True))",
        "Piecewise((x < 1, True))",
        "sin(x < 1)",
        "(x < 1) + 1",
        "True + 1",
        "-(x < 1)",
        "~x",
        "(x < 1) < 2",
        "sqrt(-1) < x",
        "exp(exp(exp(10.0)))",
        "2.5**100000000000",
        "True",
        "x = 1",
        "x @ x",
        "(x := 1)",
    ],
)
def test_text_that_is_no_expression_is_refused(attack: str) -> None:
    content = json.loads(EQUATIONS.to_json())
    content["next"]["x"] = attack
    with pytest.raises(Sym2RealError):
        Equations.from_json(json.dumps(content))


@pytest.mark.parametrize("entry", ["format", "dt", "next", "layouts", "parameters", "quantities", "notes", "effects"])
@pytest.mark.parametrize("value", [None, "text", {"a": []}, True])
def test_json_of_another_shape_is_refused(entry: str, value: object) -> None:
    content = json.loads(EQUATIONS.to_json())
    with pytest.raises(ModelError):
        Equations.from_json(json.dumps({**content, entry: value}))
    with pytest.raises(ModelError):
        Equations.from_json(EQUATIONS.to_json()[:-40])


def test_refusals_name_the_equation_and_the_nearest_name() -> None:
    with pytest.raises(ModelError, match=r"equation of 'x'.*\*\*"):
        Equations.parse(LAYOUTS, {"x": "x ^ 2", "vx": "vx"}, 0.1)
    with pytest.raises(UnknownNameError, match=r"equation of 'vx'.*did you mean 'motor"):
        Equations.parse(LAYOUTS, {"x": "x", "vx": "motor3"}, 0.1)
    with pytest.raises(UnknownNameError, match="did you mean 'atan2'"):
        parse_expression("arctan2(a, b)")
    with pytest.raises(ModelError, match="stands for two things"):
        Equations.parse(LAYOUTS, {"x": "x", "vx": "vx"}, 0.1, parameters={"x": 1.0})
    with pytest.raises(ModelError, match="dt > 0"):
        Equations.parse(LAYOUTS, {"x": "x", "vx": "vx"}, 0.0)


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("-a**2", -4.0),
        ("a - b - c", -6.0),
        ("a/b/c", 2 / 15),
        ("2**-1 + 1/3", 5 / 6),
        ("a**b**0.5", 2 ** math.sqrt(3)),
        ("Piecewise((a, a > b), (c, (a < b) & (b < c) and not a > c), (0, True))", 5.0),
        ("Min(a, b, c) + Max(a, b, c)", 7.0),
        ("abs(-a) + Abs(-b) + sign(-c)", 4.0),
        ("pi + E - log(E)", math.pi + math.e - 1),
        ("Piecewise((1, 1 < a < 3), (2, True))", 1.0),
        ("atan2(a, b) + atan(a/b)", 2 * math.atan2(2, 3)),
    ],
)
def test_text_means_what_python_means(written: str, value: float) -> None:
    assert float(parse_expression(written).subs({a: 2, b: 3, c: 5})) == pytest.approx(value, rel=1e-14)


def trees() -> st.SearchStrategy[sympy.Expr]:
    leaf = st.one_of(
        st.sampled_from([a, b, c]),
        st.floats(allow_nan=False, allow_infinity=False, min_value=-1e6, max_value=1e6).map(sympy.Float),
        st.fractions(-5, 5, max_denominator=9).map(lambda value: sympy.Rational(value.numerator, value.denominator)),
    )

    def grow(inner: st.SearchStrategy[sympy.Expr]) -> st.SearchStrategy[sympy.Expr]:
        pair = st.tuples(inner, inner)
        return st.one_of(
            pair.map(lambda p: p[0] + p[1]),
            pair.map(lambda p: p[0] * p[1]),
            pair.map(lambda p: sympy.Mul(2, p[0] + p[1], evaluate=False) if (p[0] + p[1]).is_Add else p[0]),
            pair.map(lambda p: sympy.Piecewise((p[0], p[0] < p[1]), (p[1], True))),
            inner.map(sympy.sin),
            inner.map(lambda e: sympy.sqrt(1 + e**2)),
            inner.map(lambda e: 1 / (2 + sympy.cos(e))),
        )

    return st.recursive(leaf, grow, max_leaves=10)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(trees())
def test_text_and_json_round_trips_are_exact(expression: sympy.Expr) -> None:
    layouts = Layouts(Layout.of(["a", "b", "c"]), Layout())
    equations = Equations({"a": expression, "b": b, "c": c}, layouts, 0.02)
    assert parse_expression(text(equations.next["a"])) == equations.next["a"]
    again = Equations.from_json(equations.to_json())
    assert dict(again.next) == dict(equations.next)
    assert again.to_json() == equations.to_json()


def test_everything_survives_json() -> None:
    again = Equations.from_json(EQUATIONS.to_json())
    for name in ("next", "output", "quantities", "parameters", "layouts", "dt", "robot", "notes"):
        assert getattr(again, name) == getattr(EQUATIONS, name)
    assert again.parameters["mass"] == 0.1 + 0.2  # not 0.3: floats are exact
    assert "thrust = " in again.text()
    assert again.latex()["x"]


def test_equations_go_to_other_processes_and_are_copied() -> None:
    equations = motor_lagged()
    for other in (pickle.loads(pickle.dumps(equations)), copy.deepcopy(equations)):
        assert other.to_json() == equations.to_json()
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert pool.submit(Equations.complexity, equations).result() == equations.complexity()


def test_substitution_is_simultaneous_and_reaches_quantities() -> None:
    swapped = EQUATIONS.substitute({"motor1": symbol("motor2"), "motor2": 2 * symbol("motor1")})
    expected = parse_expression("k*(motor2**2 + 4*motor1**2)")
    assert sympy.expand(swapped.quantities["thrust"] - expected) == 0
    gained = EQUATIONS.substitute({"thrust": symbol("gain") * symbol("thrust")}, {"gain": 0.5})
    assert gained.depends("vx", "gain") and not gained.depends("x", "gain")
    assert gained.quantities == EQUATIONS.quantities
    with pytest.raises(UnknownNameError, match="gain"):
        EQUATIONS.substitute({"thrust": symbol("gain") * symbol("thrust")})
    with pytest.raises(UnknownNameError, match="did you mean 'motor"):
        EQUATIONS.substitute({"motor9": 1.0})


def test_a_substitution_costs_what_the_shared_graph_costs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of 60 parts stands twice in the next: a billion billion paths, of which none may be followed twice."""
    part, depth, visits = symbol("x"), 60, Counter[str]()
    for _ in range(depth):
        part = sympy.sin(part, evaluate=False) + sympy.cos(part, evaluate=False)
    size = len(list(distinct(part)))
    equations = replace(EQUATIONS, next={"x": part, "vx": 2 * part})
    for name in ("rebuild", "distinct"):
        monkeypatch.setattr(expressions, name, counted(getattr(expressions, name), visits))
    changed = equations.substitute({"x": symbol("vx"), "vx": symbol("x")})
    assert size == 3 * depth + 1
    assert size - 1 <= visits["rebuild"] <= size + 10  # once for both equations; the other expressions are small
    assert visits["distinct"] <= 5 * size  # twice by the checks of each of the two new equations
    assert names_in(changed.next["x"]) == {"vx"}


def counted(function: Callable[..., Any], visits: Counter[str]) -> Callable[..., Any]:
    """The function, with a count of its calls, or of what it yields."""

    def count(*arguments: Any) -> Any:
        made = function(*arguments)
        if not isgenerator(made):
            visits[function.__name__] += 1
            return made
        return tap(made)

    def tap(made: Iterator[Any]) -> Iterator[Any]:
        for one in made:
            visits[function.__name__] += 1
            yield one

    return count


def test_substitution_keeps_factored_products() -> None:
    factored = parse_expression("0.5*(a + b)*1")
    layouts = Layouts(Layout.of(["a", "b"]), Layout())
    equations = Equations({"a": factored, "b": b}, layouts, 0.1)
    assert complexity(equations.substitute({"b": b + 1.5}).next["a"]) == complexity(factored) + 2


def test_dependence_goes_through_quantities() -> None:
    assert EQUATIONS.depends("vx", "motor1") and EQUATIONS.depends("vx", "k") and EQUATIONS.depends("vx", "thrust")
    assert not EQUATIONS.depends("x", "motor1")
    with pytest.raises(UnknownNameError):
        EQUATIONS.depends("vx", "motor7")


def test_parameters_become_numbers() -> None:
    fixed = EQUATIONS.at(mass=0.3)
    assert list(fixed.parameters) == ["k"] and fixed.depends("vx", "k")
    assert symbol("mass") not in fixed.next["vx"].free_symbols
    with pytest.raises(UnknownNameError, match="parameter"):
        EQUATIONS.at(weight=1.0)


@pytest.mark.parametrize(
    ("written", "nodes"),
    [
        ("a", 1), ("2.5", 1), ("a + b", 3), ("a - b", 3), ("a/b", 3), ("-0.3*a", 3), ("a - 0.3*b", 5), ("-a", 3),
        ("-a - b", 5), ("a**3", 5), ("(a + b)**2", 7), ("1/a", 3), ("a/(b*c)", 5), ("a*b/c", 5), ("sin(a)", 2),
        ("2*(a + b)", 5), ("a + b + c", 5), ("sqrt(a)", 2), ("a/2", 3), ("atan2(a, b)", 3), ("Max(a, b, c)", 5),
        ("a - 2*b*c", 7), ("exp(a)", 2), ("a**-2", 5), ("pi*a", 3), ("0.58*a + 0.42*b - 0.012*c*d", 13),
    ],
)  # fmt: skip
def test_nodes_of_the_binary_tree(written: str, nodes: int) -> None:
    assert complexity(parse_expression(written)) == nodes


@settings(max_examples=80, deadline=None, derandomize=True)
@given(
    st.lists(
        st.tuples(
            st.floats(-3, 3).filter(lambda v: abs(v) > 0.01),
            st.lists(st.sampled_from([a, b, c, d, sympy.sin(a)]), max_size=4),
        ),
        min_size=1,
        max_size=14,
    )
)
def test_factoring_keeps_the_value_and_never_costs_nodes(terms: list[tuple[float, list[sympy.Expr]]]) -> None:
    flat = sympy.Add(*(sympy.Mul(sympy.Float(number), *factors) for number, factors in terms))
    factored = factor_horner(flat)
    assert complexity(factored) <= complexity(flat)
    points = np.random.default_rng(0).normal(size=(4, 8))
    values = [sympy.lambdify([a, b, c, d], expression, "numpy")(*points) for expression in (flat, factored)]
    np.testing.assert_allclose(values[0], values[1], rtol=1e-10, atol=1e-10)
    assert parse_expression(text(factored)) == factored


def test_factoring_finds_the_nested_form() -> None:
    flat = sympy.expand((a + 2.5) * (a * b + 0.5 * c)) + 0.1 * a * d
    assert complexity(factor_horner(flat)) < complexity(flat) - 5
    assert complexity(factor_horner(0.01 * a * b + 0.01 * c * d - 0.01 * a * d)) == 11


def program_of(*lines: str) -> Program:
    return function_program([parse_expression(line) for line in lines], ["a", "b", "c", "d"])


def operations(program: Program) -> list[str]:
    return [instruction.operation for instruction in program.instructions]


def test_equal_parts_are_computed_once() -> None:
    program = program_of("sin(a*b + c)*d", "cos(c + b*a)", "a*b*c", "2*sin(a*b + c)")
    assert operations(program).count("sin") == 1 and operations(program).count("cos") == 1
    assert len(program.instructions) == 7  # a·b, +c, sin, ·d, cos, ·c, 2·


def test_powers_are_multiplied_and_constants_folded() -> None:
    program = program_of("a**16", "a**8", "sin(1)*a")
    assert operations(program) == ["multiply"] * 5
    assert math.sin(1) in program.constants


def test_instructions_read_earlier_values_only() -> None:
    program = program_of("sin(a)*b + a**3/(1 + b**2) - Max(a, 0.5)")
    for value, instruction in zip(program.computed, program.instructions, strict=True):
        assert all(operand < value for operand in instruction.operands)
    assert len(set(program.instructions)) == len(program.instructions)


def test_nested_cases_are_written_without_if_then_else() -> None:
    inner = sympy.Piecewise((a, a < b), (b, True))
    nested = sympy.Piecewise((inner, inner < a), (a, True))
    condition = sympy.ITE(a < b, sympy.false, a < c)
    for expression in (nested, sympy.Piecewise((a, condition), (b, True))):
        layouts = Layouts(Layout.of(["a", "b", "c"]), Layout())
        equations = Equations({"a": expression, "b": b, "c": c}, layouts, 0.02)
        again = parse_expression(text(equations.next["a"]))
        for values in ((1.0, 2.0, 3.0), (2.0, 1.0, 3.0), (3.0, 2.0, 1.0), (1.0, 1.0, 1.0)):
            point = dict(zip((a, b, c), values, strict=True))
            assert again.subs(point) == expression.subs(point)
