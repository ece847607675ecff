"""MPPI with states that nobody measures: rotors and tyres still answer what was sent before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import torch
from reference_models import motor_lagged

from sym2real.control import MPPI, mppi_controller
from sym2real.control.gone_by import HiddenStates
from sym2real.control.plan import shift
from sym2real.diagnosis import add
from sym2real.effects.filters import FilterState, with_hidden_start
from sym2real.effects.visible import VisibleModel, visible_state
from sym2real.native import find_compiler
from sym2real.neural import Composed, ResidualMLP
from sym2real.plants import EquationsPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations, compile_model, rollout
from sym2real.tasks import make_task
from sym2real.trajectory import Array


def effects(robot: Robot, **values: float) -> Callable[[], Equations]:
    """Nominal equations with effects of one value each, those with hidden states among them."""

    def made() -> Equations:
        equations = robot.nominal()
        for key, value in values.items():
            equations = add(equations, key, {"value": value})
        return equations

    return made


CASES = {
    "motor lag": (CRAZYFLIE, effects(CRAZYFLIE, motor_lag=0.1)),
    "motor lag behind a delay": (CRAZYFLIE, effects(CRAZYFLIE, motor_lag=0.1, delay=0.03)),
    "rotor reaction": (CRAZYFLIE, effects(CRAZYFLIE, rotor_reaction=1e-6)),
    "relaxation length": (MUSHR, effects(MUSHR, relaxation_length=0.4)),
}
BACKENDS = [
    pytest.param("c", marks=pytest.mark.skipif(find_compiler() is None, reason="no C compiler")),
    "torch",
]


def controller(robot: Robot, model: object, backend: str, samples: int = 64) -> MPPI:
    equations = model.equations
    filters = FilterState(equations) if equations.filters else None
    settings = replace(robot.mppi, samples=samples)
    return MPPI(model, robot, make_task("circle", robot), settings=settings, backend=backend, filters=filters)


def driven(mppi: MPPI, plant: EquationsPlant, steps: int) -> Array:
    """The state after some steps of commands that change, each remembered."""
    rng, robot = np.random.default_rng(0), mppi.robot
    state = plant.reset(mppi.task.start(rng))
    mppi.reset()
    for step in range(steps):
        mppi.act(state, step, plant.inputs)
        state = plant.step(robot.rest + 0.2 * rng.uniform(-1, 1, len(robot.rest)) * (robot.high - robot.rest))
        mppi.remember(plant.sent)
    return state


def tracking_error(model: Equations, plant: EquationsPlant) -> float:
    """Root of the mean square of the position error (m) on the circle, without its first second."""
    task = make_task("circle", CRAZYFLIE)
    log = run_episode(plant, mppi_controller(model, CRAZYFLIE, task, samples=512), task, steps=300)
    assert len(log) == 300
    away = [log.column(axis) - log.column(f"ref_{axis}") for axis in ("x", "y", "z")]
    return float(np.sqrt((np.square(away).sum(axis=0)[50:]).mean()))


def test_a_controller_that_knows_of_a_motor_lag_flies_better_than_one_that_does_not() -> None:
    base = CRAZYFLIE.nominal()
    lagging = add(base, "motor_lag", {"value": 0.1})
    plant = EquationsPlant(lagging, CRAZYFLIE)
    assert tracking_error(lagging, plant) < tracking_error(base, plant) / 3


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("backend", BACKENDS)
def test_predicts_what_then_happens(name: str, backend: str) -> None:
    """In the middle of an episode, the rollout of the mean is where the plant goes when the mean is sent."""
    robot, make = CASES[name]
    equations = make()
    plant, mppi = EquationsPlant(equations, robot), controller(robot, VisibleModel(equations), backend)
    state = driven(mppi, plant, 7)
    mppi.act(state, 7, plant.inputs)
    planned = mppi.mean.double().numpy()
    predicted = mppi.improve(state, 7, torch.zeros(mppi.samples, *mppi.mean.shape), plant.inputs).states[0].numpy()
    happened = np.array([plant.step(action) for action in planned])
    np.testing.assert_allclose(predicted, happened, atol=2e-4)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize(("name", "residual"), [*((name, False) for name in CASES), ("motor lag behind a delay", True)])
def test_the_kernel_plans_from_hidden_states_as_torch_does(name: str, residual: bool) -> None:
    robot, make = CASES[name]
    equations = make()
    plant, model = EquationsPlant(equations, robot), VisibleModel(equations)
    if residual:
        network = ResidualMLP(robot.layouts, (12,), commands=2)
        torch.nn.init.normal_(network.linears[-1].weight, 0.0, 1e-3, generator=torch.Generator().manual_seed(0))
        model = Composed(equations, network)
    fused, slow = (controller(robot, model, backend) for backend in ("c", "torch"))
    for one in (slow, fused):
        state = driven(one, plant, 5)
    before = fused.mean.clone()
    fused.act(state, 5, plant.inputs)
    given, _ = fused._seen
    slow.mean, noise = shift(given.mean, given.steps), fused._fused.noise(fused.seed, fused._call)
    torch.testing.assert_close(slow._gone_by.hidden(), fused._gone_by.hidden(), rtol=0, atol=0)
    plan = slow.improve(state, 5, noise, plant.inputs)
    torch.testing.assert_close(fused.plan.costs, plan.costs, rtol=2e-5, atol=1e-5)
    torch.testing.assert_close(fused.plan.states, plan.states)
    scale = torch.tensor(robot.high - robot.low).float()
    assert float(((fused.mean - slow.mean).abs() / scale).max()) < 5e-5
    for one in (slow, fused):
        one.reset()
        one.mean = before
    begun = slow.improve(state, 5, noise, plant.inputs)  # as if these hidden states were at their start
    torch.testing.assert_close(fused.improve(state, 5, noise, plant.inputs).costs, begun.costs, rtol=2e-5, atol=1e-5)
    assert float((begun.costs - plan.costs).abs().max()) > 1e-3


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_reset_forgets_them(backend: str) -> None:
    equations = motor_lagged()
    mppi, plant = controller(CRAZYFLIE, VisibleModel(equations), backend), EquationsPlant(equations, CRAZYFLIE)
    first = mppi.act(CRAZYFLIE.start, 0)
    driven(mppi, plant, 4)
    assert mppi._gone_by.hidden() is not None
    mppi.reset()
    assert mppi._gone_by.hidden() is None
    np.testing.assert_array_equal(mppi.act(CRAZYFLIE.start, 0), first)


def test_they_are_those_of_the_plant() -> None:
    for robot, make in CASES.values():
        equations = make()
        plant, mppi = EquationsPlant(equations, robot), controller(robot, VisibleModel(equations), "torch", samples=2)
        driven(mppi, plant, 9)
        torch.testing.assert_close(mppi._gone_by.hidden().double(), plant._hidden, rtol=1e-5, atol=1e-5)


def test_a_lost_pose_leaves_them_as_sound_as_they_can_be() -> None:
    """The thrust follows its commands alone; what needs the turn rates waits for them, at the start as later."""
    equations = add(CRAZYFLIE.nominal(), "motor_lag", {"value": 0.1})
    thrust = list(equations.start).index("rotor_thrust_memory")
    lost, known = np.full(CRAZYFLIE.start.shape, np.nan), CRAZYFLIE.start
    seen, blind = HiddenStates(equations), HiddenStates(equations)
    blind.advance(lost, CRAZYFLIE.rest)
    assert blind.now.tolist() == [0.0 if row != thrust else CRAZYFLIE.rest[0] for row in range(len(blind.now))]
    for hidden in (seen, blind):
        hidden.advance(known, CRAZYFLIE.rest)
    before = blind.now.clone()
    command = CRAZYFLIE.rest + np.array([0.1, 0.4, -0.3, 0.2])
    seen.advance(known, command)
    blind.advance(lost, command)
    assert float(blind.now[thrust]) == float(seen.now[thrust]) > float(before[thrust])
    others = [row for row in range(len(before)) if row != thrust]
    torch.testing.assert_close(blind.now[others], before[others], rtol=0, atol=0)
    assert float((seen.now - before)[others].abs().min()) > 0


def test_a_rollout_may_start_with_them() -> None:
    equations = motor_lagged()
    generator, columns = torch.Generator().manual_seed(0), len(visible_state(equations))
    start = torch.tensor(CRAZYFLIE.start) + 0.1 * torch.randn(5, columns, generator=generator, dtype=torch.float64)
    actions = torch.tensor(CRAZYFLIE.rest) + 0.1 * torch.randn(5, 6, 4, generator=generator, dtype=torch.float64)
    whole = with_hidden_start(equations, start, actions[:, 0])
    torch.testing.assert_close(with_hidden_start(equations, whole, actions[:, 0]), whole, rtol=0, atol=0)
    whole[:, columns:] += torch.randn(5, len(equations.start), generator=generator)
    expected = rollout(compile_model(equations, dtype=torch.float64), whole, actions)[..., :columns]
    torch.testing.assert_close(VisibleModel(equations, torch.float64).rollout(whole, actions), expected)
    still = ResidualMLP(CRAZYFLIE.layouts, (4,))
    torch.nn.init.zeros_(still.linears[-1].weight)
    torch.testing.assert_close(rollout(Composed(equations, still, torch.float64), whole, actions), expected)
