"""Training on a frozen base: its loss is that of rollouts, its gradients are right, and what it finds is MuJoCo's."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
import torch

from sym2real.control import geometric_controller
from sym2real.effects import effect
from sym2real.errors import ModelError, ShapeError
from sym2real.experiments.standard_conditions import sensors
from sym2real.layout import Layout
from sym2real.neural import Composed, Descent, ResidualMLP, ResidualTraining
from sym2real.neural.batch import Batch
from sym2real.neural.blocks import Blocks
from sym2real.neural.leftover import Leftover, leftover
from sym2real.neural.multi_step import Scales, corrected_errors, rolled_errors
from sym2real.neural.normal import Normal
from sym2real.neural.paired import SURE, sureness
from sym2real.neural.switches import columns_that_help
from sym2real.plants import EquationsPlant, MujocoPlant, run_episode
from sym2real.protocols import Plant
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations, compile_model, rollout
from sym2real.tasks import make_task
from sym2real.trajectory import Dataset, Transitions

QUICK = Descent(steps=150)
WIND = 0.02  # N along x


def flown(plant: Plant, robot: Robot, rows: int = 200, tasks: tuple[str, ...] = ("circle",)) -> Transitions:
    episodes = []
    for seed, name in enumerate(tasks):
        task = make_task(name, robot)
        episodes.append(
            run_episode(plant, geometric_controller(robot, task.reference), task, seed=seed, steps=rows + 1)
        )
    return Dataset(episodes).transitions()


@pytest.fixture(scope="module")
def windy() -> Transitions:
    return flown(MujocoPlant(CRAZYFLIE, (effect("wind", CRAZYFLIE).inject(fx=WIND),)), CRAZYFLIE)


@pytest.fixture(scope="module")
def base() -> Equations:
    return CRAZYFLIE.nominal()


def multi_step(model: Composed, transitions: Transitions, steps: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Predicted and measured states after ``steps`` rows, from every row ``# (windows, n)``."""
    state, action = (torch.tensor(values).double() for values in (transitions.state, transitions.action))
    starts = torch.arange(len(state) - steps + 1)
    actions = torch.stack([action[starts + step] for step in range(steps)], dim=1)
    predicted = rollout(model, state[starts], actions)[:, -1]
    return predicted.detach(), torch.tensor(transitions.next_state)[starts + steps - 1]


def position_error(model: Composed, transitions: Transitions, steps: int = 20) -> float:
    predicted, measured = multi_step(model, transitions, steps)
    return float((predicted - measured)[:, :3].norm(dim=-1).mean())


def doubled(model: Composed) -> Composed:
    return Composed(model.equations, model.residual, torch.float64)


def whole_batch(rows: Leftover, blocks: Blocks) -> Batch:
    """All rows of a quadrotor's log."""
    scales = Scales.of(rows, blocks.starts, blocks.steps)
    normal = Normal.of(rows.seen, [CRAZYFLIE.layouts.state, CRAZYFLIE.layouts.action], scales.residual)
    return Batch.of(rows, blocks, range(len(blocks.runs)), normal, scales)


def test_errors_of_rollouts_are_those_of_the_composed_model(windy: Transitions, base: Equations) -> None:
    """The recursion is first order in errors: halving the residual and the rest by ten leaves a hundredth apart."""
    rows, steps = leftover(windy, base), 8
    residual = ResidualMLP(CRAZYFLIE.layouts, (16,), seed=3)
    with torch.no_grad():
        residual.linears[-1].weight.normal_(0.0, 0.3, generator=torch.Generator().manual_seed(2))
        residual.output_scale.fill_(1e-4)
    model = Composed(base, residual, torch.float64)
    state, action = rows.seen.double().split([13, 4], dim=-1)
    one = rows.error + (rows.moved.double() @ residual(state, action)[..., None])[..., 0]
    starts = torch.arange(len(rows) - steps + 1)
    found = rolled_errors(one[..., None].detach(), rows.carried.double(), starts, steps)[-1, :, :, 0]
    predicted, measured = multi_step(model, windy, steps)
    expected = CRAZYFLIE.layouts.state.difference(predicted, measured)
    assert float((found - expected).norm() / expected.norm()) < 0.02
    assert float((rows.error - found[:1]).norm() / found.norm()) > 0.5  # several steps are not one


