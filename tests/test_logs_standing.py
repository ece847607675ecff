"""A robot with rotors that stands: its rows are left out, and no flight is, however little it is pushed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from noisy_flights import flights

from sym2real import compare
from sym2real.dataset import Dataset
from sym2real.layout import Layouts
from sym2real.logs.standing import in_flight
from sym2real.robots import CRAZYFLIE
from sym2real.trajectory import Array, Trajectory

STEP, FLOOR, GRAVITY = 0.02, 0.02, 9.81  # s; m, where it stands
STANDING = 60  # rows
COLUMNS = "x y z vx vy vz thrust"


def hop(push: Array, noise: float = 1e-3) -> tuple[Array, Array]:
    """Height and its rate under a push in units of the weight, with a floor ``# (rows,)``."""
    height, rate, found = FLOOR, 0.0, []
    for told in push:
        found.append((height, rate))
        for _ in range(20):
            rate += (told - 1.0) * GRAVITY * STEP / 20
            height += rate * STEP / 20
            if height < FLOOR:
                height, rate = FLOOR, max(rate, 0.0)
    heights, rates = np.array(found).T
    return heights + np.random.default_rng(4).normal(0.0, noise, len(push)), rates


def hopped(push: Array, unit: float = 0.3, columns: str = COLUMNS) -> Trajectory:
    height, rate = hop(push)
    zero = np.zeros_like(height)
    layouts = Layouts.of(columns.split())
    told = np.repeat(unit * push[:, None], layouts.action.size, axis=1)
    return Trajectory.from_arrays(np.stack([zero, zero, height, zero, zero, rate], axis=1), told, layouts, dt=STEP)


def take_off() -> tuple[Array, int, int]:
    """Idle, a ramp up to what lifts it, a climb, a hover, a descent, idle again; first and last row above the floor."""
    ramp, climb, hover = np.linspace(0.0, 1.0, 30), np.repeat([1.3, 0.7], 15), np.ones(120)
    push = np.concatenate([np.full(STANDING, 0.1), ramp, climb, hover, 2.0 - climb, np.full(STANDING, 0.1)])
    height, _ = hop(push, noise=0.0)
    above = np.flatnonzero(height > FLOOR + 1e-4)
    return push, int(above[0]), int(above[-1])


@pytest.mark.parametrize("unit", [1e-3, 0.3, 40000.0])
@pytest.mark.parametrize("columns", [COLUMNS, "x y z vx vy vz motor1 motor2 motor3 motor4"])
def test_what_is_between_two_stands_is_the_flight(unit: float, columns: str) -> None:
    push, first, last = take_off()
    (flown,) = in_flight(hopped(push, unit, columns))
    start, stop = round(flown.time[0] / STEP), round(flown.time[-1] / STEP)
    assert first <= start <= first + 8
    assert last - 8 <= stop <= last
    (note,) = flown.notes
    assert "rows left out" in note
    assert "it stands" in note


def test_who_falls_flies() -> None:
    """Half a second with a tenth of the weight, high up."""
    push = np.concatenate([np.full(60, 1.25), np.full(60, 0.75), np.full(25, 0.1), np.full(25, 1.9), np.ones(60)])
    log = hopped(push)
    assert log.column("z")[100:].min() > FLOOR + 0.5
    assert in_flight(log) == [log]


def test_flights_and_drives_stay_as_they_are() -> None:
    log = flights()[0]
    assert in_flight(log) == [log]
    drive = Trajectory.from_arrays(
        np.zeros((50, 4)), np.zeros((50, 2)), Layouts.of(["x", "y", "vx", "vy", "steer", "speed"]), dt=0.05
    )
    assert in_flight(drive) == [drive]


def test_a_log_from_before_the_take_off_is_judged_by_its_flight() -> None:
    """The floor carries it: to a model that falls there nothing is missing."""
    flown, model = flights(), CRAZYFLIE.nominal()
    rest = replace(flown[0], state=np.tile(flown[0].state[0], (len(flown[0]), 1)), action=0.0 * flown[0].action)
    rest.state[:, 2] = FLOOR

    def from_the_floor(log: Trajectory) -> Trajectory:
        state, action, inputs = (
            np.concatenate([getattr(part, group)[:rows] for part, rows in ((rest, STANDING), (log, None))])
            for group in ("state", "action", "inputs")
        )
        time = STEP * np.arange(len(state))
        return replace(log, time=time, state=state, action=action, inputs=inputs, extra={}, raw={})

    with_floor = Dataset(from_the_floor(log) for log in flown)
    found, expected = (compare(model, logs).to_dict() for logs in (with_floor, flown))
    for rung, meant in zip(found["horizons"], expected["horizons"], strict=True):
        assert rung["windows"] == meant["windows"]
        for channel, error in rung["errors"].items():
            assert error["value"] == pytest.approx(meant["errors"][channel]["value"], rel=1e-3)
    assert any("it stands" in note for note in found["notes"])
