"""The fused step against torch in float64 and float32, with every kind of memory and noise, and at its limits."""

from __future__ import annotations

import gc
import logging
import math
import os
import subprocess
import sys
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from reference_models import flying, late, motor_lagged
from scipy import stats

from sym2real.control import MPPI
from sym2real.control.plan import shift
from sym2real.diagnosis import add
from sym2real.effects.filters import FilterState
from sym2real.effects.visible import VisibleModel
from sym2real.errors import ModelError
from sym2real.native import find_compiler
from sym2real.robots import CRAZYFLIE, MUSHR, MPPISettings, Robot
from sym2real.symbolic import Equations, compile_model, symbol
from sym2real.tasks import make_task

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

MODELS = {
    "sines": (CRAZYFLIE, flying),
    "quadrotor": (CRAZYFLIE, CRAZYFLIE.nominal),
    "car": (MUSHR, MUSHR.nominal),
    "filters": (MUSHR, late),
    "filters in flight": (CRAZYFLIE, lambda: late(CRAZYFLIE)),
    "hidden state": (CRAZYFLIE, motor_lagged),
    "a rate limit before a loop": (CRAZYFLIE, lambda: add(CRAZYFLIE.nominal(), "rate_limit:wx_cmd", {"value": 20.0})),
    "delay in flight": (CRAZYFLIE, lambda: add(CRAZYFLIE.nominal(), "delay", {"value": 0.04})),
    **{
        f"{key} {values}": (MUSHR, lambda key=key, values=values: add(MUSHR.nominal(), key, values))
        for key, values in (
            ("delay", {"value": 0.0}),
            ("delay", {"value": MUSHR.dt}),
            ("delay", {"value": 4 * MUSHR.dt}),
            ("delay:steer", {"value": 0.12}),
            ("limit:speed", {"upper": 1}),
            ("limit:steer", {"magnitude": 0.2}),
            ("rate_limit:speed", {"value": 2}),
            ("rate_limit:steer", {"value": 1}),
            ("dead_band:steer", {"value": 0.1}),
            ("lag", {"value": 1}),
        )
    },
}


def controller(robot: Robot, equations: Equations, backend: str, **options: object) -> MPPI:
    filters = FilterState(equations) if equations.filters else None
    dtype = options.pop("dtype", torch.float32)
    task = options.pop("task", make_task("circle", robot))
    model = VisibleModel(equations, dtype=dtype)
    return MPPI(model, robot, task, backend=backend, filters=filters, dtype=dtype, **options)


def disturbed_start(robot: Robot) -> np.ndarray:
    rng = np.random.default_rng(0)
    state = make_task("circle", robot).start(rng) + 0.1 * rng.normal(size=robot.start.size)
    return robot.layouts.state.normalise(torch.from_numpy(state)).numpy()


@pytest.mark.parametrize("name", MODELS)
def test_same_noise_same_action_as_torch(name: str) -> None:
    robot, make = MODELS[name]
    equations = make()
    settings = replace(robot.mppi, samples=203)  # no multiple of any vector's width
    fused = controller(robot, equations, "c", settings=settings)
    torch32 = controller(robot, equations, "torch", settings=settings)
    exact = controller(robot, equations, "torch", settings=settings, dtype=torch.float64)
    state = disturbed_start(robot)
    for step in range(3):
        fused.act(state, step)
        noise = fused._fused.noise(fused.seed, fused._call)
        plan, (given, _) = fused.plan, fused._seen
        for one in (torch32, exact):
            one.mean = shift(given.mean, given.steps).to(one.dtype)  # all begin with the same plan
        torch32.improve(state, step, noise)
        reference = exact.improve(state, step, noise.double())
        error = (plan.costs - reference.costs).abs() / reference.costs.abs()
        assert float(error.max()) < 1e-5
        scale = torch.tensor(robot.high - robot.low)
        assert float(((torch32.mean - fused.mean).abs() / scale).max()) < 2e-5
        assert float(((exact.mean - fused.mean).abs() / scale).max()) < 2e-5
        for one in (fused, torch32, exact):
            one.remember(0.5 * (robot.low + robot.high))


def test_a_plan_is_that_of_its_action_also_when_another_command_was_sent_since() -> None:
    """States of a plan are told when they are asked for: a filter has gone on meanwhile, and they were 0.2 m off."""
    told, late = (controller(MUSHR, add(MUSHR.nominal(), "lag:speed", {"value": 0.3}), "c") for _ in range(2))
    for one in (told, late):
        one.act(MUSHR.start, 0)
        one.remember([0.0, 2.0])
        one.act(MUSHR.start, 1)
    states = told.plan.states
    late.remember([0.0, -2.0])
    torch.testing.assert_close(late.plan.states, states, rtol=0, atol=0)


