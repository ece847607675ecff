"""Plants of benches: rotors that spin keep the laws of mechanics, drawn sizes go with the seed, short drives repeat."""

from __future__ import annotations

from functools import partial

import mujoco
import null_logs
import numpy as np
import pytest
from motor_draws import Draw
from motor_quadrotor import Rotors, robot
from short_drives import drives
from standard_set import standard_run
from sysid_parameters import FREE

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.mistakes.judge import mistakes
from sym2real.effects import effect
from sym2real.plants import EquationsPlant, MujocoPlant
from sym2real.plants.mujoco_plant import edited
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Motors, Robot, car, quadrotor
from sym2real.robots.crazyflie import ARM, INERTIA, MASS, ROTOR_THRUST, TORQUE_PER_THRUST

ROTOR_INERTIA = 4e-9


def test_rotors_leave_mass_and_inertia_and_hold_a_hover() -> None:
    rotors, flyer = Rotors(ROTOR_INERTIA), robot(ROTOR_INERTIA)
    plant = MujocoPlant(flyer, (rotors.change,))
    assert sum(plant.mj_model.body_mass) == pytest.approx(MASS)
    # What a turn of the whole about its axes must move, but for rotors' own moments.
    np.testing.assert_allclose(plant.mj_model.dof_M0[3:6], INERTIA, rtol=2e-3)
    plant.reset(CRAZYFLIE.start)
    for _ in range(20):
        state = plant.step(flyer.rest)
    np.testing.assert_allclose(state, CRAZYFLIE.start, atol=1e-6)
    np.testing.assert_allclose(rotors.measured(20), np.tile(flyer.rest, (20, 1)), rtol=1e-6)


def test_rotors_that_speed_up_turn_the_body_by_their_angular_momentum() -> None:
    rotors, flyer = Rotors(ROTOR_INERTIA), robot(ROTOR_INERTIA)
    plant = MujocoPlant(flyer, (rotors.change,))
    plant.reset(CRAZYFLIE.start)
    plant.step(flyer.rest)
    faster = flyer.rest + 100.0 * np.array([1.0, -1.0, 1.0, -1.0])
    before = plant.mj_data.qvel[6:10].copy()
    state = plant.step(faster)
    gained = ROTOR_INERTIA * float(np.sum(plant.mj_data.qvel[6:10] - before))
    # Over one period drag torque does less than the reaction; its impulse is known from the speeds.
    steps = np.array(rotors.speeds[-10:])
    drag = 0.001 * 0.00596 * 2.88e-8 * float(np.sum(steps**2 @ np.array([-1.0, 1.0, -1.0, 1.0])))
    assert abs(gained) > 1e-6
    assert state[12] * INERTIA[2] == pytest.approx(drag - gained, rel=0.05)


def test_rotors_turn_with_the_body_as_gyroscopes_do() -> None:
    """Two rotors turn faster than the others, and the body rolls: in 0.2 s it has turned about another axis.

    The rotors' transverse inertia, 3 % of the body's, is not in the equations.
    """
    inertia, start = 2e-7, CRAZYFLIE.start.copy()
    start[10:] = [2.0, -1.0, 0.0]
    flyer, rotors = robot(inertia, servo=0.001), Rotors(inertia, servo=0.001)
    motors = Motors(ROTOR_THRUST, "rad/s", torque_per_thrust=TORQUE_PER_THRUST, arm=ARM)
    model = quadrotor(MASS, tuple(INERTIA), interface="motors", motors=motors, dt=flyer.dt)
    informed = effect("rotor_reaction", model).substitute(model, {"value": inertia})
    plants = MujocoPlant(flyer, (rotors.change,)), EquationsPlant(informed, flyer), EquationsPlant(model, flyer)
    action, ends = flyer.rest * np.array([0.9, 1.1, 0.9, 1.1]), []
    for plant in plants:
        plant.reset(start)
        ends.append([plant.step(action) for _ in range(20)][-1][10:12])
    true, with_rotors, without = ends
    assert np.linalg.norm(with_rotors - true) < 0.05 * np.linalg.norm(without - true)


def test_a_seed_draws_the_same_robot_and_a_model_that_is_wrong_by_no_more_than_said() -> None:
    first, again, other = Draw.of(5), Draw.of(5), Draw.of(6)
    assert first == again != other
    for draw in (Draw.of(seed) for seed in range(50)):
        assert 1 / 50 <= draw.inertia <= 50 and 1 / 50 <= draw.drag <= 50
        assert draw.analysts.numbers["jx"] == pytest.approx(draw.inertia * INERTIA[0])


