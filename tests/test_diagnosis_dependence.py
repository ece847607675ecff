"""What a disturbance depends on is named though no effect says so; noise, disturbances and trim depend on nothing."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from mujoco import MjData
from standard_set import Case, simulate_case, standard_run

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.whitening import Spread, estimate
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.unexplained.dependence import Terms, find_dependences
from sym2real.diagnosis.unexplained.disturbance_terms import CONSTANT, Dependence, features_in, ranked
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.effects import effect
from sym2real.experiments.excitation import unlimited
from sym2real.experiments.standard_conditions import sensors
from sym2real.least_squares import inflation
from sym2real.plants import MujocoPlant
from sym2real.protocols import Change
from sym2real.robots import ROBOTS


@cache
def without_a_library(robot: str, key: str = "", value: float = 0.0) -> tuple[Selection, Spread]:
    """A search that had nothing to choose from, on short runs in MuJoCo; variances take what it misses for their own.

    The gain of the quadrotor's rate loop, which is not known, is free; the car's tyres slip, which its equations lack.
    """
    name = "fx" if key == "wind" else "value"
    data = simulate_case(Case(robot, ((key, {name: value}),) if key else (), seed=11), rows=200)
    known = {"crazyflie": ["rate_loop_gain"], "mushr": ["lateral_slip", "lever_arm"]}[robot]
    equations = ROBOTS[robot].nominal()
    library = Library.of(equations, [effect(key, equations) for key in known])
    problem = Problem(library, data)
    spread, segments = Spread.of(problem, library.null), problem.segments
    low, high = library.bounds
    nuisance = dict(enumerate(zip(low.tolist(), high.tolist(), strict=True)))
    whitening = estimate(spread, problem.residuals(library.null[None])[0], segments.noise, segments.channel)
    for _ in range(2):
        selection = Selection(Problems(problem, whitening, nuisance), [], library.null)
        whitening = estimate(spread, problem.residuals(selection.fit.values[None])[0], segments.noise, segments.channel)
    return selection, spread


def found_in(robot: str, key: str = "", value: float = 0.0) -> Leftover | None:
    terms = Terms.of(*without_a_library(robot, key, value), None)
    return next((left for left in find_dependences(terms) if left.matters), None)


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["crazyflie", "mushr"])
def test_noise_disturbances_and_trim_depend_on_nothing(robot: str) -> None:
    assert found_in(robot) is None


@pytest.mark.slow
def test_a_force_near_the_ground_is_reported_to_depend_on_height() -> None:
    left = found_in("crazyflie", "ground_effect", 0.35)
    assert left is not None
    assert (left.channel, left.explained_by) == ("fz", "height")
    assert left.r2 > 0.5


@pytest.mark.slow
def test_a_command_that_lags_is_said_to_depend_on_what_was_sent_before() -> None:
    left = found_in("mushr", "lag:speed", 0.3)
    assert left is not None
    assert (left.channel, left.explained_by) == ("speed", "earlier speed")


@pytest.mark.slow
def test_a_force_along_the_rates_cross_product_with_the_velocity_is_seen_and_no_gust() -> None:
    """As Magnus' on a body that turns; its size varies with nothing that is measured alone."""
    robot = ROBOTS["crazyflie"]

    def magnus(_: object, data: MjData) -> None:
        rate, velocity = data.xmat[1].reshape(3, 3) @ data.qvel[3:6], data.qvel[:3]
        data.xfrc_applied[1, :3] += 0.05 * np.cross(rate, velocity)

    def plant(rng: np.random.Generator) -> MujocoPlant:
        return MujocoPlant(unlimited(robot), (sensors(robot, rng), Change("", force=magnus)))

    flights = Dataset(standard_run(robot, plant, 3, index, yaw=True) for index in range(8))
    found = diagnose(robot.nominal(), flights)
    assert found.verdict == "UNEXPLAINED"
    level = {
        left.channel: left.explained_by for left in found.leftovers if left.matters and left.channel in ("fx", "fy")
    }
    assert level == {"fx": "rate × velocity x", "fy": "rate × velocity y"}


