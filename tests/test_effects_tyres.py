"""Understeer and side slip of tyres: steady circles of MuJoCo's car and of equations, and a diagnosis of one car."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import standard_trim
import torch
from effects_cases import nominal
from standard_set import standard_run

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.effects import effect
from sym2real.effects.visible import VisibleModel
from sym2real.experiments.standard_conditions import sensors
from sym2real.plants import MujocoPlant
from sym2real.protocols import Change
from sym2real.robots import MUSHR
from sym2real.symbolic import compile_model
from sym2real.trajectory import Array

WHEELBASE = MUSHR.numbers["wheelbase"]
SETTLED = 80  # steps, 4 s
CIRCLES = [(0.1, 0.6), (0.1, 2.2), (-0.2, 1.2), (0.3, 0.8), (0.3, 1.8)]  # steering rad, speed m/s
TRAIL = 0.04  # m


def start(steer: float, speed: float) -> Array:
    state = MUSHR.start.copy()
    state[[4, 6]] = speed, speed * np.tan(steer) / WHEELBASE
    return state


def circled(plant: MujocoPlant, steer: float, speed: float) -> Array:
    """The car's state after a while on one circle ``# (state,)``."""
    state = plant.reset(start(steer, speed))
    for _ in range(SETTLED):
        state = plant.step(np.array([steer, speed]))
    return state


def predicted(key: str, value: float, steer: float, speed: float) -> Array:
    """The same by equations, with the last step's displacement over its time behind ``# (state + 2,)``."""
    found = effect(key, MUSHR)
    model = compile_model(found.substitute(nominal(MUSHR), {"value": value}), dtype=torch.float64)
    before = state = torch.as_tensor(start(steer, speed))
    for _ in range(SETTLED):
        before, state = state, MUSHR.layouts.state.normalise(model(state, torch.tensor([steer, speed]).double()))
    moved: Array = torch.cat([state, (state - before)[:2] / MUSHR.dt]).numpy()
    return moved


def turn(state: Array) -> tuple[float, float, float]:
    """Speed along and across the heading in m/s, and yaw rate in rad/s."""
    sine, cosine, vx, vy, rate = state[2:7]
    return float(vx * cosine + vy * sine), float(vy * cosine - vx * sine), float(rate)


def gradient(steer: float, state: Array) -> float:
    """K of δ = atan(L/R) + K a_y, rad s²/m."""
    forward, _, rate = turn(state)
    return float((steer - np.arctan(WHEELBASE * rate / forward)) / (forward * rate))


def compliance(state: Array) -> float:
    """D of v_rear = -D |u| a_y, rad s²/m."""
    forward, across, rate = turn(state)
    return -across / (abs(forward) * forward * rate)


@pytest.mark.parametrize(("steer", "speed"), CIRCLES)
@pytest.mark.parametrize("value", [-0.005, 0.005, 0.03])
def test_understeer_is_the_gradient_that_steady_circles_measure(steer: float, speed: float, value: float) -> None:
    understeering = MujocoPlant(MUSHR, [effect("understeer", MUSHR).inject(value=value)])
    plain = gradient(steer, circled(MujocoPlant(MUSHR), steer, speed))
    assert gradient(steer, circled(understeering, steer, speed)) - plain == pytest.approx(value, rel=0.02)
    assert gradient(steer, predicted("understeer", value, steer, speed)) == pytest.approx(value, rel=0.02)


@pytest.mark.parametrize(("steer", "speed"), CIRCLES)
@pytest.mark.parametrize("value", [0.005, 0.02])
def test_slipping_tyres_lead_the_rear_axle_outwards(steer: float, speed: float, value: float) -> None:
    slipping = MujocoPlant(MUSHR, [effect("tyre_slip", MUSHR).inject(value=value)])
    creep = compliance(circled(MujocoPlant(MUSHR), steer, speed))
    assert compliance(circled(slipping, steer, speed)) - creep == pytest.approx(value, rel=0.02)
    state = predicted("tyre_slip", value, steer, speed)
    assert compliance(state) == pytest.approx(value, rel=1e-6)
    assert gradient(steer, state) == pytest.approx(0.0, abs=1e-7)  # both axles slip alike: no other turn
    # The place moves as the velocity says, seen from the middle of the step's arc.
    forward, across, rate = turn(state)
    heading = np.arctan2(state[2], state[3]) - rate * MUSHR.dt / 2
    aside = state[8] * np.cos(heading) - state[7] * np.sin(heading)
    assert aside == pytest.approx(across, rel=0.03, abs=0.002 * speed)
    assert np.hypot(*state[7:]) == pytest.approx(np.hypot(forward, across), rel=0.01)


