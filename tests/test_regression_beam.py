"""Beam search: it finds what generated the data, keeps its limits, and says how it went."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy
import torch
from regression_data import concatenated, drawn, flights

from sym2real.dataset import Transitions
from sym2real.errors import ModelError, ShapeError
from sym2real.layout import Layout, Layouts
from sym2real.regression import ENGINES, BeamSearch, SearchSettings, fit_quality
from sym2real.regression.monomials import Monomials
from sym2real.regression.refit import refit
from sym2real.regression.search import beam_search, support_of, without_each
from sym2real.symbolic import Equations, compile_model, symbol

a, b, u = symbol("a"), symbol("b"), symbol("u")


def close(found: sympy.Expr, wanted: sympy.Expr, tolerance: float = 1e-6) -> bool:
    """Whether every coefficient of the difference is small."""
    difference = sympy.Poly(sympy.expand(found.doit() - wanted), a, b, u, sympy.sin(u), sympy.cos(u))
    return all(abs(float(number)) < tolerance for number in difference.coeffs())


def test_recovers_a_polynomial_system_to_six_digits() -> None:
    data = drawn("ab", "u", lambda v: {"a": 0.1 * v["b"], "b": -0.3 * v["a"] + 0.7 * v["a"] * v["b"] * v["u"] + 0.25})
    equations = BeamSearch().fit(data)
    assert close(equations.next["a"], a + 0.1 * b)
    assert close(equations.next["b"], b - 0.3 * a + 0.7 * a * b * u + 0.25)


def test_grows_to_degree_four_and_no_further() -> None:
    data = drawn(
        "ab", "u", lambda v: {"a": 0.4 * v["a"] ** 2 * v["b"] * v["u"] + 0.2 * v["a"] ** 2 * v["b"], "b": v["u"]}
    )
    assert close(BeamSearch().fit(data).next["a"], a + 0.4 * a**2 * b * u + 0.2 * a**2 * b)
    short = BeamSearch(search=SearchSettings(growth=3)).fit(data).next["a"]
    assert sympy.Poly(short.doit(), a, b, u).total_degree() == 3


def test_sine_and_cosine_of_declared_angles_only() -> None:
    layouts = Layouts(Layout.of(["a"]), Layout.of(["steer"]))
    data = drawn(["a"], ["steer"], lambda v: {"a": 0.5 * v["a"] * np.sin(2 * v["steer"])})
    assert data.layouts == layouts
    steer = symbol("steer")
    found = BeamSearch(angles=("steer",)).fit(data).next["a"]
    wanted = a + a * sympy.sin(steer) * sympy.cos(steer)
    assert all(abs(float((found - wanted).subs({a: p, steer: q}))) < 1e-6 for p, q in [(0.3, 0.7), (-1.0, 1.2)])
    assert not BeamSearch().fit(data).next["a"].has(sympy.sin, sympy.cos)
    with pytest.raises(ShapeError, match="rad"):
        BeamSearch(angles=("a",)).fit(data)


def test_a_column_that_stays_or_climbs_steadily() -> None:
    equations = BeamSearch().fit(drawn("ab", "u", lambda _: {"a": np.zeros(1), "b": np.full(1, 0.3)}))
    assert equations.next["a"] == a
    assert close(equations.next["b"], b + 0.3)


@pytest.fixture(scope="module")
def learned() -> Equations:
    return BeamSearch().fit(flights(1))


def test_what_does_not_matter_does_not_appear(learned: Equations) -> None:
    for state in ("vx", "vz", "wx", "qw"):
        assert not any(learned.depends(state, position) for position in "xyz")


def test_predicts_unseen_flights(learned: Equations) -> None:
    unseen = flights(2)
    errors, spread = fit_quality(learned, unseen), (unseen.next_state - unseen.state).std(axis=0)
    for position, column in enumerate(unseen.layouts.state):
        assert errors[column] < 2e-3 * spread[position] + 5e-5, column


def test_every_equation_keeps_the_limit_of_nodes(learned: Equations) -> None:
    greedy = BeamSearch(nodes=40, wrench_nodes=0, degree=2, search=SearchSettings(parsimony=0.0, growth=3))
    for equations, limit in ((learned, 85), (greedy.fit(flights(1, count=3)), 40)):
        assert max(equations.complexity().values()) <= limit


def test_one_attitude_has_one_answer(learned: Equations) -> None:
    data = flights(3, count=2)
    model = compile_model(learned, dtype=torch.float64)
    state, action = torch.tensor(data.state[::40]), torch.tensor(data.action[::40])
    flip = torch.ones(13, dtype=torch.float64)
    flip[3:7] = -1
    torch.testing.assert_close(model(state * flip, action), model(state, action) * flip, rtol=0, atol=1e-13)


def test_leaving_out_terms_of_the_wrong_sign_is_the_fit_on_rows_of_both_signs() -> None:
    rng = np.random.default_rng(0)
    q, y = rng.normal(size=(60, 2)), rng.normal(size=60)
    both = Monomials.to_degree(2, 2)
    doubled = refit(np.vstack([both.evaluate(q), both.evaluate(-q)]), np.concatenate([y, y]), "l2")
    even = both.degrees % 2 == 0
    np.testing.assert_allclose(doubled[even], refit(both.where(even).evaluate(q), y, "l2"), atol=1e-12)
    np.testing.assert_allclose(doubled[~even], 0, atol=1e-12)


def test_absolute_errors_shrug_off_what_squares_do_not() -> None:
    data = drawn("ab", "u", lambda v: {"a": 0.1 * v["b"], "b": -0.3 * v["a"] + 0.5 * v["u"]})
    spoiled = data.next_state.copy()
    spoiled[::15, 1] += 3.0
    data = replace(data, next_state=spoiled)
    wanted = {"l1": 0.0, "l2": 0.0}
    for loss in wanted:
        found = sympy.Poly(BeamSearch(loss=loss).fit(data).next["b"].doit(), a, b, u)  # type: ignore[arg-type]
        wanted[loss] = abs(float(found.coeff_monomial(u)) - 0.5)
    assert wanted["l1"] < 1e-5
    assert wanted["l2"] > 1e-3


def test_least_absolute_errors_agree_with_linear_programming() -> None:
    from scipy.optimize import linprog

    rng = np.random.default_rng(3)
    columns = rng.normal(size=(50, 3))
    target = columns @ [1.0, -2.0, 0.5] + rng.laplace(size=50)
    bound = np.block([[columns, -np.eye(50)], [-columns, -np.eye(50)]])
    best = linprog(np.r_[np.zeros(3), np.ones(50)], bound, np.r_[target, -target], bounds=(None, None))
    loss = np.abs(target - columns @ refit(columns, target, "l1")).sum()
    assert loss <= best.fun * (1 + 1e-3)


def test_finds_the_best_subset_that_exhaustive_search_finds() -> None:
    from itertools import combinations

    rng = np.random.default_rng(5)
    columns = rng.normal(size=(40, 9)) @ rng.normal(size=(9, 9))
    target = columns @ (rng.normal(size=9) * (rng.uniform(size=9) < 0.5)) + 0.3 * rng.normal(size=40)
    norms = np.linalg.norm(columns, axis=0)
    normed = columns / norms
    found = beam_search(normed.T @ normed, normed.T @ target, float(target @ target), width=8, branch=6, limit=4)

    def loss(chosen: tuple[int, ...]) -> float:
        rest = columns[:, list(chosen)]
        return float(np.sum((target - rest @ np.linalg.lstsq(rest, target, rcond=None)[0]) ** 2))

    for size in (1, 2, 3, 4):
        best = min(map(loss, combinations(range(9), size)))
        assert loss(found[size]) == pytest.approx(best, rel=1e-9)


def test_what_is_known_without_a_column_is_what_the_others_say() -> None:
    rng = np.random.default_rng(6)
    columns, target = rng.normal(size=(50, 12)) @ rng.normal(size=(12, 12)), rng.normal(size=50)
    columns /= np.linalg.norm(columns, axis=0)
    given = columns.T @ columns, columns.T @ target, float(target @ target)
    chosen = (7, 2, 9, 4)
    losses, gains = without_each(support_of(chosen, *given), given[1])
    for place, dropped in enumerate(chosen):
        rest = support_of(tuple(column for column in chosen if column != dropped), *given)
        assert losses[place] == pytest.approx(rest.loss, rel=1e-9)
        np.testing.assert_allclose(gains[place], rest.gains(), atol=1e-9)


def test_the_same_data_give_the_same_equations() -> None:
    data, engine = flights(4, count=2), BeamSearch(degree=2, search=SearchSettings(growth=3))
    assert engine.fit(data).to_json() == engine.fit(data).to_json()


def products(expression: sympy.Expr) -> set[sympy.Expr]:
    """The terms of a sum without the numbers in front."""
    return {term.as_coeff_Mul()[1] for term in sympy.Add.make_args(sympy.expand(expression.doit()))}


def test_rows_of_another_regime_do_not_hide_what_the_many_obey() -> None:
    data = drawn("ab", "u", lambda v: {"a": 0.1 * v["b"], "b": 0.5 * v["u"] + 0.1 * v["a"] * v["b"]}, rows=400)
    slipping = data.next_state.copy()
    slipping[::24, 1] += 1.5
    slipping[12::24, 1] -= 1.5
    found = BeamSearch().fit(replace(data, next_state=slipping)).next["b"]
    assert close(found, b + 0.5 * u + 0.1 * a * b, tolerance=1e-3)


def test_a_warm_start_refits_where_the_newest_flight_is_no_surprise(learned: Equations) -> None:
    again = BeamSearch().fit(concatenated(flights(1), flights(2, count=1, wild=0.7)), learned)
    for column, expression in again.next.items():
        assert products(expression) == products(learned.next[column])
    assert again.next["vx"] != learned.next["vx"]


def test_a_warm_start_searches_what_the_newest_flight_contradicts() -> None:
    """One law for both flights: the calm one hides the drag and shows all of ``a``: commands are as large there."""

    def system(size: float, seed: int) -> Transitions:
        flown = drawn("ab", "u", lambda v: {"a": 0.1 * v["u"], "b": v["u"] - 0.2 * v["b"] ** 3}, seed=seed, size=size)
        noise = 1e-4 * np.random.default_rng(seed).standard_normal(flown.state.shape)
        return replace(flown, next_state=flown.next_state + noise)

    calm, wild = system(0.05, 1), system(2.0, 2)
    start = BeamSearch().fit(calm)
    found = BeamSearch().fit(concatenated(calm, wild), start)
    assert products(found.next["a"]) == products(start.next["a"])
    assert not start.next["b"].doit().has(b**3)
    assert found.next["b"].doit().has(b**3)


def test_too_few_rows_are_refused() -> None:
    data = flights(1, count=1)
    with pytest.raises(ModelError, match="at least 20"):
        BeamSearch().fit(data.where(np.arange(len(data)) < 10))


def test_equations_with_columns_that_rows_lack_are_not_judged_by_them() -> None:
    hidden = replace(Layout.of(["lag"]).fields[0], hidden=True)
    layouts = Layouts(Layout((*Layout.of(["a", "b"]).fields, hidden)), Layout.of(["u"]))
    equations = Equations.parse(layouts, {"a": "b", "b": "lag", "lag": "u"}, dt=0.1, start={"lag": "u"})
    with pytest.raises(ShapeError, match="found none of lag"):
        fit_quality(equations, drawn("ab", "u", lambda v: {"a": v["b"], "b": v["u"]}))


def test_engines_are_named() -> None:
    assert list(ENGINES) == ["beam", "pysr", "operon"]
    assert ENGINES["beam"] is BeamSearch
