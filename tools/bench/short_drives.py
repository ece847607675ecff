"""Drives of 3 s of a car in MuJoCo that has play, an offset, a late command, an arm and a speed map of its own at once.

Steering and speed go in steps; the pose has the noise of a localisation by lidar. Each effect is twice as large as the
smallest that ``plan`` says these drives show and tell from others.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import standard_trim

from sym2real.control.logged import Replayed
from sym2real.dataset import Dataset
from sym2real.diagnosis import Plan, plan
from sym2real.effects import effect
from sym2real.errors import ModelError
from sym2real.experiments import standard_conditions as conditions
from sym2real.experiments.excitation import unlimited
from sym2real.experiments.planned import usual_noise
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Change
from sym2real.robots import Robot, car
from sym2real.robots.mushr import WHEELBASE

SECONDS, DRIVES = 3.0, 20
# Of pose estimates by scan matching indoors: a centimetre and half a degree.
LIDAR = conditions.SensorNoise(position=0.01, angle=float(np.deg2rad(0.5)))
STEER, SPEED = (-0.3, 0.3), (0.4, 1.6)  # rad, m/s
HELD = (0.4, 1.0)  # s
START = 1.0  # m in x and y
DELAYS = (0.08, 0.2)  # s
LARGER = 2.0  # than the smallest that is seen and separable
NAMED = {"dead_band:steer": "value", "offset:steer": "value", "lever_arm": "rx", "delay": "value"}
SPEED_MAP = {"gain:speed": "value", "offset:speed": "value"}
PLAY_FIRST = ("delay", "gain:speed", "offset:speed", "dead_band:steer", "offset:steer", "lever_arm")
Truth = Mapping[str, Mapping[str, float]]


def steps(dt: float, rows: int, rng: np.random.Generator) -> Replayed:
    """Steering and speed that jump to drawn values and stay there for a while, whatever the car does.

    Args:
        dt: control period in s.
        rows: of a drive.
        rng: where the numbers come from.
    """
    held = list[tuple[float, float]]()
    while len(held) < rows:
        command = rng.uniform(*STEER), rng.uniform(*SPEED)
        held += [command] * (1 + round(rng.uniform(*HELD) / dt))
    return Replayed(np.array(held))


def drives(robot: Robot, seed: int, changes: tuple[Change, ...] = (), *, noisy: bool = True) -> Dataset:
    """Twenty drives: the same commands and starts for equal seeds, whatever the rate.

    Args:
        robot: the car at its rate.
        seed: of commands, starts and, apart from these, of noise and disturbances.
        changes: what the car has that its model lacks.
        noisy: with noise, trim and disturbances; without for a plan.
    """
    found = []
    for index in range(DRIVES):
        commands, noise = (np.random.default_rng([seed, index, part]) for part in range(2))
        around = (*standard_trim.trim(robot, noise), standard_trim.disturbance(robot, noise))
        sensors = (conditions.sensors(robot, noise, LIDAR),)
        plant = MujocoPlant(unlimited(robot), (*changes, *around, *sensors) if noisy else changes)
        yaw, place = commands.uniform(-np.pi, np.pi), commands.uniform(-START, START, 2)
        speed = commands.uniform(*SPEED)
        start = np.array([*place, np.sin(yaw), np.cos(yaw), speed * np.cos(yaw), speed * np.sin(yaw), 0.0])
        rows = round(SECONDS / robot.dt)
        sent = steps(robot.dt, rows, commands)
        found.append(run_episode(plant, sent, start=start, steps=rows, name=f"drive_{index + 1}"))
    return Dataset(found)


def planned(robot: Robot, seed: int) -> Plan:
    """What these drives show of a car that is as its first principles say, under the noise that they will have."""
    equations = replace(car(WHEELBASE, dt=robot.dt), numbers=robot.numbers)
    return plan(equations, drives(robot, seed, noisy=False), usual_noise(robot, LIDAR))


def truth(seen: Plan, seed: int) -> Truth:
    """Every effect at twice what is seen and separable, of a drawn sign; the delay in :data:`DELAYS`, if that is more.

    Raises:
        ModelError: for an effect that the drives do not show at any size.
    """
    rng = np.random.default_rng([seed, DRIVES])
    smallest = {(one.effect, one.parameter): one.separable for one in seen.visible}
    found: dict[str, dict[str, float]] = {}
    for key, parameter in {**NAMED, **SPEED_MAP}.items():
        size = smallest.get((key, parameter))
        if size is None:
            raise ModelError(f"{key}: expected drives that show its {parameter}, found none of its sizes separable")
        found[key] = {parameter: float(LARGER * size * rng.choice([-1.0, 1.0]))}
    found["dead_band:steer"]["value"] = abs(found["dead_band:steer"]["value"])
    found["delay"]["value"] = max(abs(found["delay"]["value"]), rng.uniform(*DELAYS))
    found["gain:speed"]["value"] += 1.0
    return found


def injected(robot: Robot, effects: Truth) -> tuple[Change, ...]:
    """The effects in MuJoCo, commands in the order in which they reach the wheels."""
    return tuple(effect(key, robot).inject(**effects[key]) for key in PLAY_FIRST)