@pytest.mark.slow
def test_states_are_those_of_float64_within_a_ten_thousandth() -> None:
    """Forty steps of one sample at a time, read through a cost that is a state column."""
    state, worst = disturbed_start(CRAZYFLIE), 0.0
    for column in CRAZYFLIE.layouts.state:
        task = replace(make_task("circle", CRAZYFLIE), cost=symbol(column) + 0 * symbol("ref_x"))
        fused = controller(CRAZYFLIE, flying(), "c", task=task)
        exact = controller(CRAZYFLIE, flying(), "torch", task=task, dtype=torch.float64)
        fused.act(state, 0)
        plan = exact.improve(state, 0, fused._fused.noise(0, 1).double())
        size = plan.states.abs().amax(dim=(1, 2)) * fused.horizon
        worst = max(worst, float(((fused.plan.costs - plan.costs).abs() / size).max()))
    assert worst < 1e-5


@pytest.mark.parametrize("scale", [2.0, 0.3])
def test_a_measured_quaternion_of_another_length_is_put_on_the_manifold_first(scale: float) -> None:
    """Short sines are right for unit vectors alone; a large turn rate is left as it is."""
    state = disturbed_start(CRAZYFLIE)
    state[10] = 48.0
    fused = controller(CRAZYFLIE, flying(), "c")
    exact = controller(CRAZYFLIE, flying(), "torch", dtype=torch.float64)
    fused.act(np.where(np.array([c[0] == "q" for c in CRAZYFLIE.layouts.state]), scale, 1.0) * state, 0)
    plan = exact.improve(state, 0, fused._fused.noise(0, 1).double())
    assert float(((fused.plan.costs - plan.costs).abs() / plan.costs).max()) < 1e-5


@pytest.mark.parametrize("samples", [1, 2, 15, 16, 17, 64])
def test_samples_beside_the_vector_width_count_for_nothing(samples: int) -> None:
    settings = replace(MUSHR.mppi, samples=samples)
    fused = controller(MUSHR, MUSHR.nominal(), "c", settings=settings)
    state = disturbed_start(MUSHR)
    fused.act(state, 0)
    assert fused.plan.costs.shape == (samples,)
    torch32 = controller(MUSHR, MUSHR.nominal(), "torch", settings=settings)
    torch32.improve(state, 0, fused._fused.noise(0, 1))
    torch.testing.assert_close(fused.mean, torch32.mean, atol=2e-5, rtol=0)


@pytest.mark.parametrize(
    "settings",
    [
        MPPISettings(noise=(0.1, 0.5)),
        MPPISettings(noise=(0.1, 0.5), correlation=0.2),
        MPPISettings(noise=(0.1, 0.5), knots=5),
    ],
)
def test_noise_is_normal_with_the_size_and_the_colour_asked_for(settings: MPPISettings) -> None:
    fused = controller(MUSHR, MUSHR.nominal(), "c", settings=replace(settings, samples=50_001, noise=(0.2, 0.3)))
    covariance = np.diag([0.04, 0.09])
    noise = fused._fused.noise(7, 1).double().numpy()
    assert (noise[0] == 0).all()
    noise = noise[1:]
    expected = fused._smooth.double().numpy() @ fused._smooth.double().numpy().T
    for step in (0, fused.horizon // 2, fused.horizon - 1):
        np.testing.assert_allclose(np.cov(noise[:, step].T), covariance, atol=0.002)
        whitened = noise[:, step] @ np.linalg.inv(np.linalg.cholesky(covariance)).T
        for column in whitened.T:
            assert stats.kstest(column, "norm").pvalue > 1e-4
            assert abs(stats.kurtosis(column)) < 0.1
    np.testing.assert_allclose(np.corrcoef(noise[:, :, 0].T), expected, atol=0.02)


def test_noise_of_samples_steps_and_calls_is_independent_and_repeats() -> None:
    fused = controller(CRAZYFLIE, CRAZYFLIE.nominal(), "c", settings=MPPISettings(noise=(1, 1, 1, 1), samples=4096))
    first, again, other, next_call = (
        fused._fused.noise(seed, call).double().numpy() for seed, call in ((1, 1), (1, 1), (2, 1), (1, 2))
    )
    np.testing.assert_array_equal(first, again)
    flat = first[1:].reshape(-1)
    neighbours = other[1:], other, other[2:]  # sample by sample, and those before and behind
    for shifted in (flat[1:], flat[4:], flat[160:], *(n.reshape(-1) for n in neighbours), next_call[1:].reshape(-1)):
        size = min(len(flat), len(shifted))
        assert abs(np.corrcoef(flat[:size], shifted[:size])[0, 1]) < 4.5 / math.sqrt(size)
        assert abs(np.corrcoef(flat[:size] ** 2, shifted[:size] ** 2)[0, 1]) < 4.5 / math.sqrt(size)
    assert 4.6 < np.abs(flat).max() < 6.0  # of 650 000 numbers


def test_seed_and_reset_repeat_actions() -> None:
    runs = []
    for seed in (1, 1, 2):
        mppi = controller(MUSHR, MUSHR.nominal(), "c", seed=seed)
        runs.append([mppi.act(MUSHR.start, step) for step in range(3)])
        mppi.reset()
        np.testing.assert_array_equal(mppi.act(MUSHR.start, 0), runs[-1][0])
    np.testing.assert_array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])


