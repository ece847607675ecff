"""Effects with memory against closed forms, and in a controller against the whole series."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch
from torch import Tensor

from sym2real.effects import compose, effect
from sym2real.effects.filters import FilterState, filter_commands
from sym2real.errors import ModelError
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import symbol

DT = CRAZYFLIE.dt


@pytest.fixture
def commands() -> Tensor:
    """# (30, action)"""
    return torch.as_tensor(np.random.default_rng(3).standard_normal((30, 4)))


MEMORIES = (
    "limit:wx_cmd",
    "delay",
    "lag",
    "rate_limit:wx_cmd",
    "dead_band:wx_cmd",
    "dead_zone:wx_cmd",
    "sensor_lag:vz",
    "time_shift:vz",
)


@pytest.mark.parametrize("key", MEMORIES)
def test_the_null_value_is_the_identity(key: str) -> None:
    found = effect(key, CRAZYFLIE)
    columns = 13 if found.of.columns == "state" else 4
    rows = torch.as_tensor(np.random.default_rng(0).standard_normal((20, columns)))
    torch.testing.assert_close(found.filter(rows, DT, found.null), rows, rtol=0, atol=1e-12)


@pytest.mark.parametrize("key", ["delay", "lag", "sensor_lag:vz", "time_shift:vz"])
def test_small_times_shift_in_proportion(key: str) -> None:
    """A derivative at zero that is finite and not zero, so that a fit can leave zero."""
    found = effect(key, CRAZYFLIE)
    rows = torch.linspace(0, 1, 20, dtype=torch.float64)[:, None].expand(20, 13 if "v" in key else 4).clone()
    slope = (rows[1, 0] - rows[0, 0]) / DT
    moved = found.filter(rows, DT, {"value": 1e-6}) - rows
    column = found.filtered_columns[0]
    torch.testing.assert_close(moved[5:, column], torch.full_like(moved[5:, column], -1e-6 * slope), rtol=1e-3, atol=0)


def test_whole_delays_shift_bit_by_bit_and_hold_the_first_row(commands: Tensor) -> None:
    late = effect("delay:thrust", CRAZYFLIE).filter(commands, DT, {"value": 3 * DT})
    assert torch.equal(late[3:, 0], commands[:-3, 0])
    assert torch.equal(late[:3, 0], commands[0, 0].expand(3))
    assert torch.equal(late[:, 1:], commands[:, 1:])


def test_fractions_of_a_period_are_blended(commands: Tensor) -> None:
    late = effect("delay:thrust", CRAZYFLIE).filter(commands, DT, {"value": 1.25 * DT})
    torch.testing.assert_close(late[2:, 0], 0.75 * commands[1:-1, 0] + 0.25 * commands[:-2, 0])


FINE = 2000  # parts of a period


def end_of_periods(gain: float, moving: np.ndarray) -> np.ndarray:
    """Where a loop ẋ = K (u - x) stands after each period, whose command moves within it ``# (periods, parts)``."""
    rates, rate = [], 0.0
    for period in moving:
        for command in period:
            rate = command + (rate - command) * math.exp(-gain * DT / FINE)
        rates.append(rate)
    return np.array(rates)


@pytest.mark.parametrize(
    ("key", "value"), [("delay", 0.25), ("delay", 1.6), ("lag", 0.3), ("lag", 2.0), ("rate_limit", 60.0)]
)
@pytest.mark.parametrize("axis", ["x", "z"])
def test_behind_a_rate_loop_a_period_ends_where_the_moving_command_leads(
    key: str, value: float, axis: str, commands: Tensor
) -> None:
    """The command moves within the period, and the loop is integrated in small steps; the filter gives one number."""
    found, gain = effect(f"{key}:w{axis}_cmd", CRAZYFLIE), CRAZYFLIE.numbers[f"k{axis}"]
    column, time = CRAZYFLIE.layouts.action.index(f"w{axis}_cmd"), value * (1.0 if key == "rate_limit" else DT)
    sent = commands[:, column].numpy()
    at = (np.arange(len(sent) * FINE) + 0.5) / FINE
    if key == "delay":
        acting = sent[np.clip(np.floor(at - value).astype(int), 0, None)]
    else:
        acting, now = np.empty(len(at)), sent[0]
        for place, row in enumerate(np.floor(at).astype(int)):
            if key == "rate_limit":
                now = acting[place] = now + np.clip(sent[row] - now, -value * DT / FINE, value * DT / FINE)
                continue
            now = acting[place] = sent[row] + (now - sent[row]) * math.exp(-DT / FINE / time)
    filtered = found.filter(commands, DT, {"value": time})[:, column].numpy()
    ends = [
        end_of_periods(gain, moving) for moving in (acting.reshape(-1, FINE), np.repeat(filtered[:, None], FINE, 1))
    ]
    np.testing.assert_allclose(ends[1], ends[0], atol=5e-3)


def test_a_batch_of_values_gives_what_they_give_one_by_one(commands: Tensor) -> None:
    for key in MEMORIES[1:5]:
        found = effect(key, CRAZYFLIE)
        sizes = torch.tensor([0.013, 0.0, 0.05, 0.3], dtype=torch.float64) + (1.0 if "rate" in key else 0.0)
        together = found.filter(commands, DT, {"value": sizes})
        assert together.shape == (4, 30, 4)
        for size, one in zip(sizes, together, strict=True):
            torch.testing.assert_close(one, found.filter(commands, DT, {"value": float(size)}))


