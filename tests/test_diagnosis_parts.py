"""Parts of the diagnosis against what must hold of them: nuisance, full model, refined base, segments one by one."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from noisy_flights import LEFT_OUT, flights, flights_with, flights_with_all
from numpy.typing import NDArray

from sym2real.control.logged import Replayed
from sym2real.dataset import Dataset
from sym2real.diagnosis import add, diagnose
from sym2real.diagnosis.estimate import full_model
from sym2real.diagnosis.estimate.calibrate import refined
from sym2real.diagnosis.estimate.fit import Hypothesis, Problems
from sym2real.diagnosis.estimate.full_model import improved, root
from sym2real.diagnosis.estimate.preparation import whiten
from sym2real.diagnosis.estimate.simulator import flown_along
from sym2real.diagnosis.estimate.whitening import Spread
from sym2real.diagnosis.predict.candidate import candidates, library_for
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.effects import effect
from sym2real.effects.filters import with_hidden_start
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, ROBOTS, Robot, quadrotor
from sym2real.symbolic import compile_model, rollout, symbol
from sym2real.tasks import make_task
from sym2real.trajectory import Trajectory

# What competes in these tests: the loop's gain, wind, centre of mass, delay.
OTHERS = (*LEFT_OUT, "linear_drag", "added_mass", "mounting_tilt")


@pytest.mark.slow
@pytest.mark.parametrize(("gain", "found"), [(0.88, []), (0.5, ["rate_loop_gain"])])
def test_the_rate_loops_gain_is_a_finding_only_beyond_what_nobody_knows(gain: float, found: list[str]) -> None:
    data = flights_with("rate_loop_gain", {"value": gain})
    result = diagnose(CRAZYFLIE.nominal(), data, exclude=OTHERS)
    assert [one.effect for one in result.findings] == found
    if found:
        assert result.findings[0].values["value"] == pytest.approx(gain, rel=0.1)


def test_variances_do_not_depend_on_an_effect_that_is_there() -> None:
    base = CRAZYFLIE.nominal()
    deviations = []
    for data in (flights(), flights_with("wind", {"fx": 0.02, "fy": -0.01})):
        library = library_for(base, data, OTHERS)
        whitening = whiten(Problem(library, data), candidates(library, data)).whitening
        deviations.append(whitening.disturbances)
    for name in ("fx", "fy", "fz"):
        assert deviations[1][name] == pytest.approx(deviations[0][name], rel=0.2)


def test_a_base_with_a_wrong_constant_is_mended_in_the_plain_simulator() -> None:
    base, plant = CRAZYFLIE.nominal(), MujocoPlant(CRAZYFLIE)
    flown, _ = flown_along(base, plant, flights())
    assert flown is not None
    assert refined(Library.of(base, []), flown, flights()) is base
    wrong = base.substitute({"thrust": 1.03 * symbol("thrust")})
    mended = refined(Library.of(wrong, []), flown, flights())
    errors = []
    for equations in (wrong, mended):
        problem = Problem(Library.of(equations, []), flown)
        missed = problem.residuals(problem.library.null[None]).reshape(-1, len(problem.segments.compared))
        errors.append(float(missed[:, :3].square().mean().sqrt()))
    assert errors[1] < 0.25 * errors[0]


def test_segments_under_sets_of_their_own_are_those_of_one_set_for_all() -> None:
    base = CRAZYFLIE.nominal()
    library = Library.of(base, [effect(key, base) for key in ("wind", "delay")])
    problem = Problem(library, flights())
    sets = torch.stack([library.null, library.null + 0.01])
    which = torch.arange(len(problem.segments)) % 2
    together, each = problem.states(sets), problem.states_by_segment(sets, which)
    torch.testing.assert_close(each, together[which, torch.arange(len(which))])


@pytest.mark.parametrize(("key", "value"), [("motor_lag", 0.05), ("rotor_reaction", 5e-9)])
def test_hidden_memory_begins_in_a_fit_where_it_begins_in_the_model(key: str, value: float) -> None:
    """A free memory that began at zero would make a jump of every segment's first command."""
    base, data = CRAZYFLIE.nominal(), flights()
    problem = Problem(Library.of(base, [effect(key, base)]), data)
    fitted = problem.states(problem.library.null[None] + value)[0]
    model, segments = add(base, key, {"value": value}), problem.segments
    compiled = compile_model(model, dtype=torch.float64)
    known = tuple(torch.as_tensor(np.stack([getattr(one, name) for one in data])) for name in ("action", "inputs"))

    def along(places: NDArray[np.int64]) -> tuple[torch.Tensor, torch.Tensor]:
        sent, pushed = (values[segments.log[:, None], places] for values in known)
        return sent, pushed

    sent, pushed = along(segments.rows_before())
    rested = with_hidden_start(model, segments.before, sent[:, 0], pushed[:, 0])
    through = rollout(compiled, rested, sent, pushed)[..., segments.start.shape[-1] :]
    memory = through[np.arange(len(segments)), segments.warm_up - 1]
    predicted = rollout(compiled, torch.cat([segments.start, memory], dim=-1), *along(segments.ahead()))
    torch.testing.assert_close(fitted[:, 1:], predicted[..., : fitted.shape[-1]], rtol=1e-9, atol=1e-9)


