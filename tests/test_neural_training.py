"""Training on a frozen base: its loss is that of rollouts, its gradients are right, and what it finds is MuJoCo's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import torch
from tracked import tracked

from sym2real.adaptation.fine_tuning import FineTuning
from sym2real.control import RandomCommands
from sym2real.dataset import Dataset, Transitions
from sym2real.diagnosis import add
from sym2real.effects import effect
from sym2real.errors import ModelError, ShapeError
from sym2real.experiments.standard_conditions import sensors
from sym2real.layout import Layout
from sym2real.neural import Composed, Descent, ResidualMLP, ResidualTraining
from sym2real.neural.batch import Batch
from sym2real.neural.blocks import EVERY, blocks_of, windows_of
from sym2real.neural.leftover import leftover
from sym2real.neural.multi_step import Scales, rolled_errors
from sym2real.neural.networks import Networks
from sym2real.neural.normal import Normal
from sym2real.neural.stacking import shares
from sym2real.plants import EquationsPlant, MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import Equations, compile_model, rollout

QUICK = Descent(steps=150)
WIND = 0.02  # N along x


def in_wind() -> MujocoPlant:
    return MujocoPlant(CRAZYFLIE, (effect("wind", CRAZYFLIE).inject(fx=WIND),))


@pytest.fixture(scope="module")
def windy() -> Transitions:
    return tracked(in_wind())


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


def test_errors_of_rollouts_are_those_of_the_composed_model(windy: Transitions, base: Equations) -> None:
    """The recursion is first order in errors: halving the residual and the rest by ten leaves a hundredth apart."""
    rows, steps = leftover(windy, base), 8
    residual = ResidualMLP(CRAZYFLIE.layouts, (16,), seed=3)
    with torch.no_grad():
        residual.linears[-1].weight.normal_(0.0, 0.3, generator=torch.Generator().manual_seed(2))
        residual.output_scale.fill_(1e-4)
    model = Composed(base, residual, torch.float64)
    state, action = rows.seen.double().split([13, 4], dim=-1)
    one = rows.error + (rows.moved.double() @ model.residual(state, action)[..., None])[..., 0]
    starts = torch.arange(len(rows) - steps + 1)
    found = rolled_errors(one[..., None].detach(), rows.carried.double(), starts, steps)[-1, :, :, 0]
    predicted, measured = multi_step(model, windy, steps)
    expected = CRAZYFLIE.layouts.state.difference(predicted, measured)
    assert float((found - expected).norm() / expected.norm()) < 0.02
    assert float((rows.error - found[:1]).norm() / found.norm()) > 0.5  # several steps are not one


def test_rollouts_see_what_they_predict(windy: Transitions, base: Equations) -> None:
    """Networks see the predicted state: their errors are the composed model's, to first order of the base."""
    rows, layouts = leftover(windy, base), CRAZYFLIE.layouts
    starts, fold = windows_of(*blocks_of(rows.runs, 8, 0), 8)
    scales = Scales.of(rows, starts, 8)
    normal = Normal.of(rows.seen, [layouts.state, layouts.action], scales.residual)
    batch = Batch.of(rows, starts, fold, normal, scales)
    residual = ResidualMLP(layouts, (16,), seed=3)
    with torch.no_grad():
        residual.linears[-1].weight.normal_(0.0, 0.3, generator=torch.Generator().manual_seed(2))
        residual.output_scale.fill_(1e-3)
    networks = Networks((len(normal.mean), 16, 13), 2)
    normal.begin_with(networks, residual.layers(), torch.tensor([1]))
    windows = torch.arange(len(starts))
    with torch.no_grad():
        found, outputs = batch.rolled(networks, windows)
    predicted, measured = multi_step(Composed(base, residual, torch.float64), windy, 8)
    expected = layouts.state.difference(predicted, measured)[starts]
    error = (found * scales.error)[-1, ..., 1]
    assert float((error - expected).norm() / expected.norm()) < 0.05
    alone, parts = batch.parts(outputs[..., 1], windows)
    torch.testing.assert_close((alone + parts.sum(-1, keepdim=True))[..., 0], found[..., 1], atol=1e-3, rtol=1e-3)
    assert float(alone.square().mean()) == pytest.approx(1.0, rel=1e-4)  # the base's is 1


