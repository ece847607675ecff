"""Wrench inputs and the dependence check, on a rigid body that the tests integrate themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy
from regression_data import DT, INERTIA, MASS, QUADROTOR, concatenated, evaluate, flights

from sym2real.errors import ModelError, UnknownNameError
from sym2real.regression import BeamSearch, SearchSettings, dependence, fit_quality, require_dependence
from sym2real.regression.numeric import columns_of
from sym2real.symbolic import Equations, symbol

PAIRS = [("vx", "thrust"), ("vz", "thrust"), ("wx", "wx_cmd"), ("wz", "wz_cmd")]
NO_WRENCH = dict.fromkeys(QUADROTOR.inputs, 0.0)
NO_WRENCH_SYMBOLS = {symbol(name): 0.0 for name in NO_WRENCH}


@pytest.fixture(scope="module")
def learned() -> Equations:
    return BeamSearch().fit(concatenated(flights(1), flights(2, pushed=True)))


def test_a_push_accelerates_by_force_over_mass(learned: Equations) -> None:
    calm = {column: np.zeros(1) for column in learned.columns} | {"qw": np.ones(1), "thrust": np.full(1, 0.265)}
    for velocity, force in (("vx", "fx"), ("vy", "fy"), ("vz", "fz")):
        slope = evaluate(sympy.diff(learned.next[velocity].doit(), symbol(force)), calm)
        assert float(slope[0]) == pytest.approx(DT / MASS, rel=0.01)
    slope = evaluate(sympy.diff(learned.next["wy"].doit(), symbol("ty")), calm)
    # A first-order rate loop of gain 50 1/s, stepped at 500 Hz: the torque acts for (1 − 0.9¹⁰)/50 s.
    assert float(slope[0]) == pytest.approx((1 - 0.9**10) / 50 / INERTIA[1], rel=0.02)


def test_pushed_flights_never_seen_are_predicted(learned: Equations) -> None:
    unseen = flights(7, pushed=True)
    errors, spread = fit_quality(learned, unseen), (unseen.next_state - unseen.state).std(axis=0)
    blind = fit_quality(learned.substitute(NO_WRENCH), unseen)
    for position, column in enumerate(QUADROTOR.state):
        assert errors[column] < 0.01 * spread[position] + 3e-5, column
    for column in ("vx", "vy", "vz", "wx", "wy", "wz"):
        assert errors[column] < 0.05 * blind[column]


@pytest.mark.slow
def test_without_a_wrench_the_equations_are_those_of_the_unpushed_flights() -> None:
    """Whatever the degree: the wrench is fitted to what the unpushed flights' equations leave."""
    unpushed, search = flights(1, count=2), BeamSearch(degree=2, search=SearchSettings(growth=3))
    learned, alone = search.fit(concatenated(unpushed, flights(2, count=2, pushed=True))), search.fit(unpushed)
    rows = columns_of(flights(3))
    for column in QUADROTOR.state:
        stripped = learned.next[column].doit().xreplace(NO_WRENCH_SYMBOLS)
        np.testing.assert_allclose(evaluate(stripped, rows), evaluate(alone.next[column], rows), rtol=0, atol=1e-9)


def test_every_equation_keeps_the_limit_of_nodes_with_a_wrench(learned: Equations) -> None:
    assert max(learned.complexity().values()) <= 85


def test_every_wrench_term_is_linear_in_one_wrench_column(learned: Equations) -> None:
    wrench = [symbol(name) for name in QUADROTOR.inputs]
    for expression in learned.next.values():
        terms = sympy.Poly(expression.doit(), *wrench).monoms()
        assert {sum(term) for term in terms} <= {0, 1}


def test_the_switch_turns_wrench_terms_off() -> None:
    data = concatenated(flights(1, count=2), flights(2, count=2, pushed=True))
    equations = BeamSearch(wrench=False, degree=2).fit(data)
    assert not any(equations.depends(column, name) for column in QUADROTOR.state for name in QUADROTOR.inputs)


def test_wrench_terms_survive_a_warm_start_on_unpushed_flights(learned: Equations) -> None:
    again = BeamSearch(degree=2).fit(concatenated(flights(1), flights(8, count=1, wild=0.7)), learned)
    for column in ("vx", "wy"):
        for name in ("fx", "ty"):
            assert again.depends(column, name) == learned.depends(column, name)
    assert max(again.complexity().values()) <= 85


def test_only_pushed_flights_are_refused() -> None:
    with pytest.raises(ModelError, match="without wrench"):
        BeamSearch().fit(flights(2, count=2, pushed=True))


def test_dependence_matches_finite_differences(learned: Equations) -> None:
    data = flights(1)
    columns = columns_of(data)
    nudge = 1e-4
    row = next(row for row in dependence(learned, data, PAIRS) if (row.state, row.action) == ("vx", "thrust"))
    moved = [evaluate(learned.next["vx"], columns | {"thrust": columns["thrust"] + sign * nudge}) for sign in (1, -1)]
    slope = (moved[0] - moved[1]) / (2 * nudge)
    increments = data.next_state[:, 7] - data.state[:, 7]
    score = np.sqrt(np.mean(slope**2)) * columns["thrust"].std() / increments.std()
    assert row.score == pytest.approx(float(score), rel=1e-6)
    assert row.holds


def test_dependence_of_a_learned_model_holds_and_lift_is_right(learned: Equations) -> None:
    table = require_dependence(learned, flights(1), PAIRS)
    assert [(row.state, row.action) for row in table[:-1]] == PAIRS
    assert table[-1].score == pytest.approx(DT / MASS, rel=0.01)


def test_losing_thrust_fails_loudly(learned: Equations) -> None:
    numb = learned.substitute({"thrust": 0.265})
    assert not any(row.holds for row in dependence(numb, flights(1), [("vz", "thrust")]))
    with pytest.raises(ModelError, match=r"thrust → vz(.|\n)*[Vv]ary thrust"):
        require_dependence(numb, flights(1), PAIRS)


def test_thrust_that_pulls_down_fails(learned: Equations) -> None:
    upside_down = learned.substitute({"thrust": 0.53 - symbol("thrust")})
    *pairs, lift = dependence(upside_down, flights(1), PAIRS)
    assert all(row.holds for row in pairs)
    assert not lift.holds
    assert lift.score < 0


def test_an_action_that_never_varied_cannot_hold(learned: Equations) -> None:
    data = flights(1)
    action = data.action.copy()
    action[:, 0] = 0.265
    row = dependence(learned, replace(data, action=action), [("vz", "thrust")])[0]
    assert np.isnan(row.score)
    assert not row.holds


def test_unknown_columns_are_named(learned: Equations) -> None:
    with pytest.raises(UnknownNameError, match="thrust"):
        dependence(learned, flights(1), [("vz", "thrsut")])
