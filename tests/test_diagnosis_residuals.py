"""One-step residuals accuse nobody by chance, and name the command and the lag where a delay is real."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from sym2real.correlations import autocorrelation, centred, cross_correlations, cross_deviation, summed_lags
from sym2real.dataset import Dataset
from sym2real.diagnosis import compare
from sym2real.diagnosis.errors.residuals import Residual, Residuals, one_step_residuals, residual_of, tangent_units
from sym2real.layout import Layout, Layouts
from sym2real.robots import ROBOTS
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Trajectory

LINE = Layouts(Layout.of(["x", "vx"]), Layout.of(["speed"]))
DT = 0.02
# A trolley that takes up its speed command with a time constant of 0.1 s.
TROLLEY = Equations.parse(LINE, {"x": "x + 0.02*vx", "vx": "vx + 0.2*(speed - vx)"}, DT)
LAGS = 25


def memory(rng: np.random.Generator, rows: int, coefficient: float) -> Array:
    """A stationary autoregression of order one ``# (rows,)``."""
    settled: Array = lfilter([1.0], [1.0, -coefficient], rng.normal(size=rows + 300))[300:]
    return settled


def found_in(residual: Residual | None, rows: int) -> Residuals:
    assert residual is not None
    return Residuals(DT, rows, LAGS, {"vx": residual})


def driven(rng: np.random.Generator, rows: int = 800, delay: int = 0, noise: float = 0.02) -> Trajectory:
    """A trolley that obeys a command of so many rows before, pushed a little at random; measured exactly."""
    sent = memory(rng, rows, 0.8)
    state = np.zeros((rows, 2))
    for row in range(rows - 1):
        x, v = state[row]
        push = noise * rng.normal()
        state[row + 1] = x + DT * v, v + 0.2 * (sent[max(row - delay, 0)] - v) + push
    return Trajectory(DT * np.arange(rows), state, sent[:, None], np.zeros((rows, 0)), LINE)


def test_independent_series_with_memory_stay_within_the_bands() -> None:
    inside, naive = [], []
    for seed in range(150):
        rng = np.random.default_rng(seed)
        one, other = (centred([memory(rng, 500, 0.9)]) for _ in range(2))
        far = summed_lags(one)
        deviation = cross_deviation(500, autocorrelation(one, far), autocorrelation(other, far))
        size = np.abs(cross_correlations(one, other, 20)[[10, 20, 30, 40]])
        inside += list(size < 1.96 * deviation)
        naive += list(size < 1.96 / np.sqrt(500))
    assert 0.92 < np.mean(inside) < 0.98
    assert np.mean(naive) < 0.6


def test_autocorrelation_is_the_sum_of_products() -> None:
    rng = np.random.default_rng(0)
    pieces = centred([rng.normal(size=60), rng.normal(size=8), rng.normal(size=31)])
    expected = cross_correlations(pieces, pieces, 12)
    np.testing.assert_allclose(autocorrelation(pieces, 12), expected[13:], atol=1e-12)
    assert expected[12] == pytest.approx(1.0)


def test_a_series_follows_one_that_it_repeats_later() -> None:
    earlier = np.random.default_rng(0).normal(size=40)
    later = np.concatenate([np.zeros(3), earlier[:-3]])
    short = np.array([1.0, -1.0])  # shorter than the lags
    found = cross_correlations([later, short], [earlier, short], 5)
    assert found.argmax() == 5 + 3
    sizes = np.sqrt((later @ later + 2.0) * (earlier @ earlier + 2.0))
    assert found[5 + 3] == pytest.approx(float(later[3:] @ earlier[:-3]) / sizes)
    assert found[5 - 1] == pytest.approx((float(later[:-1] @ earlier[1:]) - 1.0) / sizes)


@pytest.mark.parametrize("differenced", [False, True], ids=["white", "sensor noise"])
def test_noise_passes_for_white_in_nineteen_of_twenty(differenced: bool) -> None:
    passed = []
    for seed in range(300):
        noise = np.random.default_rng(seed).normal(size=401)
        noise = np.diff(noise) if differenced else noise[1:]
        passed.append(not found_in(residual_of(centred([noise]), {}, LAGS, "m/s"), 400).coloured)
    assert 0.91 < np.mean(passed) <= 0.995


