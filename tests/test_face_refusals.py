"""What is called in another way than it can be is one error of this package, which says what was expected."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from sym2real import MPPI, Layouts, Trajectory, add, compile_model, diagnose, load_model, make_task
from sym2real.errors import ModelError, Sym2RealError
from sym2real.neural import Composed, ResidualMLP
from sym2real.robots import MUSHR, ROBOTS

MODEL = MUSHR.nominal()
LOG = Trajectory.from_arrays(
    np.tile(MUSHR.start, (60, 1)), np.zeros((60, 2)), MODEL.layouts, dt=MODEL.dt, name="parked"
)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: MODEL.predict(np.zeros((4, 5)), np.zeros((4, 2))), r"state: expected \(..., 7\), columns x y sin_yaw"),
        (
            lambda: MODEL.predict(np.zeros((4, 2)), np.zeros((4, 7))),
            r"state: expected \(..., 7\).*found shape \(4, 2\)",
        ),
        (
            lambda: MODEL.predict(torch.zeros(4, 7), torch.zeros(4, 3)),
            r"action: expected \(..., 2\), columns steer speed",
        ),
        (
            lambda: MODEL.predict(np.zeros(7), np.zeros(2), np.zeros(2)),
            r"inputs: expected \(..., 3\), columns fx fy tz",
        ),
        (lambda: MODEL.predict(None, np.zeros(2)), r"state: expected \(..., 7\)"),
        (lambda: MODEL.simulate(LOG, float("nan")), "horizon of at least one time step"),
        (lambda: MODEL.score(LOG, 9.0), "has 60 rows; a window of 180 steps"),
        (lambda: diagnose(MODEL, LOG, MUSHR), r"plant: expected a simulator, as MujocoPlant\(robot\)"),
        (lambda: add(MODEL, "offset:steer", 0.05), "values: expected numbers by parameter"),
        (lambda: MPPI(MODEL, MUSHR, make_task("circle", MUSHR)), r"compile_model\(equations\), found Equations"),
        (lambda: compile_model(Composed(MODEL, ResidualMLP(MODEL.layouts, (4,)))), "found Composed"),
        (lambda: load_model(__file__), "found a file"),
        (lambda: Trajectory.from_arrays(LOG.state, LOG.action, MODEL.layouts, dt=-0.02), "dt: expected a time step"),
        (lambda: Trajectory.from_arrays(LOG.state, LOG.action, MODEL.layouts, dt="0.02"), "dt: expected a time step"),
        (
            lambda: Trajectory.from_arrays(LOG.state, LOG.action, MODEL.layouts.state, dt=0.02),
            "layouts: expected Layouts",
        ),
        (
            lambda: Trajectory.from_arrays(None, LOG.action, MODEL.layouts, dt=0.02),
            "state: expected an array of numbers",
        ),
        (lambda: Trajectory.from_arrays(LOG.state, LOG.action, MODEL.layouts, time=0.0), "time: expected a stamp"),
        (lambda: Trajectory.from_arrays(LOG.state, LOG.action, MODEL.layouts, time=["soon"] * 60), "time: expected"),
        (lambda: MODEL.predict(torch.zeros(7), [0.0, 0.0, 0.0]), r"action: expected \(..., 2\)"),
        (lambda: Trajectory.from_arrays([["a"]], [[0]], MODEL.layouts, dt=0.02), "state: expected an array of numbers"),
    ],
)
def test_it_is_said_what_was_expected(call: Callable[[], Any], said: str) -> None:
    with pytest.raises(Sym2RealError, match=said):
        call()


@pytest.mark.parametrize(
    ("cost", "found"),
    [
        (lambda s, a, r: s[..., 0] > 1.0, r"found torch.bool"),
        (lambda s, a, r: s[..., 0].numpy(), "found ndarray"),
        (lambda s, a, r: s.square().sum(), r"found torch.float32 \(\)"),
    ],
)
def test_a_cost_of_ones_own_is_a_number_for_every_sample_and_step(cost: Callable[..., Any], found: str) -> None:
    task = replace(make_task("circle", MUSHR), name="mine", cost=cost)
    controller = MPPI(compile_model(MODEL), MUSHR, task, backend="torch")
    with pytest.raises(Sym2RealError, match=rf"cost of task 'mine': expected a tensor of floats \(\d+, \d+\), {found}"):
        controller.act(MUSHR.start, step=0)


def test_dates_are_stamps_from_the_first_one_on_and_a_gradient_is_no_hindrance() -> None:
    layouts, state = Layouts.of(["x", "vx", "speed"]), torch.ones(4, 2, requires_grad=True)
    time = np.datetime64("2026-11-27T12:00:00") + np.arange(4) * np.timedelta64(20, "ms")
    log = Trajectory.from_arrays(state, np.zeros((4, 1)), layouts, time=time)
    np.testing.assert_allclose(log.time, [0.0, 0.02, 0.04, 0.06])
    later = Trajectory.from_arrays(state, np.zeros((4, 1)), layouts, time=time.astype(object).tolist())
    np.testing.assert_allclose(later.time, log.time)
    np.testing.assert_array_equal(log.state, 1.0)


def test_less_than_nothing_hangs_nowhere() -> None:
    with pytest.raises(ModelError, match=r"load:tool: expected .* kg for value, found -50"):
        add(ROBOTS["arm"].nominal(), "load:tool", {"value": -50.0})