def test_short_drives_have_the_same_commands_at_every_seed_and_end_after_three_seconds() -> None:
    first, again = (drives(MUSHR, 3, noisy=False) for _ in range(2))
    assert len(first) == 20 and {len(log) for log in first} == {60}
    np.testing.assert_array_equal(first[7].state, again[7].state)
    np.testing.assert_array_equal(drives(MUSHR.at_period(0.05), 3)[7].action, first[7].action)


@pytest.mark.parametrize("rate", null_logs.RATES.values())
@pytest.mark.parametrize("base", [CRAZYFLIE, MUSHR], ids=["crazyflie", "mushr"])
def test_another_rate_has_whole_physics_steps(base: Robot, rate: float) -> None:
    changed = base.at_period(1.0 / rate)
    assert changed.substeps * changed.description.physics_dt == pytest.approx(1.0 / rate)
    assert changed.description.physics_dt <= base.description.physics_dt * (1 + 1e-9)


def test_lost_and_stale_rows_leave_what_was_measured() -> None:
    data = drives(MUSHR, 3, noisy=False)
    lost = null_logs.with_lost_rows(data, np.random.default_rng(0))
    stale = null_logs.with_stale_rows(data, np.random.default_rng(0))
    assert lost.rows < data.rows
    for before, fewer, repeated in zip(data, lost, stale, strict=True):
        places = np.searchsorted(before.time, fewer.time)
        np.testing.assert_array_equal(fewer.state, before.state[places])
        same = (repeated.state == before.state).all(axis=1)
        held = (repeated.state[1:] == repeated.state[:-1]).all(axis=1)
        assert (same[1:] | held).all()
        np.testing.assert_array_equal(repeated.action, before.action)
    assert any((log.state[1:] == log.state[:-1]).all(axis=1).any() for log in stale)


def test_only_what_is_no_damage_is_an_alarm() -> None:
    damage = {"effect": "", "evidence": "rows repeat: 5 % of them", "fix": ""}
    finding = {"effect": "wind", "group": ["wind"], "parameters": {}}
    assert not null_logs.alarm({"verdict": "EFFECT", "findings": [], "faults": [damage]})
    assert null_logs.alarm({"verdict": "EFFECT", "findings": [finding], "faults": [damage]})
    assert null_logs.alarm({"verdict": "EFFECT", "findings": [], "faults": [{**damage, "evidence": "vx is late"}]})
    assert null_logs.alarm({"verdict": "UNEXPLAINED", "findings": [], "faults": []})
    assert not null_logs.alarm({"verdict": "CANNOT_TELL", "findings": [finding], "faults": []})


@pytest.mark.parametrize(("name", "free"), [(name, free) for name, listed in FREE.items() for free in listed])
def test_a_step_of_a_fit_changes_the_motion_for_every_free_number(name: str, free: str) -> None:
    robot, one = ROBOTS[name], FREE[name][free]
    start = one.nominal + one.off
    small, nominal = (moved(robot, free, start + step) - moved(robot, free, start) for step in (1e-7, 0.0))
    assert not nominal.any()
    assert np.abs(small).max() > 0.0
    # Written twice into one spec, as mujoco.sysid does it, the last value counts.
    spec = edited(robot)
    one.write(spec, one.high)
    one.write(spec, start)
    np.testing.assert_array_equal(simulated(robot, spec), moved(robot, free, start))


def moved(robot: Robot, free: str, value: float) -> np.ndarray:
    spec = edited(robot)
    FREE[robot.name][free].write(spec, value)
    return simulated(robot, spec)


def simulated(robot: Robot, spec: mujoco.MjSpec) -> np.ndarray:
    model = spec.compile()
    data = mujoco.MjData(model)
    robot.write_state(data, robot.start)
    data.qvel[3:6] += 1.0 if robot is CRAZYFLIE else 0.0
    action = robot.rest + (0.1 if robot is CRAZYFLIE else np.array([0.2, 1.5]))
    data.ctrl[:] = robot.description.to_control(action)
    mujoco.mj_step(model, data, 100)
    return np.concatenate([data.qpos, data.qvel])


def test_a_foreign_car_that_hears_its_commands_late_has_no_late_sensor() -> None:
    """Its yaw rate alone asks for as many rows as its commands do; its heading and its path tell which it is."""
    pytest.importorskip("vehiclemodels", reason="CommonRoad's cars are in the extra bench: pip install '.[bench]'")
    from single_track_plant import WHEELBASE, Car, SingleTrackPlant

    plant = partial(SingleTrackPlant, Car(late=3))
    data = Dataset([standard_run(MUSHR, plant, 7, index, yaw=index % 2 > 0) for index in (0, 1, 6, 7)])
    assert mistakes(car(WHEELBASE), data) == []