def test_windows_of_a_fold_share_no_row_with_those_of_another() -> None:
    runs, steps = ((0, 103), (103, 230)), 10
    blocks, folds = blocks_of(runs, steps, seed=3)
    assert [row for block in blocks for row in range(*block)] == list(range(230))
    assert min(end - first for first, end in blocks) >= 2 * steps
    assert set(folds) == set(range(EVERY))
    of_row = {row: fold for block, fold in zip(blocks, folds, strict=True) for row in range(*block)}
    starts, fold = windows_of(blocks, folds, steps)
    for start, mine in zip(starts.tolist(), fold.tolist(), strict=True):
        assert {of_row[row] for row in range(start - 1, start + steps)} == {mine}
    assert blocks_of(((0, 40),), steps, seed=3)[1] == [1, 0]  # two blocks are two folds


def test_some_of_the_networks_are_what_they_were() -> None:
    networks, which = Networks((3, 8, 2), 4, seed=1), torch.tensor([3, 1])
    seen = torch.randn(5, 3, generator=torch.Generator().manual_seed(0))
    torch.testing.assert_close(networks.only(which)(seen), networks(seen)[which])


@pytest.mark.parametrize("answered", [False, True])
def test_noise_of_a_start_is_nothing_that_a_network_can_take_away(answered: bool) -> None:
    """What stands still is seen with noise, which a command may answer: gradients of errors know nothing of it."""
    noise = torch.randn(5001, 1, generator=torch.Generator().manual_seed(1))
    seen = torch.cat([0.0 * noise[:-1], noise[:-1]] if answered else [noise[:-1], 0.0 * noise[:-1]], dim=-1)
    felt = torch.tensor([[1.0], [0.0]]).expand(5000, 2, 1)
    one, starts = torch.ones(5000, 1, 1), torch.arange(1, 5000 - 10)
    batch = Batch(
        seen, felt, (noise[:-1] - noise[1:])[..., None], one, one, starts, 0 * starts, torch.ones(10, 1, 1, 1)
    )
    networks = Networks((2, 1), 1)
    for parameter in networks.parameters():
        parameter.data.zero_()
    errors, _ = batch.rolled(networks, torch.arange(len(starts)))
    errors[1].square().mean().backward()  # of the first row that teaches
    for parameter in networks.parameters():
        assert float(parameter.grad.abs().max()) < 0.1
    slope = (2 * errors[0, :, 0].detach() * seen[starts]).mean(0)  # of who would see the row itself
    assert float(slope.abs().max()) > 1.5


def test_columns_that_only_help_together_are_taken_together() -> None:
    layout = Layout.of(["x", "y", "vx"])
    rng = torch.Generator().manual_seed(0)
    common, error = torch.randn(2, 500, generator=rng)
    parts = torch.stack([common - error, -common, torch.randn(500, generator=rng)], dim=-1)
    torch.testing.assert_close(shares(error[:, None], parts, layout), torch.tensor([1.0, 1.0, 0.0]), atol=0.05, rtol=0)
    assert not shares(error[:, None], 0 * parts, layout).any()


@pytest.mark.slow
def test_a_noisy_log_of_one_task_helps_on_another(base: Equations) -> None:
    wind = effect("wind", CRAZYFLIE).inject(fx=0.02, fy=0.01)
    noise = sensors(CRAZYFLIE, np.random.default_rng(0))
    model = ResidualTraining().fit(tracked(MujocoPlant(CRAZYFLIE, (noise, wind)), rows=400), base)
    elsewhere = tracked(MujocoPlant(CRAZYFLIE, (wind,)), "lemniscate")
    alone = Composed(base, ResidualMLP(CRAZYFLIE.layouts), torch.float64)
    assert position_error(doubled(model), elsewhere, 40) < 0.4 * position_error(alone, elsewhere, 40)


