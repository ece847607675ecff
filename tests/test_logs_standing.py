"""Robots that stand: such rows are left out, but no flight is, however little it is pushed, and no stop of a moment."""

from dataclasses import replace

import numpy as np
import pytest
from noisy_flights import flights

from sym2real import compare
from sym2real.dataset import Dataset
from sym2real.layout import Layouts
from sym2real.logs.standing import in_motion
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
    (flown,) = in_motion(hopped(push, unit, columns))
    start, stop = round(flown.time[0] / STEP), round(flown.time[-1] / STEP)
    assert first <= start <= first + 8
    assert last - 8 <= stop <= last
    (note,) = flown.notes
    assert "rows left out" in note
    assert "it stands" in note


def test_who_is_dropped_stands_once_it_lies() -> None:
    """From half a metre, 0.3 s of fall in a stretch of one push."""
    push = np.concatenate([np.repeat([1.3, 0.7], 18), np.ones(60), np.full(50, 0.05)])
    log = hopped(push)
    fallen = int(np.flatnonzero(hop(push, noise=0.0)[0][100:] <= FLOOR)[0]) + 100
    assert log.column("z")[90] > 0.3
    (flown,) = in_motion(log)
    assert fallen - 12 <= round(flown.time[-1] / STEP) <= fallen


def test_who_falls_flies() -> None:
    """Half a second with a tenth of the weight, high up."""
    push = np.concatenate([np.full(60, 1.25), np.full(60, 0.75), np.full(25, 0.1), np.full(25, 1.9), np.ones(60)])
    log = hopped(push)
    assert log.column("z")[100:].min() > FLOOR + 0.5
    assert in_motion(log) == [log]


def driven(told: Array, *, rolls: float = 0.0) -> Trajectory:
    """A car that follows its speed within 0.1 s and, told to stand, may roll on at a speed."""
    speed, place, found = 0.0, 0.0, []
    for wanted in told:
        found.append((place, 0.0, speed, 0.0))
        speed += (max(wanted, rolls) - speed) * (1 - np.exp(-STEP / 0.1))
        place += speed * STEP
    state = np.array(found) + np.random.default_rng(6).normal(0.0, 2e-3, (len(told), 4))
    steer = 0.2 * np.sin(np.arange(len(told)))
    return Trajectory.from_arrays(
        state, np.stack([steer, told], axis=1), Layouts.of(["x", "y", "vx", "vy", "steer", "speed"]), dt=STEP
    )


def test_a_car_that_waits_is_left_out_but_for_a_moment() -> None:
    wait, go = np.zeros(200), np.full(150, 1.2)
    first, second = in_motion(driven(np.concatenate([wait, go, wait, go])))
    moment = 0.5 / STEP
    assert first.time[0] / STEP == pytest.approx(200 - moment, abs=1)
    assert first.time[-1] / STEP == pytest.approx(350 + moment, abs=30)  # it brakes meanwhile
    assert second.time[0] / STEP == pytest.approx(550 - moment, abs=1)
    assert "it stands (as commanded)" in first.notes[0]


@pytest.mark.parametrize(("stopped", "rolls"), [(60, 0.0), (300, 0.15)], ids=["stop of a moment", "rolls on"])
def test_a_car_that_does_not_rest_is_no_waiting_one(stopped: int, rolls: float) -> None:
    log = driven(np.concatenate([np.full(100, 1.2), np.zeros(stopped), np.full(100, 1.2)]), rolls=rolls)
    assert in_motion(log) == [log]


def test_flights_and_drives_stay_as_they_are() -> None:
    log = flights()[0]
    assert in_motion(log) == [log]
    drive = Trajectory.from_arrays(
        np.zeros((50, 4)), np.zeros((50, 2)), Layouts.of(["x", "y", "vx", "vy", "steer", "speed"]), dt=0.05
    )
    assert in_motion(drive) == [drive]


@pytest.mark.slow
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
