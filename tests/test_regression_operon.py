"""Operon's engine on problems small enough for seconds."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
import sympy
from regression_data import drawn

from sym2real.dataset import Transitions
from sym2real.errors import MissingDependencyError
from sym2real.regression import Operon, fit_quality
from sym2real.symbolic import parse_expression, symbol

needs_operon = pytest.mark.skipif(
    importlib.util.find_spec("pyoperon") is None, reason="needs pyoperon: pip install 'sym2real[operon]'"
)
SMALL = Operon(population=60, generations=12, threads=2)


def system(seed: int = 0) -> Transitions:
    return drawn("ab", "u", lambda v: {"a": 1e-4 * v["b"], "b": -0.3 * v["a"] * v["u"] + 0.5 * v["u"]}, 150, seed=seed)


@needs_operon
def test_finds_a_small_system_and_small_numbers() -> None:
    equations = SMALL.fit(system())
    errors, data = fit_quality(equations, system(1)), system(1)
    spread = (data.next_state - data.state).std(axis=0)
    assert errors["a"] < 1e-2 * spread[0]
    assert errors["b"] < 2e-2 * spread[1]
    assert max(equations.complexity().values()) <= 85


@needs_operon
def test_the_same_seed_gives_the_same_equations() -> None:
    tiny = Operon(population=30, generations=3, threads=1)
    assert tiny.fit(system()).to_json() == tiny.fit(system()).to_json()


@needs_operon
def test_sine_of_a_declared_angle() -> None:
    data = drawn(["a"], ["steer"], lambda v: {"a": np.sin(v["steer"])}, 150)
    found = Operon(angles=("steer",), population=40, generations=3).fit(data).next["a"]
    assert found.has(sympy.sin(symbol("steer")))
    assert not Operon(population=20, generations=1).fit(data).next["a"].has(sympy.sin)


@needs_operon
def test_text_of_a_tree_is_what_operon_computes() -> None:
    from pyoperon.sklearn import SymbolicRegressor

    from sym2real.regression.operon import SETTINGS, tree_text

    rng = np.random.default_rng(0)
    values = rng.normal(size=(200, 3))
    target = 1e-5 * values[:, 0] - (values[:, 1] - 0.2 * values[:, 2]) * (values[:, 2] - 3.0)
    regressor = SymbolicRegressor(**SETTINGS, population_size=100, generations=10, random_state=2).fit(values, target)
    names = ["a", "b", "c"]
    factors = dict(zip(regressor.variables_, zip(names, [1.0, 1.0, 1.0], strict=True), strict=True))
    text = tree_text(regressor.model_.Nodes, factors)
    computed = sympy.lambdify([symbol(name) for name in names], parse_expression(text, names))(*values.T)
    np.testing.assert_allclose(computed, regressor.predict(values), rtol=1e-4, atol=1e-5)


def test_without_pyoperon_one_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    with pytest.raises(MissingDependencyError, match="pip install"):
        SMALL.fit(system())
