"""Velocities that were measured apart from positions: told from those that were made of positions, and made use of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter, savgol_filter
from standard_set import Case, simulate_case

from sym2real import diagnose
from sym2real.dataset import Dataset
from sym2real.logs.measured_rates import measured_rates
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE
from sym2real.trajectory import Array, Trajectory

POSITION, VELOCITY = ("x", "y", "z"), ("vx", "vy", "vz")
FIX, DOPPLER = 0.03, 0.03  # m, m/s: of a receiver of satellites
Velocity = Callable[[Array, Array, float], Array]  # of noisy positions, true velocities and the step


def outdoors(logs: Dataset, velocity: Velocity, fix: float = FIX) -> Dataset:
    """The flights with the noise of satellites on the positions, and a velocity of this kind."""
    rng = np.random.default_rng(7)

    def measured(log: Trajectory) -> Trajectory:
        state, layout = log.state.copy(), log.layouts.state
        places, speeds = layout.indices(POSITION), layout.indices(VELOCITY)
        state[:, places] += fix * rng.standard_normal((len(log), 3))
        true = np.gradient(log.state[:, places], log.dt, axis=0)
        state[:, speeds] = velocity(state[:, places], true, log.dt) if len(log) else true
        return replace(log, state=state, extra={})

    return Dataset([measured(log) for log in logs])


def own(_: Array, true: Array, __: float) -> Array:
    return true + DOPPLER * np.random.default_rng(3).standard_normal(true.shape)


def central(place: Array, _: Array, dt: float) -> Array:
    return np.gradient(place, dt, axis=0)


def smoothed(place: Array, _: Array, dt: float) -> Array:
    slopes: Array = savgol_filter(place, 9, 2, deriv=1, delta=dt, axis=0)
    return slopes


def filtered(place: Array, _: Array, dt: float) -> Array:
    """Of differences, through a first-order filter of 0.1 s."""
    past = np.exp(-dt / 0.1)
    slopes: Array = lfilter([1 - past], [1, -past], np.diff(place, axis=0, prepend=place[:1]) / dt, axis=0)
    return slopes


def wandering(_: Array, true: Array, dt: float) -> Array:
    """An estimate whose error goes on for half a second, with a little noise of its last step."""
    past, rng = np.exp(-dt / 0.5), np.random.default_rng(4)
    error = lfilter([np.sqrt(1 - past**2)], [1, -past], 0.1 * rng.standard_normal(true.shape), axis=0)
    return true + error + 0.01 * rng.standard_normal(true.shape)


def true(_: Array, velocity: Array, __: float) -> Array:
    return velocity


@pytest.fixture(scope="module")
def flights() -> Dataset:
    """Without noise of sensors, but for that of the standard set's, which is a tenth of what is added."""
    return simulate_case(Case("crazyflie", (("wind", {"fx": 0.004, "fy": -0.003}),), seed=811), 6, 300)


def test_a_velocity_with_noise_of_its_own_is_a_measurement(flights: Dataset) -> None:
    measured = outdoors(flights, own)
    assert measured_rates(measured) == ("velocity",)
    assert measured_rates(Dataset(measured[::-1])) == ("velocity",)
    assert measured_rates(Dataset([log.rows(40, len(log)) for log in measured])) == ("velocity",)


@pytest.mark.parametrize("made", [central, smoothed, filtered, wandering])
@pytest.mark.parametrize("fix", [0.001, FIX])
def test_one_that_was_made_of_positions_or_estimated_is_none(flights: Dataset, made: Velocity, fix: float) -> None:
    assert measured_rates(outdoors(flights, made, fix)) == ()


def test_logs_without_noise_show_none(flights: Dataset) -> None:
    assert measured_rates(outdoors(flights, true, fix=0.0)) == ()
    assert measured_rates(Dataset([log.rows(0, 40) for log in outdoors(flights, own)])) == ()  # too short to tell


def test_a_wind_that_positions_cannot_show_is_found_by_velocities(flights: Dataset) -> None:
    """1.8 % of the weight: 2 cm in half a second, under a fix of 3 cm."""
    base, plant = CRAZYFLIE.nominal(), MujocoPlant(CRAZYFLIE)
    found = diagnose(base, outdoors(flights, own), plant)
    assert [finding.effect for finding in found.findings] == ["wind"]
    wind = found.findings[0].parameters
    assert wind["fx"].low < 0.004 < wind["fx"].high
    assert wind["fy"].high < 0
    assert not diagnose(base, outdoors(flights, smoothed), plant).findings
