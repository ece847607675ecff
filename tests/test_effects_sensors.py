"""States and measurements: one way undoes the other, and comparing a tilted log with a tilted model shows no error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from sym2real.control import geometric_controller, mppi_controller
from sym2real.diagnosis import add, compare
from sym2real.effects import effect
from sym2real.effects.sensors import Sensors
from sym2real.errors import ModelError, ShapeError
from sym2real.experiments.flying import fly
from sym2real.layout import Layout
from sym2real.plants import ModelPlant, MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import compile_model
from sym2real.tasks import make_task

CASES = [
    (CRAZYFLIE, "mounting_tilt", {"roll": 0.1, "pitch": -0.2}),
    (CRAZYFLIE, "mounting_yaw", {"value": 0.4}),
    (CRAZYFLIE, "marker_tilt", {"roll": 0.06, "pitch": -0.04}),
    (CRAZYFLIE, "yaw_bias", {"value": 0.4}),
    (CRAZYFLIE, "sensor_sign:wy", {"value": -1.0}),
    (CRAZYFLIE, "sensor_scale:vx", {"value": 3.0}),
    (CRAZYFLIE, "sensor_bias:z", {"value": 0.3}),
    (CRAZYFLIE, "lever_arm", {"rx": 0.05, "ry": -0.03, "rz": 0.04}),
    (MUSHR, "yaw_bias", {"value": 0.4}),
    (MUSHR, "lever_arm", {"rx": 0.1, "ry": -0.05}),
]


@pytest.mark.parametrize(("robot", "key", "values"), CASES, ids=lambda value: value if isinstance(value, str) else "")
def test_a_measured_state_leads_back_to_the_state(robot: Robot, key: str, values: dict[str, float]) -> None:
    sensors = Sensors(add(robot.nominal(), key, values))
    generator = torch.Generator().manual_seed(0)
    layout = robot.layouts.state
    states = layout.normalise(torch.randn(20, layout.size, generator=generator, dtype=torch.float64))
    measured = sensors.measured(states)
    assert float(layout.difference(measured, states).abs().max()) > 0.05
    torch.testing.assert_close(
        layout.difference(sensors.state(measured), states), torch.zeros(20, layout.tangent_size).double(),
        atol=1e-6, rtol=0,
    )  # fmt: skip


@pytest.mark.parametrize(("robot", "key", "values"), CASES, ids=lambda value: value if isinstance(value, str) else "")
def test_what_a_sensor_really_did_is_undone(robot: Robot, key: str, values: dict[str, float]) -> None:
    """The measurement is the injected one, which shares no formula with the equations' output."""
    layout = robot.layouts.state
    truth = layout.normalise(torch.as_tensor(np.random.default_rng(2).standard_normal((5, len(layout)))))
    change = effect(key, robot).inject(**values)
    assert change.measure is not None
    measure = change.measure()
    measured = torch.as_tensor(np.array([measure(row) for row in truth.numpy()]))
    returned = Sensors(add(robot.nominal(), key, values)).state(measured)
    assert float(layout.difference(returned, truth).abs().max()) < 1e-9


@pytest.mark.parametrize("key", ["sensor_lag:x", "time_shift:x"])
def test_control_with_what_cannot_be_undone_is_refused(key: str) -> None:
    late = add(CRAZYFLIE.nominal(), key, {"value": 0.04})
    with pytest.raises(ModelError, match=f"{key} cannot be undone"):
        mppi_controller(late, CRAZYFLIE, make_task("hover", CRAZYFLIE), samples=64)


def test_without_measurement_effects_nothing_changes() -> None:
    sensors, state = Sensors(CRAZYFLIE.nominal()), torch.as_tensor(CRAZYFLIE.start)
    assert sensors.measured(state) is state
    assert sensors.state(state) is state


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR], ids=lambda robot: robot.name)
def test_one_inverse_serves_state_after_state_and_leaves_what_is_not_finite(robot: Robot) -> None:
    layout, rng = robot.layouts.state, np.random.default_rng(0)
    key, values = ("lever_arm", {"rx": 0.3, "ry": -0.2}) if robot is MUSHR else ("mounting_tilt", {"roll": 0.4})
    sensors = Sensors(add(robot.nominal(), key, values))
    for _ in range(20):
        tangent = torch.as_tensor(rng.uniform(-2.0, 2.0, layout.tangent_size))
        state = layout.retract(torch.as_tensor(robot.start), tangent)
        torch.testing.assert_close(sensors.state(sensors.measured(state)), state, rtol=0.0, atol=1e-9)
    lost = torch.full((layout.size,), torch.nan, dtype=torch.float64)
    assert sensors.state(lost).isnan().all()


