"""The test flights and drives are what their names promise, and the same for the same seed."""

import numpy as np
import pytest
import torch

from sym2real.dataset import Dataset
from sym2real.effects import effect
from sym2real.experiments.excitation import ColouredNoise
from sym2real.experiments.flights import car_drives, quadrotor_flights
from sym2real.robots import CRAZYFLIE
from sym2real.rotation import tilt
from sym2real.trajectory import Array


def quadrotor_spread(flights: Dataset) -> tuple[float, float, float]:
    """95th percentiles of tilt in degrees, speed in m/s and rate in rad/s."""
    states = np.concatenate([flight.state for flight in flights])
    tilts = np.rad2deg(tilt(torch.as_tensor(states[:, 3:7])).numpy())
    speeds, rates = (np.linalg.norm(states[:, part], axis=1) for part in (slice(7, 10), slice(10, 13)))
    first, second, third = (float(np.quantile(values, 0.95)) for values in (tilts, speeds, rates))
    return first, second, third


def forward_speed(drives: Dataset) -> Array:
    states = np.concatenate([drive.state for drive in drives])
    speed: Array = states[:, 4] * states[:, 3] + states[:, 5] * states[:, 2]
    return speed


def test_flights_in_distribution_are_moderate() -> None:
    flights = quadrotor_flights(8, seed=0)
    tilts, speeds, _ = quadrotor_spread(flights)
    assert 20.0 < tilts < 40.0
    assert 1.2 < speeds < 4.0
    kinds = [flight.name.rsplit("_", 1)[0] for flight in flights]
    assert set(kinds[:4]) == {"circle", "eight", "hover", "levelled_rates"}
    assert kinds[:4] == kinds[4:]
    for flight in flights:
        start = float(tilt(torch.as_tensor(flight.state[0, 3:7])))
        assert start <= 0.2
        if "rates" not in flight.name:
            assert len(flight) == 400


def test_flights_repeat_by_seed_and_differ_between_seeds() -> None:
    one, again, other = (quadrotor_flights(1, seed=seed, steps=30) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one[0].state, again[0].state)
    assert np.abs(one[0].state - other[0].state).max() > 0.01
    # A flight does not depend on how many are asked for.
    np.testing.assert_array_equal(one[0].state, quadrotor_flights(2, seed=1, steps=30)[0].state)


def test_changes_and_pushes_reach_the_plant() -> None:
    plain = quadrotor_flights(1, seed=1, steps=30)
    windy = quadrotor_flights(1, seed=1, steps=30, changes=[effect("wind", CRAZYFLIE).inject(fx=0.03)])
    assert (windy[0].column("vx") - plain[0].column("vx"))[-1] > 0.1
    forced = quadrotor_flights(1, seed=1, steps=30, forced=True)
    assert not plain[0].inputs.any()
    assert (np.abs(forced[0].inputs).max(axis=0) > 0.0).all()


def test_drives_in_distribution_go_forward_within_their_limit() -> None:
    drives = car_drives(3, seed=0, steps=200)
    speed = forward_speed(drives)
    assert speed.min() > -0.05
    assert speed.max() < 2.05
    assert np.quantile(speed, 0.5) > 0.6
    turning = np.concatenate([drive.column("wz") for drive in drives])
    assert turning.min() < -0.3
    assert turning.max() > 0.3


@pytest.mark.parametrize("correlation", [0.08, 0.5])
def test_coloured_noise_has_its_size_and_its_time_constant(correlation: float) -> None:
    dt, deviation = CRAZYFLIE.dt, np.array([0.03, 1.0])
    noise = ColouredNoise(deviation, correlation, dt, np.random.default_rng(0))
    values = np.array([noise.next() for _ in range(40_000)])
    np.testing.assert_allclose(values.std(axis=0), deviation, rtol=0.1)
    lag = round(correlation / dt)
    for column in values.T:
        assert np.corrcoef(column[:-lag], column[lag:])[0, 1] == pytest.approx(
            np.exp(-lag * dt / correlation), abs=0.06
        )
