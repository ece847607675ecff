"""Equations gone through until the next row of a slower log: against repeated steps, and against exact solutions."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from numpy.typing import ArrayLike
from scipy.linalg import expm
from sympy import sin

from sym2real.errors import ModelError
from sym2real.layout import Layouts
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Memoryless
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations, compile_model, rollout, symbol
from sym2real.symbolic.period import at_period, steps_within
from sym2real.tasks import make_task
from sym2real.trajectory import Array, Trajectory

SWINGING = np.array([[0.0, 1.0], [-40.0, -3.0]])  # of a damped swing with a period of a second, 1/s


def swing(dt: float) -> Equations:
    """A damped swing, pushed by its action, solved exactly over a step."""
    whole = expm(dt * np.block([[SWINGING, np.array([[0.0], [1.0]])], [np.zeros((1, 3))]]))
    state, pushed = ("x", "vx"), symbol("speed")
    after = {
        column: sum(float(row[place]) * symbol(name) for place, name in enumerate(state)) + float(row[2]) * pushed
        for column, row in zip(state, whole, strict=False)
    }
    return Equations(after, Layouts.of([*state, "speed"]), dt)


@pytest.mark.parametrize("steps", [1.2, 2.0, 2.5, 3.125, 6.0])
def test_a_longer_period_is_that_of_the_motion_itself(steps: float) -> None:
    state, action = torch.tensor([[0.3, -1.0], [0.0, 2.0]]).double(), torch.tensor([[1.0], [-4.0]]).double()
    for dt in (0.02, 0.01):
        slow = at_period(swing(dt), steps * dt)
        found = compile_model(slow, dtype=torch.float64)(state, action)
        exact = compile_model(swing(steps * dt), dtype=torch.float64)(state, action)
        assert slow.dt == pytest.approx(steps * dt)
        # What is left is of the third power of the step at least, and none where the period is whole steps.
        bound = 1e-12 if steps == round(steps) else 60.0 * dt**3 * float(state.abs().max())
        assert float((found - exact).abs().max()) < bound


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR], ids=lambda robot: robot.name)
def test_whole_steps_are_the_steps_themselves(robot: Robot) -> None:
    equations = robot.nominal()
    rng = np.random.default_rng(4)
    layout = equations.layouts
    state = layout.state.normalise(torch.as_tensor(rng.normal(0.5, 0.3, (7, layout.state.size))))
    action = torch.as_tensor(rng.uniform(robot.low, robot.high, (7, len(layout.action))))
    inputs = torch.as_tensor(rng.normal(0.0, 0.01, (7, len(layout.inputs))))
    fast, slow = (
        compile_model(model, dtype=torch.float64) for model in (equations, at_period(equations, 3 * equations.dt))
    )
    repeated = rollout(fast, state, action[:, None].expand(-1, 3, -1), inputs)[:, -1]
    torch.testing.assert_close(slow(state, action, inputs), repeated, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("steps", [1.5, 2.0, 2.5, 4.0])
def test_time_goes_on_in_parts_of_a_step(steps: float) -> None:
    model = Equations({"x": symbol("x") + 0.1 * (symbol("t") + 0.05)}, Layouts.of(["x", "speed", "t"]), 0.1)
    slow = compile_model(at_period(model, steps * 0.1), dtype=torch.float64)
    start, none, now = torch.zeros(1, 1).double(), torch.zeros(1, 1).double(), torch.tensor([[0.7]]).double()
    # The integral of t.
    expected = 0.5 * ((now + steps * 0.1) ** 2 - now**2)
    torch.testing.assert_close(slow(start, none, now), expected, rtol=1e-6, atol=1e-9)


def test_a_period_in_another_unit_is_refused() -> None:
    with pytest.raises(ModelError, match="at most 20 of the model's steps"):
        at_period(MUSHR.nominal(), 50.0)


def test_time_goes_on_within_a_period_and_parameters_stay_free() -> None:
    layouts, rate = Layouts.of(["x", "vx", "speed", "t"]), symbol("rate")
    after = {"x": symbol("x") + 0.1 * sin(rate * symbol("t")), "vx": symbol("vx") + symbol("speed")}
    slow = compile_model(at_period(Equations(after, layouts, 0.1, parameters={"rate": 2.0}), 0.3), dtype=torch.float64)
    start, sent, now = torch.zeros(1, 2).double(), torch.ones(1, 1).double(), torch.tensor([[0.7]], dtype=torch.float64)
    for values in (2.0, 5.0):
        found = slow(start, sent, now, torch.tensor([values]).double())
        expected = 0.1 * np.sin(values * np.array([0.7, 0.8, 0.9])).sum()
        np.testing.assert_allclose(found.numpy(), [[expected, 3.0]], rtol=1e-12)


def test_a_period_no_longer_than_the_step_changes_nothing() -> None:
    equations = CRAZYFLIE.nominal()
    assert at_period(equations, equations.dt) is equations
    assert at_period(equations, 0.999 * equations.dt) is equations


def test_a_clock_that_is_a_little_slower_is_a_longer_period() -> None:
    """A car goes 0.8 % farther in it, which would be taken for a gain."""
    equations = MUSHR.nominal()
    slow = at_period(equations, 1.008 * equations.dt)
    assert slow.dt == pytest.approx(1.008 * equations.dt)
    state = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    ways = [one.predict(state, np.array([0.0, 1.0]))[0] for one in (equations, slow)]
    assert ways[1] / ways[0] == pytest.approx(1.008, rel=1e-3)
    assert steps_within(equations, 2.999 * equations.dt) == steps_within(equations, 3.001 * equations.dt) == 3


def test_a_log_of_every_third_row_is_predicted_as_every_row_is() -> None:
    """Commands held over three rows: whether all are in the log or one of them must not matter to a prediction."""
    model, task = MUSHR.nominal(), make_task("circle", MUSHR)
    rng = np.random.default_rng(8)

    class Held(Memoryless):
        """New commands every third row."""

        def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
            """One of the drawn commands."""
            return np.asarray(commands[step // 3])

    commands = np.column_stack([rng.uniform(-0.2, 0.3, 200), rng.uniform(0.8, 1.6, 200)])
    log = run_episode(MujocoPlant(MUSHR), Held(), task, steps=240)
    rows = slice(0, None, 3)
    thin = Trajectory(log.time[rows], log.state[rows], log.action[rows], log.inputs[rows], log.layouts)
    np.testing.assert_allclose(model.simulate(thin).state, model.simulate(log).state[rows], atol=1e-8)