def test_what_lasts_is_not_white() -> None:
    for seed in range(10):
        slow = memory(np.random.default_rng(seed), 400, 0.4)
        assert found_in(residual_of(centred([slow]), {}, LAGS, "m/s"), 400).coloured == ("vx",)


def test_a_complete_model_raises_no_suspicion() -> None:
    suspicious = [
        bool(one_step_residuals(TROLLEY, Dataset([driven(np.random.default_rng(seed))])).suspicious())
        for seed in range(40)
    ]
    # Two of forty are expected; seven or more have a probability of 0.3 %.
    assert sum(suspicious) < 7


@pytest.mark.parametrize("delay", [1, 3, 6])
def test_a_delayed_command_shows_at_its_lag(delay: int) -> None:
    logs = Dataset([driven(np.random.default_rng(seed), 300, delay) for seed in range(3)])
    found = one_step_residuals(TROLLEY, logs)
    causal = found.components["vx"].commands["speed"].causal
    assert int(causal.argmax()) == delay
    assert int(causal.argmin()) == 0
    assert found.suspicious() == {"speed": "vx"}
    (said,) = [line for line in found.lines() if "follows" in line]
    assert f"speed {delay} row{'s' if delay > 1 else ''} earlier" in said
    assert "of the same row" in said


def test_a_wrong_gain_shows_in_the_same_row() -> None:
    log = driven(np.random.default_rng(0))
    (said,) = one_step_residuals(TROLLEY, Dataset([replace(log, action=0.5 * log.action)])).lines()[1:]
    assert "follows speed of the same row" in said
    assert "noise" not in said


def test_a_loop_that_answers_noise_is_said_to_do_so() -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        truth, measured, sent = np.zeros(2), np.zeros((600, 2)), np.zeros(600)
        for row in range(600):
            measured[row] = truth + rng.normal(size=2) * [0.005, 0.15]
            sent[row] = 0.1 * rng.normal() - 2.0 * measured[row, 0] - 1.5 * measured[row, 1]
            truth = np.array([truth[0] + DT * truth[1], truth[1] + 0.2 * (sent[row] - truth[1])])
        log = Trajectory(DT * np.arange(600), measured, sent[:, None], np.zeros((600, 0)), LINE)
        (said,) = one_step_residuals(TROLLEY, Dataset([log])).lines()[1:]
        assert said.endswith("a loop that answers sensor noise may do that")


def test_logs_do_not_touch_each_other() -> None:
    long = driven(np.random.default_rng(1), 600, 2)
    shifted = replace(long, state=long.state + np.array([50.0, 0.0]))
    one, both = (one_step_residuals(TROLLEY, Dataset(logs)) for logs in ([long], [long, shifted]))
    pair = [found.components["vx"].commands["speed"].correlation for found in (one, both)]
    np.testing.assert_allclose(pair[0], pair[1], atol=1e-9)


def test_names_of_a_rotation_are_those_of_its_axes() -> None:
    units = tangent_units(ROBOTS["crazyflie"].layouts.state)
    assert units["attitude y"] == "rad"
    assert len(units) == ROBOTS["crazyflie"].layouts.state.tangent_size
    assert tangent_units(ROBOTS["mushr"].layouts.state)["yaw"] == "rad"


def test_a_comparison_holds_them_and_leaves_out_what_is_exact() -> None:
    result = compare(TROLLEY, driven(np.random.default_rng(2), delay=2)).to_dict()["residuals"]
    assert list(result["components"]) == ["vx"]
    series = result["components"]["vx"]["commands"]["speed"]
    assert len(series["values"]) == 2 * result["lags"] + 1
    assert 1.96 / np.sqrt(result["rows"]) <= series["band"] < 0.5
    assert any("speed" in line for line in result["lines"])
