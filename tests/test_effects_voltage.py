"""The battery's voltage: bound to equations that know nothing of it, smoothed, and found again from a flight."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
import torch
from rich.console import Console

from sym2real.dataset import Dataset
from sym2real.effects import compose, effect
from sym2real.effects.inputs import with_common_clock
from sym2real.effects.voltage import settled, voltage_at_start, with_voltage
from sym2real.report.effects import effect_page
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import build_module
from sym2real.trajectory import Trajectory

ROWS = 1000
time = np.arange(ROWS) * CRAZYFLIE.dt
falling = 4.0 - 0.01 * time


def flight(voltage: np.ndarray) -> Trajectory:
    state, action = np.tile(CRAZYFLIE.start, (ROWS, 1)), np.tile(CRAZYFLIE.rest, (ROWS, 1))
    inputs = np.zeros((ROWS, len(CRAZYFLIE.layouts.inputs)))
    return Trajectory(time, state, action, inputs, CRAZYFLIE.layouts, extra={"vbat": voltage})


def test_thrust_falls_by_the_share_per_volt_below_the_reference() -> None:
    plain = CRAZYFLIE.nominal()
    bound = with_voltage(plain, 3.9)
    assert bound.layouts.inputs.columns == (*plain.layouts.inputs.columns, "vbat")
    sagging = effect("battery_sag", bound)
    assert sagging.parameters[0].unit == "1/V"
    assert effect("battery_sag", plain).parameters[0].unit == "1/s"
    informed = compose(bound, [(sagging, {"value": 0.3})])
    state, action = torch.as_tensor(CRAZYFLIE.start), torch.as_tensor(CRAZYFLIE.rest)
    weaker = action.clone()
    weaker[0] *= 1 - 0.3 * 0.2
    inputs = torch.zeros(len(bound.layouts.inputs), dtype=torch.float64)
    inputs[-1] = 3.7
    stepped = build_module(informed).double()(state, action, inputs)
    torch.testing.assert_close(stepped, build_module(plain).double()(state, weaker, inputs[:-1]))
    inputs[-1] = 3.9
    stepped = build_module(informed).double()(state, action, inputs)
    torch.testing.assert_close(stepped, build_module(plain).double()(state, action, inputs[:-1]))


def test_a_reference_that_the_equations_know_stays() -> None:
    twice = with_voltage(with_voltage(CRAZYFLIE.nominal(), 3.9), 3.5)
    assert twice.numbers["full_battery"] == 3.9
    assert twice.layouts.inputs.columns.count("vbat") == 1


def test_ripple_is_averaged_and_a_fall_is_kept() -> None:
    ripple = 0.05 * np.random.default_rng(0).standard_normal(ROWS)
    smooth = settled(flight(falling + ripple))
    inside = slice(100, -100)
    assert np.std(smooth[inside] - falling[inside]) < 0.05 / np.sqrt(100)
    np.testing.assert_allclose(settled(flight(falling))[inside], falling[inside], atol=1e-9)
    np.testing.assert_allclose(settled(flight(np.full(ROWS, 3.7))), 3.7)  # edges too


def test_the_reference_is_where_logs_begin() -> None:
    lower = flight(falling - 0.2)
    assert voltage_at_start([flight(falling), lower, lower]) == pytest.approx(3.79, abs=0.001)
    assert voltage_at_start([flight(falling), replace(lower, extra={})]) is None


def test_a_gap_in_a_recording_moves_no_reference() -> None:
    """A flight of which rows are lost goes on with an emptier battery: that is not where its thrust map holds."""
    whole = [flight(falling), flight(falling - 0.02)]
    parts = [log.rows(*rows) for log in whole for rows in ((0, 300), (310, 700), (710, ROWS))]
    assert voltage_at_start(with_common_clock(Dataset(parts))) == voltage_at_start(whole)


def test_the_page_of_an_effect_says_its_unit_with_the_voltage_and_without() -> None:
    console = Console(file=io.StringIO(), width=100)
    console.print(effect_page(effect("battery_sag", CRAZYFLIE)))
    text = console.file.getvalue()
    assert "below V₀" in text
    without, _, known = text.partition("parameters where logs hold vbat")
    assert "1/s" in without
    assert "1/V" in known