def test_a_lag_is_the_mean_of_a_first_order_response() -> None:
    step, time = torch.zeros(12, 4, dtype=torch.float64), 0.05
    step[2:] = 1.0
    lagging = effect("lag:thrust", CRAZYFLIE).filter(step, DT, {"value": time})
    fine = np.linspace(0, 10 * DT, 100001)
    response = 1 - np.exp(-fine / time)
    means = [response[(fine >= k * DT) & (fine <= (k + 1) * DT)].mean() for k in range(10)]
    np.testing.assert_allclose(lagging[2:, 0], means, atol=1e-4)


def test_a_rate_limit_ramps_then_holds() -> None:
    step = torch.zeros(6, 2, dtype=torch.float64)
    step[1:, 0] = 0.075
    steer, speed = (effect(f"rate_limit:{column}", MUSHR).filter for column in ("steer", "speed"))
    # Of the steering that a gyro shows it is the end of a period, else the mean over it.
    np.testing.assert_allclose(steer(step, 0.05, {"value": 1.0})[:, 0], [0, 0.05, 0.075, 0.075, 0.075, 0.075])
    rows = speed(step.flip(1), 0.05, {"value": 1.0})[:, 1]
    np.testing.assert_allclose(rows, [0, 0.025, 0.06875, 0.075, 0.075, 0.075], atol=1e-12)


def test_a_dead_band_is_play_in_a_linkage_and_a_dead_zone_rest_around_zero() -> None:
    rows = torch.tensor([[0.0, 0.5], [0.1, 0.1], [0.05, -0.1], [-0.1, -0.5]], dtype=torch.float64)
    play = effect("dead_band:steer", MUSHR).filter(rows, 0.05, {"value": 0.1})
    np.testing.assert_allclose(play[:, 0], [0.0, 0.05, 0.05, -0.05], atol=1e-12)
    rest = effect("dead_zone:speed", MUSHR).filter(rows, 0.05, {"value": 0.2})
    np.testing.assert_allclose(rest[:, 1], [0.5, 0.0, 0.0, -0.5], atol=1e-12)
    nothing = effect("dead_zone:speed", MUSHR).filter(rows, 0.05, {"value": 0.0})
    torch.testing.assert_close(nothing, rows, rtol=0, atol=0)


def test_a_controller_that_remembers_sees_what_the_whole_series_gives(commands: Tensor) -> None:
    chosen = [
        (effect("lag:wx_cmd", CRAZYFLIE), {"value": 0.07}),
        (effect("delay", CRAZYFLIE), {"value": 0.047}),
        (effect("dead_band:wz_cmd", CRAZYFLIE), {"value": 0.5}),
        (effect("rate_limit:thrust", CRAZYFLIE), {"value": 20.0}),
    ]
    equations = compose(CRAZYFLIE.nominal(), chosen)
    assert [key for key, _ in equations.filters] == ["delay", "rate_limit:thrust", "lag:wx_cmd", "dead_band:wz_cmd"]
    whole = filter_commands(equations, commands)
    state = FilterState(equations)
    for row in commands[:20]:
        state.remember(row)
    candidates = torch.stack([commands[20:], -commands[20:]])
    ahead = state.apply(candidates)
    torch.testing.assert_close(ahead[0], whole[20:])
    torch.testing.assert_close(ahead, state.apply(candidates))  # planning advances nothing
    state.reset()
    torch.testing.assert_close(state.apply(commands), whole)


def test_values_of_filters_may_be_parameters(commands: Tensor) -> None:
    found = effect("lag", CRAZYFLIE)
    equations = found.substitute(CRAZYFLIE.nominal(), found.symbols())
    assert equations.parameters == {"lag_value": 0.0}
    torch.testing.assert_close(filter_commands(equations, commands), commands)
    batch = found.filter(commands, equations.dt, {"value": torch.tensor([0.0, 0.05], dtype=torch.float64)})
    torch.testing.assert_close(batch[0], commands)
    torch.testing.assert_close(batch[1], filter_commands(equations.at(lag_value=0.05), commands))
    mixed = found.substitute(CRAZYFLIE.nominal(), {"value": 2 * symbol("mine")})
    with pytest.raises(ModelError, match="number or a parameter"):
        filter_commands(mixed, commands)


def test_a_measured_lag_follows_a_ramp_by_its_time_constant() -> None:
    rows = torch.linspace(0, 4, 201, dtype=torch.float64)[:, None].expand(201, 13)
    lagging = effect("sensor_lag:x", CRAZYFLIE).filter(rows, DT, {"value": 0.1})
    assert float(rows[-1, 0] - lagging[-1, 0]) == pytest.approx(0.1 * 0.02 / DT, rel=1e-9)
    early = effect("time_shift:x", CRAZYFLIE).filter(rows, DT, {"value": -0.03})
    torch.testing.assert_close(early[:-3, 0], rows[:-3, 0] + 0.03)


def test_a_static_effect_is_no_filter(commands: Tensor) -> None:
    with pytest.raises(ModelError, match="no memory"):
        effect("gain:thrust", CRAZYFLIE).filter(commands, DT, {"value": 2.0})
    assert math.isfinite(effect("rate_limit:thrust", CRAZYFLIE).null["value"])