def test_gradients_of_the_loss_are_its_differences(windy: Transitions, base: Equations) -> None:
    rows = leftover(windy, base)
    blocks = Blocks.of(rows.runs, 4, 0)
    batch = whole_batch(rows, blocks)
    exact = {f.name: getattr(batch, f.name) for f in fields(batch)}
    batch = Batch(**{name: v.double() if v.is_floating_point() else v for name, v in exact.items()})
    outputs = torch.randn(2, len(batch.seen), 13, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    assert torch.autograd.gradcheck(batch.errors, outputs.requires_grad_(), fast_mode=True)
    assert float(batch.errors(torch.zeros_like(outputs[:1])).mean()) == pytest.approx(1.0, rel=1e-5)  # the base's is 1


def test_noise_of_a_start_is_nothing_that_a_correction_can_take_away() -> None:
    """What stands still is seen with noise: errors of rollouts hold that of their start, the row before does not."""
    noise = torch.randn(5001, 1, 1, generator=torch.Generator().manual_seed(1))
    error, carried = noise[:-1] - noise[1:], torch.ones(5000, 1, 1)
    starts = torch.arange(1, 5000 - 10)
    rolled = rolled_errors(error, carried, starts, 10)

    def along(added: torch.Tensor) -> float:
        """Of the errors with what a correction by the measured state adds to them, per size of both."""
        return float((rolled * added).mean() / rolled.square().mean())

    seen = noise[:-1]
    assert along(rolled_errors(seen, carried, starts, 10)) > 0.4
    assert abs(along(corrected_errors(0 * error, seen, carried, starts, 10))) < 0.05
    shifted = corrected_errors(error, 0 * seen + 2.0, carried, starts, 10) - rolled
    torch.testing.assert_close(shifted[:, 0, 0, 0], 2.0 * torch.arange(1.0, 11.0), atol=1e-4, rtol=0)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_noisy_log_of_one_task_helps_on_another(base: Equations, seed: int) -> None:
    wind = effect("wind", CRAZYFLIE).inject(fx=0.02, fy=0.01)
    noise = sensors(CRAZYFLIE, np.random.default_rng(seed))
    model = ResidualTraining(seed=seed).fit(flown(MujocoPlant(CRAZYFLIE, (noise, wind)), CRAZYFLIE, rows=400), base)
    elsewhere = flown(MujocoPlant(CRAZYFLIE, (wind,)), CRAZYFLIE, tasks=("lemniscate",))
    alone = Composed(base, ResidualMLP(CRAZYFLIE.layouts), torch.float64)
    assert position_error(doubled(model), elsewhere, 40) < position_error(alone, elsewhere, 40)


@pytest.mark.parametrize("steps", [1, 10])
def test_what_mujoco_pushes_with_is_found(windy: Transitions, base: Equations, steps: int) -> None:
    model, report = ResidualTraining(steps=steps, descent=QUICK).fit_reported(windy, base)
    state, action = torch.tensor(windy.state).float(), torch.tensor(windy.action).float()
    with torch.no_grad():
        found = model.residual(state, action).mean(0)
    push = WIND / CRAZYFLIE.numbers["mass"] * CRAZYFLIE.dt
    assert float(found[7]) == pytest.approx(push, rel=0.1)  # m/s a step, along x
    assert abs(float(found[8])) < 0.1 * push
    assert "vx" in report.columns
    assert report.error < 0.2
    elsewhere = flown(
        MujocoPlant(CRAZYFLIE, (effect("wind", CRAZYFLIE).inject(fx=WIND),)), CRAZYFLIE, tasks=("lemniscate",)
    )
    alone = Composed(base, ResidualMLP(CRAZYFLIE.layouts), torch.float64)
    assert position_error(doubled(model), elsewhere) < 0.5 * position_error(alone, elsewhere)


def test_a_frozen_base_stays_and_the_same_seed_gives_the_same_bits(windy: Transitions, base: Equations) -> None:
    before, state, action = base.to_json(), torch.tensor(windy.state), torch.tensor(windy.action)
    predicted = compile_model(base, dtype=torch.float64)(state, action)
    threads, found = torch.get_num_threads(), []
    for number in (1, 3):
        torch.set_num_threads(number)
        found.append(ResidualTraining(widths=(16,), descent=Descent(steps=30)).fit(windy, base).residual)
    torch.set_num_threads(threads)
    assert base.to_json() == before
    torch.testing.assert_close(compile_model(base, dtype=torch.float64)(state, action), predicted, rtol=0, atol=0)
    for name, tensor in found[0].state_dict().items():
        assert torch.equal(tensor, found[1].state_dict()[name]), name
    other = ResidualTraining(widths=(16,), seed=1, descent=Descent(steps=30)).fit(windy, base).residual
    assert not torch.equal(other.linears[0].weight, found[0].linears[0].weight)


def test_a_heavy_penalty_leaves_the_base(windy: Transitions, base: Equations) -> None:
    sizes = []
    for penalty in (1e-3, 1.0, 1e6):
        residual = ResidualTraining(penalties=(penalty,), descent=QUICK).fit(windy, base).residual
        with torch.no_grad():
            sizes.append(float(residual(torch.tensor(windy.state).float(), torch.tensor(windy.action).float()).norm()))
    assert sizes[0] > sizes[1] > 20 * sizes[2]


@pytest.mark.parametrize(("seed", "logs"), [(0, 1), (1, 1), (2, 1), (0, 3)])
def test_a_base_that_is_right_is_not_made_worse(base: Equations, seed: int, logs: int) -> None:
    """Logs are the base's own, seen by noisy sensors: rollouts elsewhere stay as they were, within a tenth."""
    measure = sensors(CRAZYFLIE, np.random.default_rng(seed)).measure
    assert measure is not None
    plant = EquationsPlant(base, CRAZYFLIE)
    known, elsewhere = (flown(plant, CRAZYFLIE, 300, tasks) for tasks in (("circle",) * logs, ("lemniscate",)))
    state, following = known.state.copy(), known.next_state.copy()
    for number in range(logs):
        rows, noisy = np.flatnonzero(known.trajectory == number), measure()
        seen = np.array([noisy(values) for values in (*known.state[rows], known.next_state[rows[-1]])])
        state[rows], following[rows] = seen[:-1], seen[1:]
    model = ResidualTraining(seed=seed, descent=QUICK).fit(replace(known, state=state, next_state=following), base)
    predicted, true = multi_step(doubled(model), elsewhere, 40)
    travelled = float((true[:, :3] - torch.tensor(elsewhere.state)[: len(true), :3]).norm(dim=-1).mean())
    assert float((predicted - true)[:, :3].norm(dim=-1).mean()) < 0.1 * travelled


def test_whole_trajectories_are_left_out_where_there_are_several() -> None:
    runs = [(0, 90), (90, 98), (105, 205), (205, 300)]  # the second holds no window
    several = Blocks.by_trajectory(runs, 10, 0)
    assert several.folds == 3
    for fold, run in enumerate((runs[0], runs[2], runs[3])):
        mine = [block for block, number in zip(several.runs, several.fold, strict=True) if number == fold]
        assert (mine[0][0], mine[-1][1]) == run
        assert all(end == first for (_, end), (first, _) in pairwise(mine))
    assert Blocks.by_trajectory([(k, k + 40) for k in range(0, 480, 40)], 10, 0).folds == 5
    most_in_one = Blocks.by_trajectory([(0, 200), (200, 250), (250, 300)], 10, 3)
    assert most_in_one.folds == 1
    assert most_in_one.fold == Blocks.of([(0, 200), (200, 250), (250, 300)], 10, 3).fold


def test_a_row_does_not_teach_the_network_that_it_validates(windy: Transitions, base: Equations) -> None:
    """Gradients of a network come from the other folds' windows alone; the last network's from all."""
    rows = leftover(windy, base)
    blocks = Blocks.by_trajectory([(0, 60), (60, 130), (130, 200)], 4, 0)
    batch = whole_batch(rows, blocks)
    outputs = torch.ones(blocks.folds + 1, len(batch.seen), 13, requires_grad=True)
    batch.penalised(lambda _: outputs, torch.zeros(len(outputs)), torch.arange(len(outputs))).sum().backward()
    assert outputs.grad is not None
    taught = outputs.grad.abs().amax(-1) > 0
    for number in range(blocks.folds):
        assert not bool(taught[number, batch.fold == number].any())
        assert float(taught[number, batch.fold != number].float().mean()) > 0.9
    assert float(taught[-1].float().mean()) > 0.9


def test_columns_that_help_only_together_stay() -> None:
    """Of eight columns that help a little hardly one is sure to, all together are; a ninth only harms."""
    layout, drawn = Layout.of([f"x{k}" for k in range(9)]), torch.Generator().manual_seed(0)
    blocks, size = 15, 21
    rows = blocks * size
    error, noise = (torch.randn(rows, 9, generator=drawn) for _ in range(2))
    outputs = 0.33 * noise
    outputs[:-1, :8] -= 0.09 * error[1:, :8]  # what corrects a window of one row is said by the row before
    starts = torch.arange(rows).reshape(blocks, size)[:, 1:].flatten()
    batch = Batch(
        seen=torch.zeros(rows, 1), error=error[..., None], moved=torch.eye(9).expand(rows, 9, 9),
        carried=torch.eye(9).expand(rows, 9, 9), fold=torch.zeros(rows, dtype=torch.long), starts=starts,
        block=torch.arange(blocks).repeat_interleave(size - 1), scale=torch.ones(1, 1, 9, 1),
    )  # fmt: skip
    before, after = error[starts], error[starts] + outputs[starts - 1]
    gain = (before.square() - after.square()).reshape(blocks, size - 1, 9).mean(1)
    alone = sum(sureness(gain[:, column]) > SURE for column in range(8))
    assert sureness(gain[:, :8].sum(1)) > SURE
    on = columns_that_help(batch, outputs, layout)
    assert int(on.sum()) > alone
    assert not on[8]
    assert not columns_that_help(batch, noise, layout).any()


def test_far_from_its_data_a_residual_stays_bounded(windy: Transitions, base: Equations) -> None:
    residual = ResidualTraining(descent=QUICK).fit(windy, base).residual
    state, action = torch.tensor(windy.state).float(), torch.tensor(windy.action).float()
    with torch.no_grad():
        near, far = residual(state, action), residual(1e4 * state, -1e4 * action)
    range_of = near.amax(0) - near.amin(0)
    assert bool((far <= near.amax(0) + 0.51 * range_of + 1e-7).all())
    assert bool((far >= near.amin(0) - 0.51 * range_of - 1e-7).all())


def test_what_cannot_be_trained_is_refused(windy: Transitions, base: Equations) -> None:
    with pytest.raises(ModelError, match="penalties above 0"):
        ResidualTraining(penalties=(0.0,))
    with pytest.raises(ModelError, match="at least 40 consecutive transitions, found 15"):
        ResidualTraining().fit(windy.where(np.arange(len(windy)) < 15), base)
    with pytest.raises(ShapeError, match="state columns are"):
        ResidualTraining().fit(windy, MUSHR.nominal())