@pytest.mark.slow
@pytest.mark.parametrize("turning", [True, False])
def test_a_force_to_the_robots_side_is_told_in_its_axes_as_it_turns(*, turning: bool) -> None:
    robot = ROBOTS["crazyflie"]

    def duct(_: object, data: MjData) -> None:
        axes = data.xmat[1].reshape(3, 3)
        data.xfrc_applied[1, :3] += 0.05 * (axes[:, 2] @ data.qvel[:3]) * axes[:, 1]

    def plant(rng: np.random.Generator) -> MujocoPlant:
        return MujocoPlant(unlimited(robot), (sensors(robot, rng), Change("", force=duct)))

    flights = Dataset(standard_run(robot, plant, 3, index, yaw=turning) for index in range(8))
    found = diagnose(robot.nominal(), flights)
    assert found.verdict == "UNEXPLAINED"
    level = {left.channel: left.explained_by for left in found.leftovers if left.channel[:2] in ("fx", "fy")}
    along = "fy in the robot's axes" if turning else "fy"
    assert level[along] in ("body velocity z", "velocity z")
    assert f"a disturbance along {along} that depends on" in found.summary


@pytest.mark.slow
def test_a_fan_that_blows_at_one_place_is_told_by_the_place() -> None:
    robot = ROBOTS["crazyflie"]

    def fan(_: object, data: MjData) -> None:
        data.xfrc_applied[1, 0] += 0.03 * (data.qpos[1] > 0.1)

    def plant(rng: np.random.Generator) -> MujocoPlant:
        return MujocoPlant(unlimited(robot), (sensors(robot, rng), Change("", force=fan)))

    found = diagnose(robot.nominal(), Dataset(standard_run(robot, plant, 3, index, yaw=True) for index in range(8)))
    assert found.verdict == "UNEXPLAINED"
    assert found.leftover is not None
    assert (found.leftover.channel, found.leftover.explained_by) == ("fx", "position y")


@pytest.mark.slow
def test_a_force_whose_mean_is_most_of_it_is_said_with_its_mean_first_and_is_no_mass() -> None:
    """A tether pulls down and makes no thrust sideways smaller, as a mass would; how its pull changes is the rest."""
    robot, pulls = ROBOTS["crazyflie"], list[float]()

    def tether(_: object, data: MjData) -> None:
        pulls.append(0.03 + 0.02 * data.qvel[0])
        data.xfrc_applied[1, 2] -= pulls[-1]

    def plant(rng: np.random.Generator) -> MujocoPlant:
        return MujocoPlant(unlimited(robot), (sensors(robot, rng), Change("", force=tether)))

    found = diagnose(robot.nominal(), Dataset(standard_run(robot, plant, 3, index, yaw=True) for index in range(8)))
    assert found.verdict == "UNEXPLAINED"
    first, *others = (left for left in found.leftovers if left.channel == "fz")
    assert first.explained_by == "constant"
    assert first.size == pytest.approx(-np.mean(pulls), rel=0.1)
    assert [left.explained_by for left in others] == ["velocity x"]


@pytest.mark.slow
def test_a_term_takes_the_force_away_that_was_put_in() -> None:
    """A wind of 20 mN is a constant force of 20 mN, which takes away what its quadratic model says."""
    selection, spread = without_a_library("crazyflie", "wind", 0.02)
    terms = Terms.of(selection, spread, None)
    (along,) = (channel for channel in terms.channels if channel.name == "fx")
    (one,) = terms.judged(terms.problems.whitening, [Dependence(along, CONSTANT)])
    one, whitening = terms.alone(one)
    size = float(one.step[one.preceding] * along.size)
    assert size == pytest.approx(0.02, rel=0.1)
    assert one.chance(terms.problems.blocks) < 1e-9
    after = float(whitening.loss(terms.side.after(one.terms, one.step)[None]).sum())
    assert terms.loss(whitening) - after == pytest.approx(one.most, rel=1e-4)
    assert 0.95 < one.fall(terms.problems.folds) / one.most <= 1.0