def test_a_model_with_the_tilt_predicts_a_tilted_log() -> None:
    tilt = {"roll": 0.03, "pitch": -0.02}
    task = make_task("circle", CRAZYFLIE)
    plant = MujocoPlant(CRAZYFLIE, [effect("mounting_tilt", CRAZYFLIE).inject(**tilt)])
    log = fly(plant, geometric_controller(CRAZYFLIE, task.reference), task, seconds=4.0).trajectory
    plain = CRAZYFLIE.nominal()
    errors = [
        compare(model, log, start="measured").at(0.5).errors for model in (plain, add(plain, "mounting_tilt", tilt))
    ]
    assert errors[1]["position"].value < 0.05 * errors[0]["position"].value


def test_mppi_flies_where_it_should_with_a_tilt_that_it_knows() -> None:
    tilt = {"roll": 0.08}
    task = make_task("hover", CRAZYFLIE)
    changes = [effect("mounting_tilt", CRAZYFLIE).inject(**tilt)]
    plain = CRAZYFLIE.nominal()
    finals = [
        fly(
            MujocoPlant(CRAZYFLIE, changes),
            mppi_controller(model, CRAZYFLIE, task, samples=128),
            task,
            seconds=3.0,
        ).final
        for model in (plain, add(plain, "mounting_tilt", tilt))
    ]
    assert finals[1] < 0.5 * finals[0]
    assert np.isfinite(finals[0])


def test_a_model_that_fades_with_time_predicts_a_log_without_a_clock() -> None:
    task = make_task("hover", CRAZYFLIE)
    plant = MujocoPlant(CRAZYFLIE, [effect("battery_sag", CRAZYFLIE).inject(value=0.02)])
    log = fly(plant, geometric_controller(CRAZYFLIE, task.reference), task, seconds=5.0).trajectory
    assert "t" not in log.layouts.inputs
    plain = CRAZYFLIE.nominal()
    errors = [compare(model, log).at(0.5).errors for model in (plain, add(plain, "battery_sag", {"value": 0.02}))]
    assert errors[1]["position"].value < 0.2 * errors[0]["position"].value


def test_mppi_flies_models_whose_inputs_are_not_the_robots() -> None:
    """Thrust that fades has a clock, equations fitted to logs have no wrench; the simulator gives a wrench alone."""
    plain, task = CRAZYFLIE.nominal(), make_task("hover", CRAZYFLIE)
    unpushed = plain.substitute(dict.fromkeys(plain.layouts.inputs, 0.0))
    unpushed = replace(unpushed, layouts=replace(plain.layouts, inputs=Layout(())))
    fading = add(plain, "battery_sag", {"value": 0.05})
    finals = []
    for model, changes in (
        (unpushed, []),
        (fading, [effect("battery_sag", CRAZYFLIE).inject(value=0.05)]),
    ):
        controller = mppi_controller(model, CRAZYFLIE, task, samples=64)
        finals.append(fly(MujocoPlant(CRAZYFLIE, changes), controller, task, seconds=4.0).final)
        assert controller.samples == 64
    assert max(finals) < 0.05


@pytest.mark.parametrize("values", [("battery_sag", {"value": 0.02}), ("motor_lag", {"value": 0.05})])
def test_a_model_with_a_clock_or_hidden_states_is_no_plant(values: tuple[str, dict[str, float]]) -> None:
    with pytest.raises(ShapeError, match="cannot step a model of"):
        ModelPlant(compile_model(add(CRAZYFLIE.nominal(), *values)), CRAZYFLIE)
