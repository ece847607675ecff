"""Equations from measured rows: what noise hides of a step is found over windows, and noise itself is no equation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset, Transitions
from sym2real.diagnosis import compare
from sym2real.layout import Layout, Layouts
from sym2real.regression import SearchSettings
from sym2real.regression.beam import BeamSearch
from sym2real.regression.features import Variables
from sym2real.regression.free_run import FreeRuns, plainest
from sym2real.regression.monomials import Monomials
from sym2real.regression.polynomial import Polynomial
from sym2real.regression.search import beam_search
from sym2real.regression.windows import MEASURED, Values, Windows
from sym2real.robots import CRAZYFLIE, Robot
from sym2real.symbolic import symbol
from sym2real.trajectory import Array, Trajectory


def runs(robot: Robot, seed: int) -> Dataset:
    """Four noisy runs, as a localisation and a gyro would log them, whose logs do not have the wrench."""
    known = robot.layouts
    layouts = Layouts(known.state, known.action)
    logs = simulate_case(Case(robot.name, seed=seed), trajectories=4)
    return Dataset(replace(log, inputs=np.zeros((len(log), 0)), layouts=layouts) for log in logs)


@pytest.mark.slow
def test_noisy_logs_give_equations_that_predict() -> None:
    """Step by step the velocity of a quadrotor seems to stay what it is, and its error is several times as large.

    What a car's logs give is in ``test_level_ground.py``.
    """
    search = BeamSearch(degree=2, search=SearchSettings(growth=3))
    learned, other = runs(CRAZYFLIE, 5).transitions(), runs(CRAZYFLIE, 6)
    by_step, by_windows = (
        compare(replace(search, windows=windows).fit(learned), other).at(0.8).errors["position"].value
        for windows in ((1,), MEASURED)
    )
    assert by_windows < 0.08
    assert by_windows < by_step / 2


def follower(noise: float, rows: int = 300, logs: int = 4) -> Transitions:
    """A speed follows its command, a rate does nothing; both measured with noise."""
    layouts, found = Layouts(Layout.of(["vx", "wz"]), Layout.of(["steer", "speed"])), []
    rng = np.random.default_rng(11)
    for number in range(logs):
        sent, state = rng.standard_normal((rows, 2)), np.zeros((rows, 2))
        for row in range(1, rows):
            state[row, 0] = 0.8 * state[row - 1, 0] + 0.2 * sent[row - 1, 1]
        measured = state + noise * rng.standard_normal(state.shape)
        found.append(Trajectory(0.05 * np.arange(rows), measured, sent, np.zeros((rows, 0)), layouts, name=str(number)))
    return Dataset(found).transitions()


def test_averages_of_a_sum_are_the_sum_of_averages_and_no_window_leaves_its_log() -> None:
    rows = follower(0.1, rows=50)
    values, terms = np.c_[rows.state, rows.action], Monomials.to_degree(4, 2)
    windows = Windows.of(rows, 8)
    numbers = np.random.default_rng(3).standard_normal(len(terms))
    averaged = Values(values, windows).of(terms) @ numbers
    np.testing.assert_allclose(averaged, windows.averaged(Polynomial(terms, numbers).evaluate(values)), atol=1e-12)
    ends = windows.starts + windows.rows - 1
    assert (rows.trajectory[windows.starts] == rows.trajectory[ends]).all()
    assert (rows.step[ends] - rows.step[windows.starts] == 7).all()
    assert len(windows.starts) == 4 * len(range(0, 49 - 8 + 1, 2))


@pytest.mark.parametrize("level", [True, False], ids=["a level and what varies about it", "two that are alike"])
def test_columns_that_explain_only_together_are_found_among_others(level: bool) -> None:
    """Alone each of the two explains less than noise seems to: thrust about weight, a rate and its command."""
    rng, ones = np.random.default_rng(4), np.ones(400)
    varies, others = rng.standard_normal((400, 2)), rng.standard_normal((400, 60))
    pair = np.c_[ones, 1.0 + 0.01 * varies[:, 0]] if level else rng.standard_normal((400, 1)) + 0.1 * varies
    target = varies[:, 0] if level else pair[:, 0] - pair[:, 1]
    columns = np.c_[pair, others] if level else np.c_[ones, pair, others]
    columns = columns / np.linalg.norm(columns, axis=0)
    found = {
        together: beam_search(
            columns.T @ columns,
            columns.T @ target,
            float(target @ target),
            width=8,
            branch=6,
            limit=14,
            together=together,
        )
        for together in (False, True)
    }
    wanted = {0, 1} if level else {1, 2}
    assert set(found[True][2]) == wanted
    assert set(found[False][2]) != wanted


def test_noise_is_no_equation_and_a_lag_is_found_beside_it() -> None:
    equations = BeamSearch(windows=MEASURED).fit(follower(0.05))
    assert {str(symbol) for symbol in equations.next["wz"].free_symbols} == {"wz"}
    assert {str(symbol) for symbol in equations.next["vx"].free_symbols} == {"vx", "speed"}
    step = equations.next["vx"].subs({symbol("vx"): 0.0, symbol("speed"): 1.0})
    assert float(step) == pytest.approx(0.2, rel=0.1)


def test_a_free_run_is_the_recursion_and_the_plainest_of_equal_ones_is_taken() -> None:
    rows = follower(0.0)
    lag, still = (
        Polynomial(Monomials(np.array(p)), np.array(n))
        for p, n in (([[1, 0, 0, 0], [0, 0, 0, 1]], [-0.2, 0.2]), ([[1, 0, 0, 0]], [0.0]))
    )
    errors: list[Array] = [FreeRuns("vx", Variables.of(rows.layouts), rows, 20).squares(one) for one in (lag, still)]
    assert errors[0].max() < 1e-20
    assert errors[1].mean() > 0.01
    assert plainest([lag, still], errors) is lag
    assert plainest([lag, still], [errors[0], errors[0]]) is still


def test_what_forgets_a_noisy_start_runs_no_better_for_it() -> None:
    """A speed that stays as it is, smaller than its noise: from measured starts, to forget it would err less."""
    layouts, rng = Layouts(Layout.of(["vx"]), Layout.of(["speed"])), np.random.default_rng(3)
    logs = [
        Trajectory(
            0.05 * np.arange(200),
            speed + 0.1 * rng.standard_normal((200, 1)),
            *[np.zeros((200, k)) for k in (1, 0)],
            layouts,
        )
        for speed in (0.08, -0.08, 0.08, -0.08)
    ]
    runs = FreeRuns("vx", Variables.of(layouts), Dataset(logs).transitions(), 40)
    keeps, forgets = (Polynomial(Monomials(np.array([[1, 0]])), np.array([by])) for by in (0.0, -0.4))
    assert np.square(runs.run(keeps) - runs.measured).mean() > np.square(runs.run(forgets) - runs.measured).mean()
    assert runs.squares(keeps).mean() < 0.8 * runs.squares(forgets).mean()


@pytest.mark.parametrize("rows", [25, 60, 400])
def test_one_short_log_has_equations_without_a_warning(rows: int, recwarn: pytest.WarningsRecorder) -> None:
    log = follower(0.05, rows=rows, logs=1)
    assert BeamSearch(windows=MEASURED).fit(log).next.keys() == {"vx", "wz"}
    assert not [str(one.message) for one in recwarn]


def test_noise_of_a_column_does_not_shrink_what_it_keeps() -> None:
    """Row by row a noisy speed seems to forget faster than it does; in free runs the noise is the output's alone."""
    rows, lag = follower(0.2), Monomials(np.array([[1, 0, 0, 0], [0, 0, 0, 1]]))
    columns, change = rows.state[:, [0]], rows.next_state[:, 0] - rows.state[:, 0]
    columns = np.c_[columns, rows.action[:, [1]]]
    by_rows = Polynomial(lag, np.linalg.lstsq(columns, change, rcond=None)[0])
    assert by_rows.coefficients[0] < -0.3
    fitted = FreeRuns("vx", Variables.of(rows.layouts), rows, 40).fitted(by_rows)
    np.testing.assert_allclose(fitted.coefficients, [-0.2, 0.2], rtol=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("column", ["sin_yaw", "qx", "vx"])
def test_a_fit_of_free_runs_of_exact_rows_finds_their_numbers_from_others(column: str) -> None:
    """On a circle and a sphere too, where every step is put back on it."""
    robot = "crazyflie" if column == "qx" else "mushr"
    rows = simulate_case(Case(robot, seed=3), trajectories=2).transitions()
    variables = Variables.of(rows.layouts)
    terms = [["wz", "cos_yaw"]] if column == "sin_yaw" else [["wx", "qw"], ["wz", "qy"]] if column == "qx" else [["vx"]]
    powers = [[int(name in term) for name in (*variables.columns, *variables.wrench)] for term in terms]
    polynomial = Polynomial(Monomials(np.array(powers)), np.full(len(terms), 0.02))
    runs = FreeRuns(column, variables, rows, 30)
    runs.measured = runs.run(polynomial)
    found = runs.fitted(Polynomial(polynomial.terms, np.full(len(terms), 0.01)))
    np.testing.assert_allclose(found.coefficients, 0.02, rtol=1e-6)


@pytest.mark.parametrize("rate", [1.0, 4.0])
def test_a_fast_turn_is_neither_too_large_nor_too_small(rate: float) -> None:
    """On the tangent a step of the heading is tan(ω dt); measured from the circle its number would be 2 % too large."""
    layouts, dt = Layouts(Layout.of(["sin_yaw", "cos_yaw", "wz"]), Layout.of(["steer"])), 0.05
    time = dt * np.arange(200)
    rates = rate * np.sign(np.sin(2.0 * time))
    yaw = np.r_[0.0, np.cumsum(dt * rates)[:-1]]
    state, still = np.stack([np.sin(yaw), np.cos(yaw), rates], axis=1), np.zeros((200, 1))
    rows = Dataset([Trajectory(time, state, still, np.zeros((200, 0)), layouts, name="turns")]).transitions()
    turn = Polynomial(Monomials(np.array([[0, 1, 1, 0]])), np.array([dt]))
    fitted = FreeRuns("sin_yaw", Variables.of(layouts), rows, 20).fitted(turn)
    assert float(fitted.coefficients[0]) == pytest.approx(np.tan(rate * dt) / rate, rel=3e-3)


def test_a_row_that_is_far_off_moves_no_number() -> None:
    """A glitch of ten metres a second in one of 1200 rows."""
    rows, lag = follower(0.02), Polynomial(Monomials(np.array([[1, 0, 0, 0], [0, 0, 0, 1]])), np.array([-0.2, 0.2]))
    following = rows.next_state.copy()
    following[200, 0] += 10.0
    state = rows.state.copy()
    state[201, 0] += 10.0
    wild = replace(rows, state=state, next_state=following)
    fitted = FreeRuns("vx", Variables.of(rows.layouts), wild, 40).fitted(lag)
    np.testing.assert_allclose(fitted.coefficients, [-0.2, 0.2], rtol=0.05)