def test_a_constant_beside_an_offset_that_was_found_says_nothing() -> None:
    """Of the steering both do the same: one may be large, and the other as large the other way."""
    selection, spread = without_a_library("mushr")
    problem, equations = selection.problems.problem, ROBOTS["mushr"].nominal()
    library = Library.of(equations, [effect("offset:steer", equations)])
    problem = Problem(library, problem.data)
    tried = candidates(library, problem.data)
    beside = Selection(Problems(problem, selection.problems.whitening), tried, library.null)
    for chosen, alike in ((tried, (True, False)), ((), (False, False))):
        beside.put(chosen, beside.beside(chosen, beside.fit).fit)
        terms = Terms.of(beside, spread, None)
        by_name = {channel.name: channel for channel in terms.channels}
        pairs = [Dependence(by_name[name], CONSTANT) for name in ("steer", "speed")]
        constants = terms.judged(terms.problems.whitening, pairs)
        assert tuple(bool(inflation(term.curvature.sum(0))[-1] > 9) for term in constants) == alike


@pytest.mark.slow
def test_a_trim_of_every_log_has_no_part_in_what_was_sent_before() -> None:
    selection, _ = without_a_library("mushr")
    problem = selection.problems.problem
    for name, feature in features_in(problem)[0].items():
        shapes = feature.shapes(feature)
        means = torch.stack([shapes[torch.as_tensor(problem.segments.log) == log].mean((0, 1)) for log in range(8)])
        if name.startswith("earlier"):
            assert float(means.abs().max()) < 1e-9 * float(shapes.abs().max())
        else:
            torch.testing.assert_close(means[:, 0], torch.ones(8, dtype=torch.float64))


@pytest.mark.slow
def test_a_second_term_of_a_channel_is_judged_without_the_constant_of_the_first() -> None:
    """Both would have one, and share the level of the first: any feature would then go beyond chance beside it."""
    selection, spread = without_a_library("crazyflie", "wind", 0.02)
    terms = Terms.of(selection, spread, None)
    (along,) = (channel for channel in terms.channels if channel.name == "fx")
    names = [name for name in terms.features if ranked(name)]
    (first,) = terms.judged(terms.problems.whitening, [Dependence(along, names[0])])
    beside = terms.with_term(first, terms.problems.whitening)
    assert Dependence(along, CONSTANT) not in beside.pairs
    seconds = beside.judged(terms.problems.whitening, [Dependence(along, name) for name in names[1:]])
    assert first.chance(terms.problems.blocks) < 1e-9
    assert {second.curvature.shape[-1] - second.preceding for second in seconds} == {3}
    assert np.median([second.chance(terms.problems.blocks) for second in seconds]) > 0.05


def test_terms_do_not_gain_by_their_number() -> None:
    """On pure noise no term holds on logs that it has not seen."""
    selection, spread = without_a_library("mushr")
    terms = Terms.of(selection, spread, None)
    segments, rows, _ = terms.side.columns.shape
    sensor = terms.problems.whitening.sensor.repeat(rows // len(terms.problems.whitening.sensor))
    noise = torch.as_tensor(np.random.default_rng(0).normal(size=(segments, rows))) * sensor
    columns = torch.cat([noise[..., None], terms.side.columns[..., 1:]], dim=-1)
    terms = replace(terms, side=replace(terms.side, columns=columns))
    judged = terms.judged(terms.problems.whitening, terms.pairs)
    falls = np.array([one.fall(terms.problems.folds) for one in judged])
    assert falls.mean() < 0.0
    assert min(one.chance(terms.problems.blocks) for one in judged) > 0.002 / len(judged)
