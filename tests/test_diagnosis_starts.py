"""Segments start nearer to the truth of a simulator than the rows before say, and dry friction is as large as it is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from sym2real.control import geometric_controller
from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.diagnosis.estimate.preparation import whiten
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.effects import effect
from sym2real.experiments.excitation import dithered
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import ROBOTS, Robot
from sym2real.tasks import make_task
from sym2real.trajectory import Trajectory

ROBOT, KEY, FRICTION = ROBOTS["cart_pole"], "joint_friction:slider", 0.05  # N
NOISE = 0.001  # m, rad
OTHERS = ("delay*", "lag*", "limit*", "rate_limit*", "dead_band*", "armature*", "gravity_tilt", "sensor_*", "*:pole")


def run(number: int) -> Trajectory:
    """A cart with dry friction, without noise."""
    task = make_task("regulate", ROBOT, goal={"slider": 0.3 * (-1) ** number})
    sent = dithered(geometric_controller(ROBOT, task.reference), ROBOT, np.random.default_rng(number), 2.5)
    plant = MujocoPlant(ROBOT, [effect(KEY, ROBOT).inject(value=FRICTION)])
    return run_episode(plant, sent, task, seed=number, steps=300, name=f"run {number}")


def measured(true: Trajectory, seed: int) -> Trajectory:
    """Coordinates with noise, and rates that are their differences."""
    layout, rng, state = true.layouts.state, np.random.default_rng(seed), true.state.copy()
    for coordinate, rate in layout.rates.items():
        noisy = true.column(coordinate) + NOISE * rng.standard_normal(len(true))
        state[:, layout.index(coordinate)] = noisy
        state[1:, layout.index(rate)] = np.diff(noisy) / true.dt
    return replace(true, state=state)


def test_segments_start_nearer_to_the_truth_than_rows_before_them_say() -> None:
    true = [run(number) for number in range(2)]
    data = Dataset([measured(one, seed) for seed, one in enumerate(true)])
    library = Library.of(ROBOT.nominal(), [effect(KEY, ROBOT)])
    problem = Problem(library, data)
    moved = whiten(problem, candidates(library, data)).problem.segments
    places = zip(moved.log, moved.row, strict=True)
    there = torch.as_tensor(np.stack([true[log].state[row] for log, row in places]))
    rates = [moved.layout.index(rate) for rate in moved.layout.rates.values()]
    missed = [(start - there)[:, rates].square().mean(0).sqrt() for start in (problem.segments.start, moved.start)]
    assert bool((missed[1] < 0.6 * missed[0]).all())


@pytest.mark.slow
def test_dry_friction_of_a_noisy_cart_is_as_large_as_it_is() -> None:
    data = Dataset([measured(run(number), number) for number in range(6)])
    found = diagnose(ROBOT.nominal(), data, exclude=OTHERS)
    assert [one.effect for one in found.findings] == [KEY]
    assert found.findings[0].values["value"] == pytest.approx(FRICTION, rel=0.2)


RAIL = """<mujoco><option timestep="0.001" integrator="implicitfast"/><worldbody><body>
<joint name="rail" type="slide" axis="1 0 0" damping="14" range="-0.8 0.8"/>
<inertial pos="0 0 0" mass="12" diaginertia="1 1 1"/>
</body></worldbody><actuator><motor name="drive" joint="rail" ctrlrange="-150 150"/></actuator></mujoco>"""


def shuttled(robot: Robot, seed: int) -> Trajectory:
    """A carriage that a noisy drive moves to and fro, 200 rows a second, and 5 N of friction."""
    rng = np.random.default_rng(seed)
    plant = MujocoPlant(robot, [effect("joint_friction:rail", robot).inject(value=5.0)])
    state, rows, sent = plant.reset(), [], []
    swings, phases = rng.uniform(0.08, 0.45, 3), rng.uniform(0.0, 6.28, 3)
    for row in range(3000):
        goal = 0.45 * np.sin(2 * np.pi * swings * row * robot.dt + phases).mean()
        seen = state + np.array([1e-5, 2e-3]) * rng.standard_normal(2)
        force = np.clip(12.0 * (60.0 * (goal - seen[0]) - 11.0 * seen[1]) + 1.5 * rng.standard_normal(), -150.0, 150.0)
        rows.append(seen)
        sent.append([force])
        state = plant.step(np.array([force]))
    return Trajectory.from_arrays(np.array(rows), np.array(sent), robot.layouts, dt=robot.dt, name=f"drive {seed}")


@pytest.mark.slow
def test_dry_friction_beside_a_damping_is_no_more_damping(tmp_path: Path) -> None:
    """A step from no friction finds a damping: the covariance then takes the rest for disturbances."""
    (file := tmp_path / "rail.xml").write_text(RAIL)
    robot = Robot.from_mjcf(file, dt=0.005)
    found = diagnose(robot.nominal(), Dataset([shuttled(robot, seed) for seed in range(3)]), exclude=["sensor_*"])
    assert [one.effect for one in found.findings] == ["joint_friction:rail"]
    assert found.findings[0].values["value"] == pytest.approx(5.0, rel=0.05)


STAGE = """<mujoco><option timestep="0.0005" integrator="implicitfast"/><worldbody><body>
<joint name="stage" type="slide" axis="1 0 0" damping="6"/><inertial pos="0 0 0" mass="2.4" diaginertia="1 1 1"/>
</body></worldbody><actuator>
<position name="place" joint="stage" kp="900" kv="60" ctrlrange="-1 1"/></actuator></mujoco>"""


def followed(robot: Robot, seed: int, play: float) -> Trajectory:
    """A stage that is sent along some swings, with play between its command and its servo."""
    rng = np.random.default_rng(seed)
    plant = MujocoPlant(robot, [effect("dead_band:place", robot).inject(value=play)])
    state, rows, sent = plant.reset(), [], []
    swings, phases = rng.uniform(0.1, 0.9, 4), rng.uniform(0.0, 6.28, 4)
    for row in range(700):
        goal = 0.15 * np.sin(2 * np.pi * swings * row * robot.dt + phases).sum(keepdims=True)
        rows.append(state + np.array([1e-5, 4e-3]) * rng.standard_normal(2))
        sent.append(goal)
        state = plant.step(goal)
    return Trajectory.from_arrays(np.array(rows), np.array(sent), robot.layouts, dt=robot.dt, name=f"way {seed}")


@pytest.mark.slow
def test_play_that_is_narrow_beside_what_is_sent_is_no_friction(tmp_path: Path) -> None:
    """A twentieth of the command's deviation: from a quarter of it nothing leads there."""
    (file := tmp_path / "stage.xml").write_text(STAGE)
    robot = Robot.from_mjcf(file, dt=0.01)
    found = diagnose(robot.nominal(), Dataset([followed(robot, seed, 0.012) for seed in range(3)]), MujocoPlant(robot))
    assert [one.effect for one in found.findings] == ["dead_band:place"]
    assert found.findings[0].values["value"] == pytest.approx(0.012, rel=0.03)


