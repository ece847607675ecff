"""What logs cannot tell apart: conditions on the manoeuvre, and what follows for candidates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sym2real.dataset import Dataset
from sym2real.diagnosis.predict.candidate import candidates, library_for
from sym2real.effects import effect
from sym2real.effects.groups import holding, others_of, same_on_every_flight
from sym2real.effects.manoeuvres import (
    calm_rates,
    single_circle,
    single_direction,
    steady_speed,
    steady_thrust,
    steady_thrust_alone,
    steady_yaw,
    tyres_hold,
)
from sym2real.effects.trim import TRIM, is_trim
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS
from sym2real.trajectory import Array, Trajectory

ROWS = 300


def flight(yaw: Array, thrust: Array, speed: Array, rates: Array | float = 0.0) -> Trajectory:
    state = np.tile(CRAZYFLIE.start, (ROWS, 1))
    layout, action = CRAZYFLIE.layouts.state, CRAZYFLIE.layouts.action
    state[:, layout.index("qw")], state[:, layout.index("qz")] = np.cos(yaw / 2), np.sin(yaw / 2)
    state[:, layout.index("vx")] = speed
    sent = np.tile(CRAZYFLIE.rest, (ROWS, 1))
    sent[:, action.index("thrust")] = thrust
    sent[:, action.index("wx_cmd")] = sent[:, action.index("wy_cmd")] = rates
    time = np.arange(ROWS) * CRAZYFLIE.dt
    return Trajectory(time, state, sent, np.zeros((ROWS, len(CRAZYFLIE.layouts.inputs))), CRAZYFLIE.layouts)


def drive(steer: Array, speed: Array) -> Trajectory:
    length, dt = MUSHR.numbers["wheelbase"], MUSHR.dt
    rate = speed * np.tan(steer) / length
    yaw = np.cumsum(rate) * dt
    along = np.stack([np.cos(yaw), np.sin(yaw)], axis=1) * speed[:, None]
    path = np.cumsum(along, axis=0) * dt
    state = np.column_stack([path, np.sin(yaw), np.cos(yaw), along, rate])
    actions = np.column_stack([steer, speed])
    return Trajectory(np.arange(ROWS) * dt, state, actions, np.zeros((ROWS, len(MUSHR.layouts.inputs))), MUSHR.layouts)


still, phase = np.zeros(ROWS), np.linspace(0, 8 * np.pi, ROWS)
hover = flight(0.1 * np.sin(phase), 0.27 + 0.01 * np.sin(phase), still)
busy = flight(
    phase / 2, 0.27 + 0.08 * np.sin(phase), 1.5 * np.sin(phase), np.random.default_rng(0).normal(0, 0.5, ROWS)
)
circle = drive(np.full(ROWS, 0.2), np.full(ROWS, 0.9))
eight = drive(0.3 * np.sin(phase), 1.0 + 0.8 * np.sin(1.7 * phase))
fast = drive(np.full(ROWS, 0.25), np.full(ROWS, 2.5))


def test_conditions_hold_where_the_manoeuvre_lacks_what_separates() -> None:
    for condition in (steady_yaw, steady_thrust, calm_rates):
        assert condition([hover])
        assert not condition([busy])
    for condition in (single_circle, steady_speed, single_direction, tyres_hold):
        assert condition([circle])
    for condition in (single_circle, steady_speed):
        assert not condition([eight])
    assert not tyres_hold([fast])
    assert not single_direction([circle, drive(np.full(ROWS, 0.2), np.full(ROWS, -0.9))])
    # Two circles, one each way, separate what one does not.
    assert not single_circle([circle, drive(np.full(ROWS, -0.2), np.full(ROWS, 0.9))])
    # Two flights that look different ways do as well.
    assert not steady_yaw([hover, flight(still + 2.0, still + 0.27, still)])


def test_conditions_of_another_robot_do_not_hold() -> None:
    for condition in (steady_yaw, steady_thrust, calm_rates):
        assert not condition([circle])
    for condition in (single_circle, tyres_hold, single_direction):
        assert not condition([hover])


def test_equal_effects_compete_in_one_place() -> None:
    assert "mounting_tilt" in others_of("wind", holding([hover]))
    assert "mounting_tilt" not in others_of("wind", holding([busy]))
    found = {one.name: one for one in candidates(library_for(CRAZYFLIE.nominal(), Dataset([hover])), Dataset([hover]))}
    assert found["wind"].excludes == ("mounting_tilt",)
    assert found["mounting_tilt"].excludes == ("wind",)
    assert {"gain:thrust", "offset:thrust"} <= set(found["added_mass"].alike)
    assert "offset:thrust" not in found  # near one thrust it is a gain, but a curve through the hover thrust is none
    assert "added_mass" in found["thrust_curve"].excludes  # one in the place of the other, never beside it
    level = flight(0.1 * np.sin(phase), still + 0.27, still)
    found = {one.name: one for one in candidates(library_for(CRAZYFLIE.nominal(), Dataset([level])), Dataset([level]))}
    assert "thrust_curve" in found["added_mass"].alike
    assert not {"offset:thrust", "thrust_curve"} & found.keys()
    separated = candidates(library_for(CRAZYFLIE.nominal(), Dataset([busy])), Dataset([busy]))
    assert all(not one.excludes for one in separated)
    assert {"offset:thrust", "thrust_curve"} <= {one.name for one in separated}


def test_what_no_flight_tells_apart_is_the_same_whatever_is_flown() -> None:
    for flown in (hover, busy):
        assert same_on_every_flight("added_mass", [flown]) == ("gain:thrust",)
        assert same_on_every_flight("torque_bias", [flown]) == ("offset:w?_cmd",)
    assert same_on_every_flight("wind", [hover]) == ("slope",)
    assert same_on_every_flight("linear_drag", [hover]) == ()


def test_motors_that_turn_the_body_tell_their_strength_from_a_mass() -> None:
    robot = ROBOTS["hexarotor"]
    rows = np.repeat(robot.rest[None], ROWS, axis=0)
    state = np.repeat(robot.start[None], ROWS, axis=0)
    log = Trajectory(
        np.arange(ROWS) * robot.dt, state, rows, np.zeros((ROWS, len(robot.layouts.inputs))), robot.layouts
    )
    assert steady_thrust([log])
    assert not steady_thrust_alone([log])
    assert "offset:thrust" in others_of("added_mass", holding([log]))
    assert "gain:thrust" not in others_of("added_mass", holding([log]))
    assert "thrust_curve" in others_of("gain:thrust", holding([log]))


def test_drag_at_one_speed_is_called_linear() -> None:
    steady = flight(still, still + 0.27, still + 1.0)
    assert "quadratic_drag" not in library_for(CRAZYFLIE.nominal(), Dataset([steady])).effects
    assert "quadratic_drag" in library_for(CRAZYFLIE.nominal(), Dataset([busy])).effects


@pytest.mark.parametrize(("part", "expected"), [(0.5, True), (2.0, False)])
def test_trim_is_a_small_tilt_or_a_force_that_looks_like_one(part: float, expected: bool) -> None:
    tilt, wind = effect("mounting_tilt", CRAZYFLIE), effect("wind", CRAZYFLIE)
    assert is_trim(tilt, {"roll": part * TRIM, "pitch": 0.0}, [hover]) == expected
    force = part * TRIM * CRAZYFLIE.mass * 9.81
    assert is_trim(wind, {"fx": 0.0, "fy": -force}, [hover]) == expected
    assert not is_trim(wind, {"fx": force, "fy": 0.0}, [busy])  # yaw turns: a force of the world, no tilt
    assert not is_trim(effect("added_mass", CRAZYFLIE), {"value": 0.0}, [hover])
    assert not is_trim(effect("wind", MUSHR), {"fx": 0.0, "fy": 0.0}, [replace(circle)])


def test_one_speed_shows_no_tyres_and_no_curve_of_speeds_and_several_do() -> None:
    of_tyres, even = {"tyre_slip", "understeer", "speed_curve"}, drive(0.3 * np.sin(phase), np.full(ROWS, 0.9))
    assert not of_tyres & {*library_for(MUSHR.nominal(), Dataset([even])).effects}
    assert of_tyres <= {*library_for(MUSHR.nominal(), Dataset([eight])).effects}


def test_one_circle_shows_no_curve_of_the_steering_and_turns_both_ways_do() -> None:
    of_one_circle = library_for(MUSHR.nominal(), Dataset([circle])).effects
    assert not {"steering_curve", "steering_asymmetry", "speed_asymmetry"} & {*of_one_circle}
    assert "steering_curve" in library_for(MUSHR.nominal(), Dataset([eight])).effects
