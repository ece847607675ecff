"""The standard set: flights and drives of a simulated robot with known effects, on which the diagnosis is judged.

Controllers are geometric, know only the nominal robot and see the noisy measurements; the quadrotor's height loop has
an integrator, trimmed before the log starts, without which no robot that is too heavy flies 0.1 m above the ground.
The effects of a case are in its plant alone: nothing in the data names them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import standard_trim
import torch
from at_its_pace import GAINS, AtItsPace
from numpy.typing import ArrayLike

from sym2real.control import GeometricQuadrotor
from sym2real.dataset import Dataset
from sym2real.effects import effect
from sym2real.errors import ModelError
from sym2real.experiments.excitation import dithered, unlimited
from sym2real.experiments.standard_conditions import sensors
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Controller, Memoryless, Plant
from sym2real.robots import ROBOTS, Robot
from sym2real.tasks.cost import tracking_cost
from sym2real.tasks.standard_paths import Manoeuvre, path_of
from sym2real.tasks.task import Reference, Task, flies, motion
from sym2real.trajectory import Array, Trajectory

FLIGHTS = (
    Manoeuvre("hover", height=0.6),
    Manoeuvre("hover", height=0.12, swing=0.04),
    Manoeuvre("circle", 0.5, 0.6, 0.5),
    Manoeuvre("circle", 0.5, 1.2, 0.7, 0.1),
    Manoeuvre("circle", 0.4, 0.5, 0.10, 0.03),
    Manoeuvre("eight", 0.8, 0.8, 0.5),
    Manoeuvre("eight", 0.8, 1.4, 0.6, 0.1),
    Manoeuvre("eight", 0.6, 0.5, 0.4),
)
DRIVES = (
    Manoeuvre("circle", 1.5, 1.0),
    Manoeuvre("circle", 1.5, 1.0, clockwise=True),
    Manoeuvre("circle", 1.2, 1.5),
    Manoeuvre("circle", 1.5, 2.0, modulation=0.3, clockwise=True),
    Manoeuvre("eight", 2.0, 1.0),
    Manoeuvre("eight", 2.0, 1.4),
    Manoeuvre("eight", 1.8, 0.8, modulation=0.3),
    Manoeuvre("eight", 2.4, 1.5, modulation=0.35),
)
YAW_RATES = (0.5, 0.8)  # rad/s
INTEGRAL = 5.0  # 1/s³ of acceleration per m s
TAKE_OFF, TAKE_OFF_HEIGHT = 2.0, 1.0  # s, m above the log's start
START_SPREAD = {"flight": 0.02, "drive": 0.03}  # m
RUN_DRAWS, SET_DRAWS = 0, 1


@dataclass(frozen=True)
class Case:
    """One data set with its truth.

    Args:
        robot: name.
        effects: key and values of each effect that the plant has; none for a null case.
        seed: of everything that is drawn; equal seeds give equal data.
        yaw: a quadrotor turns its heading all the time.
    """

    robot: str
    effects: tuple[tuple[str, Mapping[str, float]], ...] = ()
    seed: int = 0
    yaw: bool = False

    @property
    def keys(self) -> tuple[str, ...]:
        """The true effects."""
        return tuple(key for key, _ in self.effects)

    @property
    def name(self) -> str:
        """One line that tells cases apart."""
        shown = [f"{key}({', '.join(f'{n}={v:.4g}' for n, v in values.items())})" for key, values in self.effects]
        return " ".join([self.robot, " + ".join(shown) or "null", *(["yaw"] if self.yaw else []), f"#{self.seed}"])


def simulate_case(case: Case, trajectories: int = 8, rows: int = 400, robot: Robot | None = None) -> Dataset:
    """The data of a case, as a log would hold it: measured states, sent commands, references in ``ref_…``.

    Args:
        case: what is simulated.
        trajectories: number of runs; the table of references is gone through again after eight.
        rows: of a run; fewer where it ends in a crash.
        robot: in place of the registered one, with another control period.

    Raises:
        UnknownNameError: for a robot or an effect that does not exist.
    """
    robot = ROBOTS[case.robot] if robot is None else robot
    shared = standard_trim.unknown(robot, np.random.default_rng([case.seed, SET_DRAWS]))
    changes = tuple(effect(key, robot).inject(**values) for key, values in case.effects)

    def plant(rng: np.random.Generator) -> MujocoPlant:
        trim = standard_trim.trim(robot, rng)
        return MujocoPlant(
            unlimited(robot),
            (shared, *changes, *trim, standard_trim.disturbance(robot, rng), sensors(robot, rng)),
        )

    runs = (standard_run(robot, plant, case.seed, index, yaw=case.yaw, rows=rows) for index in range(trajectories))
    return Dataset(list(runs))


def standard_run(
    robot: Robot,
    plant_of: Callable[[np.random.Generator], Plant],
    seed: int,
    index: int,
    *,
    yaw: bool = False,
    rows: int = 400,
) -> Trajectory:
    """One flight or drive of the table on any plant, MuJoCo's or another simulator's.

    Args:
        robot: whose nominal numbers the controller knows.
        plant_of: makes the plant from the run's own generator of random numbers.
        seed: of the data set.
        index: of the run: row of the table of references, and part of its seed.
        yaw: a quadrotor turns its heading all the time.
        rows: of the run; fewer where it ends in a crash.

    Raises:
        ModelError: when a quadrotor crashes before the log starts.
    """
    rng = np.random.default_rng([seed, RUN_DRAWS, index])
    reference = _reference(robot, index, yaw, rng)
    plant = plant_of(rng)
    wanted = reference(robot.dt * torch.arange(rows, dtype=torch.float64)).numpy()
    start = wanted[0].copy()
    controller = _controller(robot, plant, reference, wanted)
    place = robot.layouts.state.slice("position")
    start[place] += rng.uniform(-1, 1, place.stop - place.start) * START_SPREAD[motion(robot)]
    sent = dithered(controller, robot, rng)
    task = Task("standard", reference, tracking_cost(robot), lambda _: start, rows * robot.dt)
    run = run_episode(plant, sent, task, steps=rows, name=f"run_{index + 1}")
    if isinstance(controller, AtItsPace):
        columns = zip(robot.layouts.state, controller.wanted(len(run)).T, strict=True)
        run = replace(run, extra={f"ref_{column}": values for column, values in columns})
    return run


def _reference(robot: Robot, index: int, yaw: bool, rng: np.random.Generator) -> Reference:
    phase = rng.uniform(0.0, 2.0 * np.pi)
    turning = rng.choice([-1.0, 1.0]) * rng.uniform(*YAW_RATES)
    table = FLIGHTS if flies(robot) else DRIVES
    return path_of(robot, table[index % len(table)], phase, float(turning) if yaw else 0.0)


def _controller(robot: Robot, plant: Plant, reference: Reference, wanted: Array) -> Controller:
    if flies(robot):
        inner = GeometricQuadrotor(robot.mass, robot.low, robot.high, robot.dt, reference, gains=GAINS)
        return LevelFlight(inner, wanted[:, 2], _trimmed(plant, inner, wanted[0]))
    return AtItsPace(robot, reference)


@dataclass
class LevelFlight(Memoryless):
    """Geometric flight whose thrust also holds the height in the mean.

    The integral outlives a reset, as it does on a robot between take-off and the start of a log.

    Args:
        inner: the controller.
        heights: wanted, by step, in m ``# (steps,)``.
        missing: the integral in m s.
    """

    inner: GeometricQuadrotor
    heights: Array
    missing: float = 0.0

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """The inner controller's action with the integral's thrust, within the limits ``# (4,)``."""
        self.missing += self.inner.dt * float(self.heights[step] - np.asarray(state)[2])
        action = self.inner.act(state, step, inputs)
        action[0] += self.inner.mass * INTEGRAL * self.missing
        return np.clip(action, self.inner.low, self.inner.high)


def _trimmed(plant: Plant, inner: GeometricQuadrotor, start: Array) -> float:
    """Integral of the height after hovering well above the start, with the plant left as it was found."""
    above = torch.from_numpy(start.copy())
    above[2] += TAKE_OFF_HEIGHT
    above[7:] = 0.0
    steps = round(TAKE_OFF / plant.dt)
    still = replace(inner, reference=lambda time: above.expand(*time.shape, -1))
    hover = LevelFlight(still, np.full(steps, float(above[2])))
    rows = len(run_episode(plant, hover, start=above.numpy(), steps=steps))
    if plant.crashed:
        raise ModelError(f"the robot crashed in take-off after {rows} rows: the effects are too strong to fly")
    return hover.missing
