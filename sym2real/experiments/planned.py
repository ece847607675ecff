"""Manoeuvres that have not been flown or driven yet, in the plain simulator, and the noise that a robot would have."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from math import inf
from typing import Any

import numpy as np
import torch

from sym2real.control import geometric_controller
from sym2real.dataset import Dataset
from sym2real.diagnosis import AssumedNoise
from sym2real.errors import ModelError, UnknownNameError
from sym2real.experiments import standard_conditions as conditions
from sym2real.experiments.excitation import dithered
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import Robot
from sym2real.tasks.regulate import regulate
from sym2real.tasks.standard_paths import Manoeuvre, path_of
from sym2real.tasks.task import flies, motion
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import WRENCH

SHAPES = {"flight": ("hover", "circle", "eight"), "drive": ("circle", "eight")}
USUAL = {
    "flight": (Manoeuvre("hover", height=0.6), Manoeuvre("circle", 0.5, 0.6, 0.5), Manoeuvre("eight", 0.8, 0.8, 0.5)),
    "drive": (Manoeuvre("circle", 1.5, 1.0), Manoeuvre("eight", 2.0, 1.0)),
}
DEFAULTS = {"flight": {"size": 0.5, "speed": 0.6, "height": 0.6}, "drive": {"size": 1.5, "speed": 1.0}}
REACH = 0.4  # m, rad: of joints, to either side of the start
# Rows over which the whitening holds a disturbance: a fifth of a segment.
HELD = {"flight": 5, "drive": 4}


def manoeuvre(robot: Robot, shape: str, options: Mapping[str, float]) -> Manoeuvre:
    """A manoeuvre by its shape: ``hover``, ``circle`` or ``eight``.

    Args:
        robot: that is to fly or drive it.
        shape: of the path.
        options: fields of :class:`~sym2real.tasks.standard_paths.Manoeuvre`: size (m), speed (m/s), height
            (m), swing (m, of the height), modulation (part of the speed), clockwise (1 or 0).

    Raises:
        UnknownNameError: for a shape or an option that does not exist.
        ModelError: for a path that nobody can fly or drive.
    """
    kind = motion(robot)
    if shape not in SHAPES[kind]:
        raise UnknownNameError(f"manoeuvre of a {robot.title}", shape, SHAPES[kind])
    known = [field.name for field in fields(Manoeuvre) if field.name != "shape"]
    for name in options:
        if name not in known:
            raise UnknownNameError(f"option of {shape}", name, known)
    given: dict[str, Any] = {**({"height": 0.6} if shape == "hover" else DEFAULTS[kind]), **options}
    manoeuvre = Manoeuvre(shape, **{**given, "clockwise": bool(given.get("clockwise", False))})
    if not (0 < manoeuvre.size < inf and 0 <= manoeuvre.speed < inf):
        raise ModelError(
            f"{shape}: expected size > 0 m and speed >= 0 m/s, found {manoeuvre.size:g} and {manoeuvre.speed:g}"
        )
    if kind == "flight" and not 0 < manoeuvre.height - abs(manoeuvre.swing) < inf:
        raise ModelError(
            f"{shape}: expected a height above the swing of the height, m, "
            f"found {manoeuvre.height:g} and {manoeuvre.swing:g}"
        )
    return manoeuvre


def planned_runs(
    robot: Robot,
    manoeuvres: Sequence[Manoeuvre] = (),
    *,
    seconds: float = 8.0,
    yaw_rate: float = 0.0,
    dither: float = 1.0,
) -> Dataset:
    """Manoeuvres in the plain simulator, without noise, with the dither of the standard set on the commands.

    Args:
        robot: what flies or drives.
        manoeuvres: the robot's usual three or two by default.
        seconds: of each.
        yaw_rate: of a quadrotor's heading in rad/s.
        dither: factor on the standard set's (thrust 5 mN, rates 0.15 rad/s; steering 0.03 rad, speed 0.1 m/s).

    Raises:
        ModelError: for a manoeuvre that ends in a crash.
    """
    steps, runs = round(seconds / robot.dt), list[Trajectory]()
    for index, manoeuvre in enumerate(manoeuvres or USUAL[motion(robot)]):
        reference = path_of(robot, manoeuvre, 0.0, yaw_rate)
        sent = dithered(geometric_controller(robot, reference), robot, np.random.default_rng([0, index]), dither)
        start = reference(torch.zeros((), dtype=torch.float64)).numpy()
        run = run_episode(MujocoPlant(robot), sent, start=start, steps=steps, name=f"{manoeuvre.shape}_{index + 1}")
        _require_whole(robot, manoeuvre.shape, run, steps, "plan a slower, larger or higher one")
        runs.append(run)
    return Dataset(runs)


def planned_moves(
    robot: Robot, texts: Sequence[tuple[str, Mapping[str, float]]], *, seconds: float = 8.0, dither: float = 1.0
) -> Dataset:
    """Noisy runs of a robot of joints in the plain simulator, to one goal after the other.

    Args:
        robot: of joints.
        texts: each ``regulate`` with the joints' goals, m and rad; its start for the others. By default there and back:
            all joints that an actuator moves by :data:`REACH` to either side of the start.
        seconds: of each.
        dither: factor on the robot's own, a fiftieth of its commands' range.

    Raises:
        UnknownNameError: for another name, or a column that the robot does not have.
        ModelError: for a goal on the way to which a joint leaves its range.
    """
    layout, steps = robot.layouts.state, round(seconds / robot.dt)
    for name, _ in texts:
        if name != "regulate":
            raise UnknownNameError(f"manoeuvre of a {robot.title}", name, ["regulate"])
    moved = {rate for rate, _ in robot.recipe.dependencies}
    start = {joint: float(robot.start[layout.index(joint)]) for joint in layout.joints if layout.rates[joint] in moved}
    usual = [{joint: place + side * REACH for joint, place in start.items()} for side in (1.0, -1.0)]
    goals = [regulate(robot, goal) for goal in [goal for _, goal in texts] or usual]
    runs = noisy_runs(robot, goals, count=len(goals), rows=steps, dither=dither)
    for number, run in enumerate(runs, 1):
        _require_whole(robot, f"goal {number}", run, steps, "plan a nearer one")
    return runs


def _require_whole(robot: Robot, name: str, run: Trajectory, steps: int, instead: str) -> None:
    if len(run) < steps:
        after, planned = len(run) * robot.dt, steps * robot.dt
        raise ModelError(f"{name}: the simulated {robot.title} crashed after {after:g} of {planned:g} s; {instead}")


def usual_noise(robot: Robot, noise: conditions.SensorNoise = conditions.STANDARD_NOISE) -> AssumedNoise:
    """Noise and disturbances of the standard set, the latter as the whitening describes them.

    An Ornstein–Uhlenbeck process of deviation σ and time τ moves slow states as steps of length T do whose deviation
    is σ √(2τ/T).
    """
    length = robot.dt * HELD[motion(robot)]
    sensors = {"position": noise.position, "attitude": noise.angle, "rate": noise.rate}
    if not flies(robot):
        commands = np.sqrt(2 * conditions.COMMANDS_TIME / length) * conditions.COMMANDS
        return AssumedNoise({**sensors, "heading": noise.angle}, dict(zip(("steer", "speed"), commands, strict=True)))
    force = np.sqrt(2 * conditions.FORCE_TIME / length) * conditions.FORCE
    torque = np.sqrt(2 * conditions.TORQUE_TIME / length) * conditions.TORQUE
    return AssumedNoise(sensors, dict(zip(WRENCH, map(float, (*force, *torque)), strict=True)))
