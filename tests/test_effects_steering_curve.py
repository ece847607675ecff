"""A bent steering map, against a car whose front wheels are turned alike and slip until their sides are even."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy.optimize import brentq

from sym2real.diagnosis import diagnose
from sym2real.robots import car
from sym2real.trajectory import Array, Trajectory

WHEELBASE, TRACK, DT, FINE = 0.32, 0.28, 0.05, 10
BASE = car(WHEELBASE, dt=DT)


def turning(steer: float, *, alike: bool) -> float:
    """Curvature of the rear axle's path in 1/m: of a bicycle, or of two wheels that are both turned by ``steer``.

    Wheels that roll slowly stand still across: with even slip α to either side the mean of both directions is δ.
    """
    if not alike:
        return float(np.tan(steer)) / WHEELBASE

    def missed(curvature: float) -> float:
        half = 0.5 * TRACK * curvature
        left, right = (np.arctan(WHEELBASE * curvature / (1.0 + side)) for side in (-half, half))
        return float(0.5 * (left + right) - steer)

    return float(brentq(missed, -5.0, 5.0))


def driven(seed: int, *, alike: bool) -> Trajectory:
    """Steering and speeds drawn anew every 0.8 s, which act at once; noise of a motion capture."""
    rng = np.random.default_rng(seed)
    x = y = yaw = speed = rate = 0.0
    states, told = [], list[Array]()
    for row in range(400):
        states.append([x, y, np.sin(yaw), np.cos(yaw), speed * np.cos(yaw), speed * np.sin(yaw), rate])
        if row % 16 == 0:
            command = np.array([rng.uniform(-0.45, 0.45), rng.uniform(0.8, 1.8)])
            speed, rate = command[1], command[1] * turning(command[0], alike=alike)
        told.append(command)
        for _ in range(FINE):
            middle = yaw + 0.5 * rate * DT / FINE
            x, y = x + speed * np.cos(middle) * DT / FINE, y + speed * np.sin(middle) * DT / FINE
            yaw += rate * DT / FINE
    noise = rng.normal(0.0, [0.001, 0.001, 0.003, 0.003, 0.01, 0.01, 0.02], (len(states), 7))
    state = BASE.layouts.state.normalise(torch.as_tensor(np.array(states) + noise)).numpy()
    return Trajectory.from_arrays(state, np.array(told), BASE.layouts, dt=DT)


@pytest.mark.slow
def test_front_wheels_that_are_turned_alike_are_named_and_no_gain() -> None:
    """About the middle the curvature is κL = tan δ (1 - s² δ²) with s = track / 2 wheelbase; the curve is its mean."""
    found = diagnose(BASE, [driven(seed, alike=True) for seed in range(6)])
    assert [finding.effect for finding in found.findings] == ["steering_curve"], found.summary
    value = found.findings[0].parameters["value"]
    steer = np.linspace(0.05, 0.45, 50)
    held = np.array([np.arctan(WHEELBASE * turning(angle, alike=True)) for angle in steer])
    mean = np.linalg.lstsq(steer[:, None] ** 3, steer - held, rcond=None)[0].item()
    assert value.low <= mean <= value.high
    assert value.value == pytest.approx(mean, rel=0.1)


@pytest.mark.slow
def test_a_bicycle_has_no_curve() -> None:
    assert not diagnose(BASE, [driven(seed, alike=False) for seed in range(6)]).findings