def test_what_two_effects_of_tyres_do_adds_up_in_either_order() -> None:
    slip, understeer = effect("tyre_slip", MUSHR).inject(value=0.005), effect("understeer", MUSHR).inject(value=0.01)
    plain = circled(MujocoPlant(MUSHR), 0.1, 2.2)
    for changes in ([slip, understeer], [understeer, slip]):
        state = circled(MujocoPlant(MUSHR, changes), 0.1, 2.2)
        assert gradient(0.1, state) - gradient(0.1, plain) == pytest.approx(0.01, rel=0.02)
        assert compliance(state) - compliance(plain) == pytest.approx(0.005, rel=0.02)


@pytest.mark.parametrize("key", ["understeer", "tyre_slip"])
def test_tyres_of_a_car_that_drives_backwards_slip_the_other_way(key: str) -> None:
    ahead, back = predicted(key, 0.01, 0.2, 1.5), predicted(key, 0.01, 0.2, -1.5)
    if key == "understeer":
        assert gradient(0.2, ahead) == pytest.approx(0.01, rel=0.02)
        assert gradient(0.2, back) == pytest.approx(-0.01, rel=0.02)
    else:
        assert turn(ahead)[1] < 0.0
        assert turn(back)[1] < 0.0  # outwards of a left turn either way
    axles = [MujocoPlant(MUSHR, changes) for changes in ([], [effect(key, MUSHR).inject(value=0.01)])]
    measure = gradient if key == "understeer" else lambda _, state: compliance(state)
    plain, changed = (measure(0.2, circled(plant, 0.2, -1.5)) for plant in axles)
    assert changed - plain == pytest.approx(-0.01 if key == "understeer" else 0.01, rel=0.1)


def test_sensors_report_the_velocity_of_the_car_and_not_that_of_its_base() -> None:
    sensed = effect("sensor_scale:vx", MUSHR).substitute(nominal(MUSHR), {"value": 1.1})
    assert effect("tyre_slip", MUSHR).substitute(sensed, {"value": 0.01}).output == sensed.output != {}


def test_oversteer_beyond_the_critical_speed_stays_finite() -> None:
    assert np.isfinite(predicted("understeer", -0.02, 0.1, 2.4)).all()


def standard_drives(*changes: Change) -> Dataset:
    def plant(rng: np.random.Generator) -> MujocoPlant:
        return MujocoPlant(MUSHR, (*changes, standard_trim.disturbance(MUSHR, rng), sensors(MUSHR, rng)))

    return Dataset([standard_run(MUSHR, plant, 3, index) for index in range(0, 8, 2)])


@pytest.mark.slow
def test_tyres_that_must_roll_before_they_push_are_named_and_not_a_lag_of_the_steering() -> None:
    data = standard_drives(effect("relaxation_length", MUSHR).inject(value=0.1))
    found = diagnose(nominal(MUSHR), data, MujocoPlant(MUSHR))
    assert [one.effect for one in found.findings] == ["relaxation_length"]
    # As exact as the formula is beside MuJoCo's tyres (effects_cases.py).
    assert found.findings[0].values["value"] == pytest.approx(0.1, rel=0.15)


@pytest.mark.slow
def test_a_soft_steering_with_caster_is_diagnosed_as_the_understeer_that_its_circles_have() -> None:
    """The ground pushes the front wheels behind their steering axes, against servos that give way."""

    def caster(spec: Any) -> None:
        for side in ("left", "right"):
            spec.joint(f"front_{side}_steer").pos = [TRAIL, 0.0, 0.0]

    soft = Change("caster", edit=caster)
    drives = standard_drives(soft)
    fastest = max(float(drive.action[:, 1].max()) for drive in drives.trajectories)
    slow, fast = (gradient(0.2, circled(MujocoPlant(MUSHR, [soft]), 0.2, speed)) for speed in (0.9, fastest))
    found = diagnose(nominal(MUSHR), drives, MujocoPlant(MUSHR))
    values = {one.effect: one.values for one in found.findings}
    assert 0.0 < fast < slow
    assert fast < values["understeer"]["value"] < slow
    assert "gain:steer" not in values