def test_hidden_memory_has_as_long_to_settle_in_a_fast_log() -> None:
    """The lag's own equations made the logs, at rest where they begin: what is left of a false start stays small."""
    rng, missed = np.random.default_rng(0), []
    thrust = CRAZYFLIE.numbers["mass"] * 9.81 * rng.uniform(0.7, 1.3, 15)  # N, each held for 0.2 s
    for dt in (0.02, 0.004):
        model = add(quadrotor(CRAZYFLIE.numbers["mass"], dt=dt), "motor_lag", {"value": 0.1})
        sent = np.zeros((round(3.0 / dt), 4))
        sent[:, 0] = np.repeat(thrust, round(0.2 / dt))
        level = torch.zeros(len(CRAZYFLIE.layouts.state), dtype=torch.float64)
        level[3] = 1.0
        start = with_hidden_start(model, level, torch.as_tensor(sent[0]))
        after = rollout(compile_model(model, dtype=torch.float64), start, torch.as_tensor(sent))
        states = torch.cat([level[None], after[:-1, : len(level)]]).numpy()
        log = Trajectory.from_arrays(states, sent, CRAZYFLIE.layouts, dt=dt)
        problem = Problem(Library.of(model, []), Dataset([log]))
        missed.append(float(problem.residuals(problem.library.null[None]).square().mean().sqrt()))
    assert max(missed) < 2e-4  # m or rad; through eight rows it would be 2e-3


@pytest.mark.parametrize("smallest", [-6e-11, -1e-6])
def test_rounding_leaves_a_curvature_with_a_factor(smallest: float) -> None:
    """As logs without noise gave it, long ones and of a second: two parameters that are one, and less than nothing."""
    rng = np.random.default_rng(0)
    sensitivity = rng.normal(size=(200, 6)) * 10.0 ** rng.uniform(0, 6, 6)
    sensitivity[:, 5] = 3.0 * sensitivity[:, 4]
    curvature = sensitivity.T @ sensitivity
    scale = np.sqrt(np.outer(curvature.diagonal(), curvature.diagonal()))
    values, vectors = np.linalg.eigh(curvature / scale)
    values[0] = smallest
    indefinite = (vectors * values) @ vectors.T * scale
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.cholesky(indefinite)
    factor = root(indefinite)
    np.testing.assert_allclose(factor @ factor.T / scale, curvature / scale, atol=1e-8 + 2 * abs(smallest))