SLIDE = """<mujoco><worldbody><body><joint name="stage" type="slide" axis="1 0 0" damping="6"/>
<inertial pos="0 0 0" mass="2.4" diaginertia="1 1 1"/></body></worldbody>
<actuator><motor name="force" joint="stage" ctrlrange="-60 60"/></actuator></mujoco>"""


def crept(robot: Robot, seed: int) -> Trajectory:
    """A stage whose friction of 5 N gives like a spring of 4000 N/m first (P. Dahl, 1968), and which mostly sticks."""
    rng, step, parts = np.random.default_rng(seed), 2e-4, round(robot.dt / 2e-4)
    place, speed, bent, rows, sent = 0.0, 0.0, 0.0, [], []
    swings, phases = 2 * np.pi * rng.uniform(0.1, 1.2, 4), rng.uniform(0.0, 6.28, 4)
    for row in range(1400):
        angle = swings * row * robot.dt + phases
        goal, pace = 0.03 * np.sin(angle).sum(), 0.03 * (swings * np.cos(angle)).sum()
        seen = np.array([place, speed]) + np.array([1e-5, 4e-3]) * rng.standard_normal(2)
        force = 120.0 * (goal - seen[0]) + 14.0 * (pace - seen[1]) + 6.0 * pace
        rows.append(seen)
        sent.append([force])
        for _ in range(parts):
            bent += step * (speed - 4000.0 / 5.0 * abs(speed) * bent)
            speed += step * (force - 6.0 * speed - 4000.0 * bent) / 2.4
            place += step * speed
    return Trajectory.from_arrays(np.array(rows), np.array(sent), robot.layouts, dt=robot.dt, name=f"creep {seed}")


@pytest.mark.slow
def test_friction_of_a_stage_that_mostly_sticks_is_no_damping(tmp_path: Path) -> None:
    """A step from none leads to a third of it, which a damping and a delay outdo."""
    (file := tmp_path / "slide.xml").write_text(SLIDE)
    robot = Robot.from_mjcf(file, dt=0.005)
    found = diagnose(robot.nominal(), Dataset([crept(robot, seed) for seed in range(3)]))
    assert [one.effect for one in found.findings] == ["joint_friction:stage"]
    assert found.findings[0].values["value"] == pytest.approx(5.0, rel=0.15)