def steered(step: Callable[[Array], Array], speed: float) -> Array:
    """Yaw rate after each of some steps from a straight drive on, the steering held ``# (steps,)``."""
    rates = [step(np.array([0.2 if number else 0.0, speed]))[6] for number in range(1 + 20)]
    return np.array(rates[1:])


@pytest.mark.parametrize("speed", [0.8, 1.6, -1.6])
def test_a_turn_begins_over_a_distance_that_no_speed_changes(speed: float) -> None:
    """After so many relaxation lengths n, 1 - e^-n of the turn is there: by simulated wheels, and by the equations."""
    length, found = 0.4, effect("relaxation_length", MUSHR)
    plants = [MujocoPlant(MUSHR, changes) for changes in ([], [found.inject(value=length)])]
    for plant in plants:
        plant.reset(start(0.0, speed))
    plain, turned = (steered(plant.step, speed) for plant in plants)
    rolled = abs(speed) * MUSHR.dt * np.arange(1, len(turned) + 1)
    expected = 1 - np.exp(-rolled / length)
    np.testing.assert_allclose((turned / plain)[2:], expected[2:], atol=0.06)
    middle = length / (abs(speed) * MUSHR.dt) * -np.diff(np.exp(-np.concatenate([[0.0], rolled]) / length))
    for share, part in ((0.0, expected), (1.0, 1 - middle)):  # a gyro shows the turn of a step's end, or its mean
        equations = found.substitute(nominal(MUSHR), {"value": length, "mean_share": share})
        model = VisibleModel(equations, torch.float64)
        actions = torch.tensor([[0.0, speed], *[[0.2, speed]] * 20], dtype=torch.float64)
        rates = model.rollout(torch.as_tensor(start(0.0, speed)), actions)[1:, 6].numpy()
        np.testing.assert_allclose(rates / (speed * np.tan(0.2) / WHEELBASE), part, atol=0.01)


@pytest.mark.parametrize(("steer", "speed", "value"), [(0.3, 1.6, 0.3), (0.25, 2.2, 0.3), (0.35, 1.6, 0.4)])
def test_on_slippery_ground_a_turn_begins_late(steer: float, speed: float, value: float) -> None:
    """Step by step like that of simulated wheels: of the rate that it reaches, the car has a third after one step."""
    found = effect("tyre_friction", MUSHR)
    slippery = MujocoPlant(MUSHR, [found.inject(value=value)])
    slippery.reset(start(0.0, speed))
    model = compile_model(found.substitute(nominal(MUSHR), {"value": value}), dtype=torch.float64)
    state, simulated, rates = torch.as_tensor(start(0.0, speed)), list[float](), list[float]()
    for command in ([0.0, speed], *[[steer, speed]] * 10):
        simulated.append(slippery.step(np.array(command))[6])
        state = MUSHR.layouts.state.normalise(model(state, torch.tensor(command, dtype=torch.float64)))
        rates.append(float(state[6]))
    np.testing.assert_allclose(rates, simulated, atol=0.08 * max(simulated))
    assert 0.2 * rates[-1] < rates[1] < 0.45 * rates[-1]


def test_tyres_that_slide_in_a_turn_have_less_left_for_the_drive() -> None:
    """What a speed command of 1 m/s more brings in a step, straight ahead and in a turn beyond the tyres' limit."""
    found = effect("tyre_friction", MUSHR)
    slippery = MujocoPlant(MUSHR, [found.inject(value=0.3)])
    model = compile_model(found.substitute(nominal(MUSHR), {"value": 0.3}), dtype=torch.float64)
    simulated, expected = list[float](), list[float]()
    for steer in (0.0, 0.3):
        state = circled(slippery, steer, 1.6)
        command = np.array([steer, 2.6])
        following = model(torch.as_tensor(state), torch.as_tensor(command)).numpy()
        simulated.append(turn(slippery.step(command))[0] - turn(state)[0])
        expected.append(turn(following)[0] - turn(state)[0])
    assert simulated[1] < 0.9 * simulated[0]
    np.testing.assert_allclose(expected, simulated, rtol=0.2)


def test_tyres_of_a_car_that_stands_keep_their_turn() -> None:
    equations = effect("relaxation_length", MUSHR).substitute(nominal(MUSHR), {"value": 0.2})
    model = compile_model(equations, dtype=torch.float64)
    state = torch.cat([torch.as_tensor(start(0.0, 0.0)), torch.tensor([0.1], dtype=torch.float64)])
    assert float(model(state, torch.tensor([0.3, 0.0], dtype=torch.float64))[-1]) == pytest.approx(0.1, rel=0.01)
