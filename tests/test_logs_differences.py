"""Rates that a log computed from its own positions, and rates that it lacks: neither may look like a slow robot."""

from dataclasses import replace

import numpy as np
import pytest

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.sanity import check
from sym2real.experiments.flights import car_drives
from sym2real.logs.derive import closest_slope, rows_around, slope
from sym2real.logs.differences import rates_on_time
from sym2real.robots import MUSHR
from sym2real.trajectory import Trajectory

DT = MUSHR.dt


def with_velocities_by_differences(noise: float) -> Trajectory:
    """A drive whose velocities are differences of its positions, in m measured with this much noise."""
    log, rng = car_drives(1, 3, steps=200)[0], np.random.default_rng(5)
    places = {name: log.column(name) + noise * rng.standard_normal(len(log)) for name in ("x", "y")}
    rates = {f"v{name}": np.diff(place, prepend=place[0]) / DT for name, place in places.items()}
    return log.with_columns(places | rates)


def on_time(log: Trajectory) -> Trajectory:
    return rates_on_time(Dataset([log]))[0]


@pytest.mark.parametrize("noise", [0.003, 0.03])
def test_differences_of_noisy_positions_are_put_on_time(noise: float) -> None:
    log = with_velocities_by_differences(noise)
    moved = on_time(log)
    late = np.interp(log.time + DT / 2, log.time, log.column("vx"))
    np.testing.assert_allclose(moved.column("vx")[1:-1], late[1:-1], atol=1e-6)
    others = [name for name in log.layouts.state if name not in {"vx", "vy"}]
    assert all((moved.column(name) == log.column(name)).all() for name in others)
    np.testing.assert_array_equal(on_time(moved).state, moved.state)


def test_differences_that_a_file_rounds_are_differences() -> None:
    log = with_velocities_by_differences(0.01)
    rounded = replace(log, state=log.state.round(4))
    assert np.abs(on_time(rounded).column("vy") - rounded.column("vy")).max() > 0.1


def test_velocities_of_a_sensor_of_their_own_stay() -> None:
    log = with_velocities_by_differences(0.01)
    own = log.with_columns({"vx": log.column("vx") + 0.1 * np.random.default_rng(6).standard_normal(len(log))})
    np.testing.assert_array_equal(on_time(own).column("vx"), own.column("vx"))


def test_velocities_of_a_simulator_by_eulers_steps_stay() -> None:
    """Its positions are sums of its velocities, so that these are differences, and yet the velocities at the rows."""
    log = car_drives(1, 4, steps=200)[0]
    summed = log.with_columns({name: DT * np.cumsum(log.column(f"v{name}")) for name in ("x", "y")})
    np.testing.assert_array_equal(on_time(summed).state, summed.state)


def test_rates_of_all_logs_are_put_on_time_or_of_none() -> None:
    """Of some they would be late and of others not: an equation is of all of them."""
    noisy, clean = with_velocities_by_differences(0.01), with_velocities_by_differences(1e-5)
    both = rates_on_time(Dataset([noisy, clean]))
    assert all((new.column("vx") != old.column("vx")).any() for new, old in zip(both, (noisy, clean), strict=True))
    other = car_drives(1, 4, steps=200)[0]
    kept = rates_on_time(Dataset([noisy, other]))
    np.testing.assert_array_equal(kept[0].state, noisy.state)


@pytest.mark.parametrize("rows", [1, 2, 4])
def test_a_piece_of_a_few_rows_changes_nothing_for_the_others(rows: int) -> None:
    log = with_velocities_by_differences(0.01)
    moved = rates_on_time(Dataset([log, log.rows(0, rows)]))
    np.testing.assert_array_equal(moved[0].state, on_time(log).state)
    assert np.isfinite(moved[1].state).all()


def test_a_diagnosis_judges_rates_that_are_on_time() -> None:
    log = with_velocities_by_differences(0.01)
    np.testing.assert_array_equal(check(MUSHR.nominal(), Dataset([log])).data[0].state, on_time(log).state)


@pytest.mark.parametrize("rate", [20.0, 40.0, 200.0])
def test_a_step_of_a_rate_is_spread_over_a_step_of_the_model_at_most(rate: float) -> None:
    time = np.arange(round(2.0 * rate)) / rate
    angle = np.maximum(time - 1.0, 0.0)
    derived = slope(time, angle, rows_around(time, DT))
    away = np.abs(time - 1.0) > DT + 1e-9
    np.testing.assert_allclose(derived[away], (time > 1.0)[away], atol=1e-9)
    assert np.any(np.abs(derived - (time > 1.0)) > 0.1)


@pytest.mark.parametrize("frequency", [0.5, 2.0, 6.0])
def test_a_slope_is_through_as_many_rows_as_noise_and_motion_ask_for(frequency: float) -> None:
    """250 rows a second under a model of 20 ms: through eleven rows slow motions lose noise, quick ones themselves."""
    rng, time, turn = np.random.default_rng(3), np.arange(2500) / 250.0, 2 * np.pi * frequency
    angle = np.sin(turn * time) + rng.normal(0.0, 4e-4, len(time))
    missed = [
        np.std(rate - turn * np.cos(turn * time))
        for rate in (closest_slope(time, angle, 11), *(slope(time, angle, rows) for rows in (3, 5, 7, 9, 11)))
    ]
    assert missed[0] <= 1.15 * min(missed[1:])
    assert frequency < 5.0 or missed[0] < 0.6 * missed[-1]
    np.testing.assert_array_equal(closest_slope(time, angle, 3), slope(time, angle, 3))


def test_counts_of_an_encoder_that_mostly_rests_are_noise() -> None:
    """A slow joint whose encoder says the same count for many rows: the slope through three would jump by counts."""
    time = np.arange(2500) / 250.0
    counts = np.round(np.sin(0.3 * time) / 0.02) * 0.02
    np.testing.assert_array_equal(closest_slope(time, counts, 11), slope(time, counts, 11))
