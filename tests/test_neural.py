"""Networks: shapes, start at nothing, composition with equations, files, and the residual in the fused kernel."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from reference_models import flying, late, motor_lagged
from tracked import tracked

from sym2real.control import MPPI, RandomCommands
from sym2real.diagnosis.data.windows import predict_windows
from sym2real.effects.filters import FilterState, with_hidden_start
from sym2real.effects.visible import VisibleModel
from sym2real.errors import DataError, ShapeError
from sym2real.layout import Layout, Layouts
from sym2real.native import find_compiler
from sym2real.neural import (
    Composed,
    Descent,
    Ensemble,
    EnsembleTraining,
    ResidualMLP,
    ResidualTraining,
    load_residual,
    open_model,
    save_model,
)
from sym2real.neural.storage import network_file
from sym2real.plants import ModelPlant, MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations, compile_model, rollout
from sym2real.tasks import make_task


def lively(robot: Robot, widths: tuple[int, ...], commands: int = 0, states: int = 0) -> ResidualMLP:
    """A residual that matters: a few millimetres and milliradians a step."""
    residual = ResidualMLP(robot.layouts, widths, seed=1, commands=commands, states=states)
    generator = torch.Generator().manual_seed(2)
    with torch.no_grad():
        residual.linears[-1].weight.normal_(0.0, 0.3, generator=generator)
        residual.linears[-1].bias.normal_(0.0, 0.3, generator=generator)
        residual.input_mean.normal_(0.0, 0.5, generator=generator)
        residual.input_scale.uniform_(0.5, 3.0, generator=generator)
        residual.output_scale.fill_(3e-3)
    return residual


def batch(robot: Robot, count: int) -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(0)
    state = torch.tensor(robot.start).float() + 0.1 * torch.randn(count, robot.start.size, generator=generator)
    actions = torch.tensor(robot.rest).float() + 0.1 * torch.randn(count, 5, robot.rest.size, generator=generator)
    return robot.layouts.state.normalise(state), actions


def test_an_untrained_residual_changes_nothing() -> None:
    equations = CRAZYFLIE.nominal()
    state, actions = batch(CRAZYFLIE, 4)
    composed = Composed(equations, ResidualMLP(CRAZYFLIE.layouts))
    torch.testing.assert_close(rollout(composed, state, actions), compile_model(equations).rollout(state, actions))


def test_time_goes_on_below_a_residual_too() -> None:
    layouts = Layouts(Layout.of(["x", "vx"]), Layout.of(["speed"]), Layout.of(["fx", "t"]))
    equations = Equations.parse(layouts, {"x": "x + 0.1*vx", "vx": "vx + 0.1*sin(2*t) + 0*fx"}, dt=0.1)
    composed = Composed(equations, ResidualMLP(Layouts(layouts.state, layouts.action)))
    state, actions = torch.zeros(3, 2), torch.zeros(10, 1)
    for inputs in (None, torch.tensor([0.0, 0.7]), torch.linspace(0.0, 2.0, 20).unflatten(0, (10, 2))):
        expected = compile_model(equations).rollout(state, actions, inputs)
        torch.testing.assert_close(rollout(composed, state, actions, inputs), expected)


@pytest.fixture
def doubled() -> Iterator[None]:
    torch.set_default_dtype(torch.float64)
    yield
    torch.set_default_dtype(torch.float32)


def test_plans_are_the_same_whatever_the_programs_precision(request: pytest.FixtureRequest) -> None:
    task = make_task("circle", MUSHR)
    models = (compile_model(MUSHR.nominal()), Composed(MUSHR.nominal(), lively(MUSHR, (8,))))
    plans = []
    for _ in range(2):
        planners = [MPPI(model, MUSHR, task) for model in models]
        plans.append([[planner.act(MUSHR.start, step) for step in range(3)] for planner in planners])
        request.getfixturevalue("doubled")
    np.testing.assert_array_equal(*plans)


@pytest.mark.usefixtures("doubled")
def test_networks_train_whatever_the_programs_precision() -> None:
    descent, transitions = Descent(steps=10), tracked(MujocoPlant(MUSHR), rows=59)
    trained = ResidualTraining(widths=(8,), steps=5, descent=descent).fit(transitions, MUSHR.nominal())
    ensemble = EnsembleTraining(members=2, widths=(8,), descent=descent).fit(transitions)
    assert {weight.dtype for model in (trained.residual, ensemble) for weight in model.parameters()} == {torch.float32}


def test_a_model_of_another_precision_leaves_the_first_as_it_was() -> None:
    state, actions = batch(MUSHR, 4)
    first = Composed(MUSHR.nominal(), lively(MUSHR, (8,)))
    before = rollout(first, state, actions)
    exact = Composed(first.below, first.residual, torch.float64)
    torch.testing.assert_close(rollout(first, state, actions), before, rtol=0.0, atol=0.0)
    torch.testing.assert_close(rollout(exact, state.double(), actions.double()).float(), before)


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR], ids=lambda robot: robot.name)
def test_a_composition_is_a_sum_on_the_manifold(robot: Robot) -> None:
    equations, residual = robot.nominal(), lively(robot, (32, 16))
    state, actions = batch(robot, 4)
    composed, base = Composed(equations, residual), compile_model(equations)
    expected = state
    found = rollout(composed, state, actions)
    for step in range(5):
        raw = base(expected, actions[:, step]) + residual(expected, actions[:, step])
        expected = robot.layouts.state.normalise(raw)
        torch.testing.assert_close(found[:, step], expected)
    assert float((found - base.rollout(state, actions)).detach().abs().max()) > 1e-3


def past_of(robot: Robot, count: int, commands: int, states: int) -> torch.Tensor:
    generator = torch.Generator().manual_seed(5)
    sent = torch.tensor(robot.rest).float() + 0.1 * torch.randn(count, commands, robot.rest.size, generator=generator)
    seen = torch.tensor(robot.start).float() + 0.1 * torch.randn(count, states, robot.start.size, generator=generator)
    return torch.cat([sent.flatten(1), seen.flatten(1)], dim=-1)


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR], ids=lambda robot: robot.name)
@pytest.mark.parametrize(("commands", "states"), [(3, 0), (0, 2), (4, 2), (10, 1)])
def test_actions_and_predicted_states_enter_the_past(robot: Robot, commands: int, states: int) -> None:
    composed = Composed(robot.nominal(), lively(robot, (32, 16), commands, states))
    (state, actions), past = batch(robot, 4), past_of(robot, 4, commands, states)
    found = rollout(composed, state, actions, past=past)
    sent, seen = past[:, : commands * robot.rest.size], past[:, commands * robot.rest.size :]
    for step in range(actions.shape[1]):
        following = composed(state, actions[:, step], past=torch.cat([sent, seen], dim=-1))
        torch.testing.assert_close(found[:, step], following)
        sent = torch.cat([actions[:, step], sent], dim=-1)[:, : sent.shape[1]]
        seen = torch.cat([state, seen], dim=-1)[:, : seen.shape[1]]
        state = following
    start = batch(robot, 4)[0]
    repeated = torch.cat([actions[:, :1].expand(-1, commands, -1).flatten(1), start.repeat(1, states)], dim=-1)
    torch.testing.assert_close(rollout(composed, start, actions), rollout(composed, start, actions, past=repeated))
    assert float((rollout(composed, start, actions) - found).detach().abs().max()) > 1e-4
    one = rollout(composed, start[0], actions, past=past[0])  # one start, many plans
    torch.testing.assert_close(one[2], rollout(composed, start[0], actions[2], past=past[0]))


def test_a_model_with_memory_steps_as_a_plant_and_explains_its_log_from_any_row() -> None:
    composed = Composed(MUSHR.nominal(), lively(MUSHR, (32, 16), commands=6, states=2), dtype=torch.float64)
    plant = ModelPlant(composed, MUSHR)
    controller = RandomCommands(MUSHR, seed=3)
    log = run_episode(plant, controller, steps=60)
    windows = predict_windows(composed, log, 20, start="measured")
    torch.testing.assert_close(windows.predicted, windows.measured)
    forgetful = rollout(composed, windows.start, torch.as_tensor(log.action[windows.rows[:, None] + np.arange(20)]))
    assert float((forgetful - windows.measured).detach().abs().max()) > 1e-3


def test_layers_are_the_network_over_raw_columns() -> None:
    residual = lively(MUSHR, (20, 12))
    state, actions = batch(MUSHR, 6)
    values = torch.cat([state, actions[:, 0]], dim=-1)
    for place, (weight, bias) in enumerate(residual.layers()):
        values = (values.relu() if place else values) @ weight + bias
    torch.testing.assert_close(values, residual(state, actions[:, 0]))


def test_an_ensemble_is_the_mean_of_its_members() -> None:
    ensemble = Ensemble(CRAZYFLIE.layouts)
    state, actions = batch(CRAZYFLIE, 6)
    members = ensemble.members(state, actions[:, 0])
    assert members.shape == (4, 6, 13)
    assert sum(parameter.numel() for parameter in ensemble.parameters()) == 4 * (18 * 200 + 3 * 201 * 200 + 201 * 13)
    assert float(members.detach().std(dim=0).min()) > 0
    found = ensemble(state, actions[:, 0])
    torch.testing.assert_close(found, CRAZYFLIE.layouts.state.normalise(state + members.mean(0)))
    torch.testing.assert_close(found[2], ensemble(state[2], actions[2, 0]))
    assert ensemble(state[:, None], actions).shape == (6, 5, 13)


def test_a_state_without_quaternion_or_circle_needs_no_manifold(tmp_path: Path) -> None:
    layouts = Layouts(Layout.of(["x", "vx"]), Layout.of(["u"]))
    base = Equations.parse(layouts, {"x": "x + 0.1*vx", "vx": "vx + 0.1*u"}, dt=0.1)
    residual = ResidualMLP(layouts, (4,))
    with torch.no_grad():
        residual.linears[-1].bias.copy_(torch.tensor([0.0, -0.25]))
    state, action = torch.tensor([1.0, 2.0]), torch.tensor([[3.0], [1.0]])
    expected = torch.tensor([[1.2, 2.05], [1.405, 1.9]])
    torch.testing.assert_close(rollout(Composed(base, residual), state, action), expected)
    ensemble = Ensemble(layouts, 2, (4,), seed=1)
    model = Composed(ensemble, residual)
    torch.testing.assert_close(model(state, action), ensemble(state, action) + residual(state, action))
    torch.testing.assert_close(model.plain()(state, action), model(state, action))
    assert isinstance(open_model(save_model(model, tmp_path / "pushed")), Composed)


def test_no_past_is_the_present_row_repeated() -> None:
    residual = lively(MUSHR, (20, 12), commands=3, states=2)
    state, actions = batch(MUSHR, 6)
    action = actions[:, 0]
    repeated = torch.cat([*(3 * [action]), *(2 * [state])], dim=-1)
    torch.testing.assert_close(residual(state, action), residual(state, action, repeated), rtol=0, atol=0)
    wide = residual(state[0], action, repeated[0])
    assert wide.shape == (6, MUSHR.layouts.state.size)
    other = repeated.clone()
    other[:, 2 * MUSHR.layouts.action.size] += 1.0  # the oldest command counts
    assert float((residual(state, action, other) - residual(state, action)).detach().abs().min(0).values.max()) > 1e-5
    scripted = torch.jit.script(residual)
    for past in (None, repeated):
        torch.testing.assert_close(scripted(state, action, past), residual(state, action, past))


@pytest.mark.parametrize("past", [(0, 0), (10, 2)])
def test_a_residual_survives_its_file(tmp_path: Path, past: tuple[int, int]) -> None:
    residual = lively(MUSHR, (20, 12), *past)
    (tmp_path / "residual.safetensors").write_bytes(network_file(residual))
    again = load_residual(tmp_path)
    assert (again.commands, again.states) == past
    state, actions = batch(MUSHR, 6)
    torch.testing.assert_close(again(state, actions[:, 0]), residual(state, actions[:, 0]), rtol=0, atol=0)
    (tmp_path / "residual.safetensors").write_bytes(b"nothing")
    with pytest.raises(DataError, match="weights of a residual"):
        load_residual(tmp_path)


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(ShapeError, match="other columns"):
        Composed(CRAZYFLIE.nominal(), ResidualMLP(MUSHR.layouts))
    with pytest.raises(ShapeError, match="other columns"):
        equations = motor_lagged()
        Composed(equations, ResidualMLP(equations.layouts))  # a residual sees what a log holds
    with pytest.raises(ShapeError, match="at least one hidden layer"):
        ResidualMLP(MUSHR.layouts, ())
    with pytest.raises(ShapeError, match="no negative number"):
        ResidualMLP(MUSHR.layouts, commands=-1)
    for options in ({"members": 0}, {"widths": (8, 0)}):
        with pytest.raises(ShapeError, match="at least one unit"):
            Ensemble(MUSHR.layouts, **options)


def test_hidden_states_go_on_beneath_a_residual() -> None:
    """Thrust lags as without the residual: the plain model, given each state anew but for its thrust, plus r."""
    equations, residual = motor_lagged(), lively(CRAZYFLIE, (32, 16))
    state, actions = batch(CRAZYFLIE, 4)
    found = rollout(Composed(equations, residual), state, actions)
    base, layout = compile_model(equations), CRAZYFLIE.layouts.state
    whole = with_hidden_start(equations, state, actions[:, 0])
    assert whole.shape[-1] > layout.size
    for step in range(actions.shape[1]):
        seen, following = whole[:, : layout.size], base(whole, actions[:, step])
        visible = following[:, : layout.size] + residual(seen, actions[:, step])
        whole = torch.cat([layout.normalise(visible), following[:, layout.size :]], dim=-1)
        torch.testing.assert_close(found[:, step], whole[:, : layout.size])
    torch.testing.assert_close(found[:, 0], Composed(equations, residual)(state, actions[:, 0]))


def two_controllers(model: Composed, robot: Robot) -> tuple[MPPI, MPPI]:
    small, task = replace(robot, mppi=replace(robot.mppi, samples=70)), make_task("circle", robot)
    filters = [FilterState(model.equations) if model.equations.filters else None for _ in range(2)]
    fused, slow = (
        MPPI(model, small, task, backend=backend, filters=own)
        for backend, own in zip(("c", "torch"), filters, strict=True)
    )
    return fused, slow


def agree(fused: MPPI, slow: MPPI, robot: Robot, call: int) -> torch.Tensor:
    """One action of both from the same noise; the costs."""
    state = robot.start + 0.01 * call
    before = fused.mean.clone()
    fused.act(state, 0)
    slow.mean = before
    plan = slow.improve(state, 0, fused._fused.noise(0, call))
    torch.testing.assert_close(fused.plan.costs, plan.costs, rtol=2e-5, atol=1e-5)
    torch.testing.assert_close(fused.plan.states, plan.states)
    scale = torch.tensor(robot.high - robot.low).float()
    assert float(((fused.mean - slow.mean).abs() / scale).max()) < 5e-5
    return plan.costs


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize(
    ("make", "robot", "widths"),
    [
        (flying, CRAZYFLIE, (64, 64)),
        (flying, CRAZYFLIE, (200, 200, 200, 200)),
        (MUSHR.nominal, MUSHR, (10,)),
        (MUSHR.nominal, MUSHR, (33, 7, 5)),
        (motor_lagged, CRAZYFLIE, (20, 12)),
    ],
)
def test_the_kernel_plans_with_a_residual_as_torch_does(
    make: Callable[[], Equations], robot: Robot, widths: tuple[int, ...]
) -> None:
    equations = make()
    fused, slow = two_controllers(Composed(equations, lively(robot, widths)), robot)
    costs = agree(fused, slow, robot, 1)
    without = MPPI(VisibleModel(equations), fused.robot, fused.task, backend="torch")
    calm = without.improve(robot.start + 0.01, 0, fused._fused.noise(0, 1))
    assert float((calm.costs - costs).abs().max()) > 0.01


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize(
    ("make", "robot", "widths", "commands", "states"),
    [
        (flying, CRAZYFLIE, (64, 64), 10, 0),
        (MUSHR.nominal, MUSHR, (64, 64), 10, 2),
        (MUSHR.nominal, MUSHR, (33, 7, 5), 0, 3),
        (motor_lagged, CRAZYFLIE, (20, 12), 3, 1),
        (late, MUSHR, (20, 12), 5, 1),
    ],
    ids=["commands", "both", "states", "hidden states", "filters"],
)
def test_the_kernel_plans_with_memory_as_torch_does(
    make: Callable[[], Equations], robot: Robot, widths: tuple[int, ...], commands: int, states: int
) -> None:
    """Before anything was sent, while the past fills, and beyond; a reset forgets."""
    model = Composed(make(), lively(robot, widths, commands, states))
    fused, slow = two_controllers(model, robot)
    first = agree(fused, slow, robot, 1)
    for call in range(2, 5):
        for one in (fused, slow):
            one.remember(robot.rest + 0.3 * (robot.high - robot.rest) * np.sin(call))
        changed = agree(fused, slow, robot, call)
    slow.reset()  # forgets what was sent: the same plans cost something else
    forgetful = slow.improve(robot.start + 0.04, 0, fused._fused.noise(0, 4)).costs
    assert float((forgetful - changed).abs().max()) > 1e-2
    fused.reset()
    torch.testing.assert_close(agree(fused, slow, robot, 1), first)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_retraining_compiles_nothing() -> None:
    task = make_task("circle", MUSHR)
    libraries = []
    for seed, commands in ((1, 4), (2, 4), (2, 5)):
        residual = lively(MUSHR, (64, 64), commands)
        residual._begin(seed)
        mppi = MPPI(Composed(MUSHR.nominal(), residual), MUSHR, task, backend="c")
        libraries.append(mppi._fused._library._name)
    assert libraries[0] == libraries[1]
    assert libraries[1] != libraries[2]  # how many past commands there are is in the text


def test_a_residual_with_memory_exports() -> None:
    residual = lively(MUSHR, (20, 12), commands=3, states=2)
    state, actions = batch(MUSHR, 6)
    operands = (state, actions[:, 0], past_of(MUSHR, 6, 3, 2))
    rows = {0: torch.export.Dim("rows", min=2)}
    program = torch.export.export(residual, operands, dynamic_shapes=(rows, rows, rows))
    fewer = tuple(operand[:3] for operand in operands)
    torch.testing.assert_close(program.module()(*fewer), residual(*fewer))