@pytest.mark.slow
@pytest.mark.parametrize("steps", [1, 10])
def test_what_mujoco_pushes_with_is_found(windy: Transitions, base: Equations, steps: int) -> None:
    model, report = ResidualTraining(steps=steps).fit_reported(windy, base)
    state, action = torch.tensor(windy.state).float(), torch.tensor(windy.action).float()
    with torch.no_grad():
        found = model.residual(state, action).mean(0)
    push = WIND / CRAZYFLIE.numbers["mass"] * CRAZYFLIE.dt
    assert float(found[7]) == pytest.approx(push, rel=0.1)  # m/s a step, along x
    assert abs(float(found[8])) < 0.1 * push
    assert "vx" in report.columns
    assert report.error < 0.5  # over all blocks: of the first no other one tells anything
    elsewhere = tracked(in_wind(), "lemniscate")
    alone = Composed(base, ResidualMLP(CRAZYFLIE.layouts), torch.float64)
    assert position_error(doubled(model), elsewhere) < 0.5 * position_error(alone, elsewhere)


@pytest.mark.slow
def test_what_a_loop_brakes_is_learned_from_one_flight(base: Equations) -> None:
    """A centre of mass off the middle turns the robot against its rate loop: errors of rates soon grow no further."""
    plant = MujocoPlant(CRAZYFLIE, (effect("com_offset", CRAZYFLIE).inject(rx=0.003),))
    rows, layout = tracked(plant, rows=400), CRAZYFLIE.layouts.state
    model = ResidualTraining().fit(rows, base)
    state, action, after = (torch.tensor(values) for values in (rows.state, rows.action, rows.next_state))
    before = compile_model(base, dtype=torch.float64)(state, action)
    with torch.no_grad():
        predicted = doubled(model)(state, action)
    lacking, found = (layout.difference(values, before).mean(0) for values in (after, predicted))
    assert float(found[10] / lacking[10]) == pytest.approx(1.0, abs=0.1)  # the rate about y does not stand for
    assert float(found[4] / lacking[4]) == pytest.approx(1.0, abs=0.5)  # the turn of the step itself
    elsewhere = tracked(plant, "lemniscate")
    alone = Composed(base, ResidualMLP(CRAZYFLIE.layouts), torch.float64)
    assert position_error(doubled(model), elsewhere, 40) < 0.25 * position_error(alone, elsewhere, 40)


@pytest.mark.slow
@pytest.mark.parametrize(("learner", "least"), [(ResidualTraining(widths=(32,)), 0.8), (FineTuning(), 0.99)])
def test_what_goes_by_commands_that_jump_is_learned(learner: ResidualTraining | FineTuning, least: float) -> None:
    """The speed command is too strong: what a row lacks goes by its own command and not by the one before."""
    base = MUSHR.nominal()
    weaker = add(base, "gain:speed", {"value": 0.8})
    plant, random = EquationsPlant(weaker, MUSHR), RandomCommands(MUSHR, hold=MUSHR.dt)
    rows = Dataset([run_episode(plant, random, steps=401)]).transitions()
    model = learner.fit(rows, base)
    step = compile_model(model) if isinstance(model, Equations) else model
    state, action = torch.tensor(rows.state).float(), torch.tensor(rows.action).float()
    with torch.no_grad():
        before = compile_model(base)(state, action)[:, 4:6]
        lacking, added = torch.tensor(rows.next_state).float()[:, 4:6] - before, step(state, action)[:, 4:6] - before
        share = (added * lacking).sum() / lacking.square().sum()
    assert least < float(share) < 1.05