def test_rollouts_that_are_not_finite_have_no_weight_and_are_counted() -> None:
    """Above 1 m/s the square root of a negative number; all other rollouts decide."""
    base = MUSHR.nominal()
    broken = {**base.next, "x": base.next["x"] + 1e-9 * (1 - symbol("speed")) ** 0.5}
    fused = controller(MUSHR, replace(base, next=broken), "c")
    fused.act(MUSHR.start, 0)
    bad = (fused.plan.actions[..., 1] > 1.0).any(-1)
    assert fused.rejected == fused.plan.rejected == int(bad.sum()) > 5
    assert (fused.plan.weights[bad] == 0).all()
    clean = controller(MUSHR, base, "torch")
    clean.improve(MUSHR.start, 0, fused._fused.noise(0, 1)[~bad])
    torch.testing.assert_close(fused.mean, clean.mean, atol=2e-5, rtol=0)


def test_the_last_plan_goes_on_where_no_rollout_is_finite(caplog: pytest.LogCaptureFixture) -> None:
    fused = controller(MUSHR, MUSHR.nominal(), "c")
    fused.act(MUSHR.start, 0)
    before = fused.mean
    with caplog.at_level(logging.WARNING):
        fused.act(np.full(7, np.nan), 0)
    torch.testing.assert_close(fused.mean, before)
    assert fused.rejected == fused.samples
    assert "no rollout at step 0" in caplog.text


def test_limits_are_never_left() -> None:
    fused = controller(MUSHR, MUSHR.nominal(), "c", settings=replace(MUSHR.mppi, noise=(30.0, 30.0)))
    for step in range(5):
        action = fused.act(MUSHR.start, step)
        assert (action >= MUSHR.low).all() and (action <= MUSHR.high).all()
        assert (fused.plan.actions.double().numpy() <= MUSHR.high + 1e-6).all()


def test_wrench_and_time_reach_the_rollouts() -> None:
    equations = CRAZYFLIE.nominal()
    inputs = np.array([0.02, -0.01, 0.03, 1e-5, -1e-5, 2e-6])
    pair = [controller(CRAZYFLIE, equations, backend) for backend in ("c", "torch")]
    noise = pair[0]._fused.noise(1, 1)
    pushed = [mppi.improve(CRAZYFLIE.start, 0, noise, inputs).costs for mppi in pair]
    torch.testing.assert_close(*pushed, rtol=1e-5, atol=1e-5)
    calm = pair[1].improve(CRAZYFLIE.start, 0, noise).costs
    assert float((calm - pushed[1]).abs().max()) > 0.1


def test_the_choice_is_said_and_can_be_forced(caplog: pytest.LogCaptureFixture) -> None:
    task = make_task("circle", MUSHR)
    model = compile_model(MUSHR.nominal())
    with caplog.at_level(logging.INFO):
        assert MPPI(model, MUSHR, task).backend == "c"
        assert MPPI(model, MUSHR, task, backend="torch").backend == "torch"
        assert MPPI(lambda s, a: s, MUSHR, task).backend == "torch"
    assert [record.message.split(" by ")[1] for record in caplog.records] == [
        "a fused C kernel",
        "torch (torch was asked for)",
        "torch (the model is not compiled from equations)",
    ]
    with pytest.raises(ModelError, match="not compiled from equations"):
        MPPI(lambda s, a: s, MUSHR, task, backend="c")
    with pytest.raises(ModelError, match="float64"):
        MPPI(model, MUSHR, task, backend="c", dtype=torch.float64)


@pytest.mark.slow
def test_every_process_writes_the_same_text() -> None:
    """Hashes of strings differ from process to process, and with them the order of sets: the cache would be missed."""
    code = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from reference_models import CRAZYFLIE, flying\n"
        "from sym2real.control.planning_program import planning_program\n"
        "from sym2real.symbolic.c_rollout import rollout_text\n"
        "from sym2real.tasks import make_task\n"
        "cost = make_task('circle', CRAZYFLIE).cost\n"
        "print(planning_program(flying(), CRAZYFLIE, cost), rollout_text(flying(), single=True))"
    )
    command = [sys.executable, "-c", code, str(Path(__file__).parent)]
    found = {
        subprocess.run(
            command, env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, text=True, check=True
        ).stdout
        for seed in ("1", "2")
    }
    assert len(found) == 1


def test_an_action_allocates_nothing_that_grows() -> None:
    mppi = controller(CRAZYFLIE, CRAZYFLIE.nominal(), "c")
    for step in range(200):  # past several blocks of references
        mppi.act(CRAZYFLIE.start, step)
    gc.collect()
    tracemalloc.start()
    before, objects = tracemalloc.get_traced_memory()[0], len(gc.get_objects())
    for step in range(200, 600):
        mppi.act(CRAZYFLIE.start, step)
    gc.collect()
    grown, more = tracemalloc.get_traced_memory()[0] - before, len(gc.get_objects()) - objects
    tracemalloc.stop()
    assert grown < 100_000 and more < 100