@pytest.mark.parametrize("prior", [1.0, 1e5])
def test_the_fit_of_everything_is_the_least_of_errors_and_prior_wherever_the_prior_is(
    prior: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A prior that hardly counts beside the flights, and one beside which they hardly count."""
    monkeypatch.setattr(full_model, "PRIOR", prior)
    data = flights()
    library = library_for(CRAZYFLIE.nominal(), data, OTHERS[:-2])
    tried = [one for one in candidates(library, data) if one.name in ("added_mass", "wind", "linear_drag")]
    problem = Problem(library, data)
    problems = Problems(problem, whiten(problem, tried).whitening)
    free = tuple(slot for one in tried for slot in one.free)
    slots = list(free)
    scale = library.scale[slots]
    centre = library.null.clone()
    centre[slots] += 4.0 * scale

    def objective(sets: torch.Tensor) -> torch.Tensor:
        losses = problems.whitening.loss(problem.residuals(sets)).sum(1)
        return losses + prior * ((sets[:, slots] - centre[slots]) / scale).square().sum(1)

    best = improved(problems, free, library.null, centre, 20)
    beside = best.repeat(2 * len(slots), 1)
    for place, slot in enumerate(slots):
        beside[2 * place : 2 * place + 2, slot] += torch.tensor([-1.0, 1.0]) * 2e-3 * scale[place]
    assert float(objective(best[None])) < float(objective(library.null[None]))
    assert bool((objective(beside) > objective(best[None])).all())


@pytest.mark.slow
def test_one_rate_command_may_have_a_gain_of_its_own() -> None:
    """Both shared one, and roll alone was a flapping moment with a torque left over that depends on its command."""
    data = flights_with("gain:wx_cmd", {"value": 1.4})
    result = diagnose(
        CRAZYFLIE.nominal(), data, exclude=[key for key in OTHERS if key not in ("gain:*", "flapping_moment")]
    )
    assert [one.effect for one in result.findings] == ["gain:wx_cmd"]
    assert result.findings[0].values["value"] == pytest.approx(1.4, rel=0.05)


@pytest.mark.slow
def test_each_of_two_alike_commands_scatters_over_logs_by_itself() -> None:
    """By the name of the parameter alone, which both have, one had the other's."""
    data = flights_with_all({"gain:wx_cmd": {"value": 1.4}, "gain:wy_cmd": {"value": 0.8}})
    others = [key for key in OTHERS if key != "gain:*"]
    found = {one.effect: one for one in diagnose(CRAZYFLIE.nominal(), data, exclude=others).findings}
    assert set(found) == {"gain:wx_cmd", "gain:wy_cmd"}
    first, second = (found[key].log_spread["value"] for key in sorted(found))
    assert first > 0.0
    assert second > 0.0
    assert first != second


@pytest.mark.slow
def test_a_base_of_thousands_of_constants_is_kept_as_it_is() -> None:
    """Those of six joints are masses and lengths of the simulator's own file; a matrix of each takes gigabytes."""
    arm = ROBOTS["arm"]
    start = dict(zip(arm.layouts.state, arm.start, strict=True))
    moved = make_task("regulate", arm, goal={"shoulder": start["shoulder"] + 0.4})
    flown = noisy_runs(arm, [moved], [("joint_friction:shoulder", {"value": 5.0})], count=1, rows=60)
    base = arm.nominal()
    assert refined(Library.of(base, []), flown, flown) is base


SERVOS = """<mujoco><option timestep="0.002"/><worldbody><body pos="0 0 1">
<joint name="shoulder" type="hinge" axis="0 1 0" range="-120 120" damping="0.4"/>
<geom type="capsule" fromto="0 0 0 0.32 0 0" size="0.035" mass="1.9" contype="0" conaffinity="0"/>
<body pos="0.32 0 0"><joint name="elbow" type="hinge" axis="0 1 0" range="-150 150" damping="0.2"/>
<geom type="capsule" fromto="0 0 0 0.27 0 0" size="0.025" mass="0.9" contype="0" conaffinity="0"/>
</body></body></worldbody><actuator>
<position name="shoulder_servo" joint="shoulder" kp="160" kv="16" ctrlrange="-2 2"/>
<position name="elbow_servo" joint="elbow" kp="70" kv="5" ctrlrange="-2.5 2.5"/></actuator></mujoco>"""


@pytest.mark.slow
def test_an_arm_on_servos_is_calibrated_on_the_manoeuvres_of_its_logs(tmp_path: Path) -> None:
    """A regulator about one posture throws it from limit to limit; under the commands of its logs it moves as there."""
    (tmp_path / "servos.xml").write_text(SERVOS)
    robot = Robot.from_mjcf(tmp_path / "servos.xml", dt=0.01)
    time = 0.01 * np.arange(600)[:, None]
    sent = [-0.6, 1.2] + 0.5 * np.sin(time * [2.1, 3.3]) + 0.2 * np.sin(time * [7.0, 5.0])
    plant = MujocoPlant(robot, [effect("delay", robot).inject(value=0.03)])
    log = run_episode(plant, Replayed(sent), start=[*sent[0], 0.0, 0.0], steps=len(sent))
    flown, _ = flown_along(robot.nominal(), MujocoPlant(robot), Dataset([log]))
    assert flown is not None
    (flight,) = flown
    assert np.abs(flight.state[:, :2] - log.state[: len(flight), :2]).max() < 0.15


def test_a_step_goes_no_further_than_the_quadratic_model_holds(tmp_path: Path) -> None:
    """Both links swing upright: to first order a roll of the base is nothing, and much of it a lighter arm."""
    text = re.sub(r'kp="\d+" kv="\d+" ', "", SERVOS).replace("<position", "<motor")
    (tmp_path / "motors.xml").write_text(text)
    arm = Robot.from_mjcf(tmp_path / "motors.xml", dt=0.02)
    sent = [1.5, 0.4] * np.sin(0.02 * np.arange(300)[:, None] * [2.1, 3.3])
    log = run_episode(MujocoPlant(arm), Replayed(sent), start=[1.5, 0.1, 0.0, 0.0], steps=len(sent))
    base = arm.nominal()
    problem = Problem(Library.of(base, [effect("gravity_tilt", base)]), Dataset([log]))
    spread, near = Spread.of(problem, problem.library.null), problem.library.null + torch.tensor([0.005, 0.0])
    noise = torch.full((len(problem.segments.compared),), 1e-3, dtype=torch.float64)
    problems = Problems(problem, spread.whitening(noise.square(), torch.full((2,), 1e-6, dtype=torch.float64)))
    (fit,) = problems.quadratics([Hypothesis((0, 1), near)])
    pulled = replace(fit, gradient=fit.gradient - fit.curvature @ torch.tensor([10.0, 0.0], dtype=torch.float64))
    best, sure = problems.best_step(pulled), problems.sure_step(pulled, fit)
    assert best[0] == pytest.approx(10.0, abs=1.0)  # 0.3 rad
    far, here = problems.totals([problems.moved(fit, best), problems.moved(fit, sure)]).tolist()
    predicted = [float(fit.after(step.expand(len(fit.loss), -1)).sum()) for step in (best, sure)]
    assert far > 2 * predicted[0]
    assert here <= 1.1 * predicted[1]
    torch.testing.assert_close(problems.sure_step(fit, fit), problems.best_step(fit))  # it holds where it is asked for