def test_a_frozen_base_stays_and_the_same_seed_gives_the_same_bits(
    windy: Transitions, base: Equations, set_threads: Callable[[int], None]
) -> None:
    before, state, action = base.to_json(), torch.tensor(windy.state), torch.tensor(windy.action)
    predicted = compile_model(base, dtype=torch.float64)(state, action)
    found = []
    for number in (1, 3):
        set_threads(number)
        found.append(ResidualTraining(widths=(16,), descent=Descent(steps=30)).fit(windy, base).residual)
    assert base.to_json() == before
    torch.testing.assert_close(compile_model(base, dtype=torch.float64)(state, action), predicted, rtol=0, atol=0)
    for name, tensor in found[0].state_dict().items():
        assert torch.equal(tensor, found[1].state_dict()[name]), name
    other = ResidualTraining(widths=(16,), seed=1, descent=Descent(steps=30)).fit(windy, base).residual
    assert not torch.equal(other.linears[0].weight, found[0].linears[0].weight)


@pytest.mark.slow
def test_a_heavy_penalty_leaves_the_base(windy: Transitions, base: Equations) -> None:
    sizes = []
    for penalty in (1e-3, 1.0, 1e6):
        residual = ResidualTraining(penalties=(penalty,), descent=QUICK).fit(windy, base).residual
        with torch.no_grad():
            sizes.append(float(residual(torch.tensor(windy.state).float(), torch.tensor(windy.action).float()).norm()))
    assert sizes[0] > sizes[1] > 20 * sizes[2]


def test_a_base_that_is_right_is_not_made_worse(base: Equations) -> None:
    """The log is the base's own, seen by noisy sensors: rollouts elsewhere stay as they were, within a twentieth."""
    measure = sensors(CRAZYFLIE, np.random.default_rng(0)).measure
    clean = [tracked(EquationsPlant(base, CRAZYFLIE), task, rows=300) for task in ("circle", "lemniscate")]
    noisy = measure()
    states = np.array([noisy(state) for state in (*clean[0].state, clean[0].next_state[-1])])
    model = ResidualTraining(descent=QUICK).fit(replace(clean[0], state=states[:-1], next_state=states[1:]), base)
    predicted, true = multi_step(doubled(model), clean[1], 40)
    travelled = float((true[:, :3] - torch.tensor(clean[1].state)[: len(true), :3]).norm(dim=-1).mean())
    assert float((predicted - true)[:, :3].norm(dim=-1).mean()) < 0.05 * travelled


@pytest.fixture(scope="module")
def trained(windy: Transitions, base: Equations) -> Composed:
    return ResidualTraining(descent=QUICK).fit(windy, base)


@pytest.mark.slow
def test_training_goes_on_from_an_earlier_result(windy: Transitions, base: Equations, trained: Composed) -> None:
    short = ResidualTraining(descent=Descent(steps=20, learning_rate=1e-3))
    again = short.fit(windy, base, trained)
    assert position_error(doubled(again), windy) < 0.7 * position_error(doubled(short.fit(windy, base)), windy)
    with pytest.raises(ShapeError, match=r"widths \(8, 26\).*found \(64, 64, 26\)"):
        ResidualTraining(widths=(8,)).fit(windy, base, again)


def test_far_from_its_data_a_residual_stays_bounded(windy: Transitions, trained: Composed) -> None:
    residual = trained.residual
    state, action = torch.tensor(windy.state).float(), torch.tensor(windy.action).float()
    with torch.no_grad():
        near, far = residual(state, action), residual(1e4 * state, -1e4 * action)
    range_of = near.amax(0) - near.amin(0)
    assert bool((far <= near.amax(0) + 0.51 * range_of + 1e-7).all())
    assert bool((far >= near.amin(0) - 0.51 * range_of - 1e-7).all())


def test_what_cannot_be_trained_is_refused(windy: Transitions, base: Equations) -> None:
    with pytest.raises(ModelError, match="penalties above 0"):
        ResidualTraining(penalties=(0.0,))
    with pytest.raises(ModelError, match="at least 80 consecutive transitions, found 15"):
        ResidualTraining().fit(windy.where(np.arange(len(windy)) < 15), base)
    with pytest.raises(ShapeError, match="state columns are"):
        ResidualTraining().fit(windy, MUSHR.nominal())
