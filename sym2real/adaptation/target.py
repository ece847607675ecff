"""Where the logs of an adaptation come from: episodes in a plant, or recordings in the order of their making."""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np

from sym2real.adaptation.episode_report import episode_cost, episode_error, position_errors
from sym2real.adaptation.progress import OnProgress, Progress
from sym2real.dataset import Dataset
from sym2real.layout import Layouts
from sym2real.logs.equal_steps import without_holes
from sym2real.neural.model_folder import Model
from sym2real.plants import run_episode
from sym2real.protocols import Controller, Plant
from sym2real.robots import Robot
from sym2real.tasks import Task
from sym2real.tasks.task import digest_of_reference
from sym2real.trajectory import Array


class MakeController(Protocol):
    """Makes the controller that flies a model."""

    def __call__(self, model: Model, robot: Robot, task: Task, *, samples: int | None, seed: int) -> Controller:
        """A controller; samples None for the robot's own number."""


@dataclass(frozen=True)
class Flights:
    """Episodes in a plant, all from one start, so that they can be compared row by row.

    Args:
        plant: the target.
        robot: that it is.
        task: what is wanted.
        steps: control steps an episode at most.
        samples: of MPPI; the robot's own number by default.
        seed: of the start; with a round's number, of MPPI's noise and of the plant.
        on_progress: told of every step.
        controller: makes what flies a model.
    """

    plant: Plant
    robot: Robot
    task: Task
    steps: int
    samples: int | None
    seed: int
    on_progress: OnProgress
    controller: MakeController

    logs = math.inf
    recorded = False

    @property
    def layouts(self) -> Layouts:
        """The plant's columns."""
        return self.plant.layouts

    @property
    def dt(self) -> float:
        """The plant's time step in s."""
        return self.plant.dt

    @property
    def about(self) -> dict[str, Any]:
        """Robot, task with its reference, what the plant is, and how episodes are flown."""
        changes = [change.name for change in getattr(self.plant, "changes", ())]
        description = hashlib.sha256((getattr(self.plant, "description", None) or "").encode()).hexdigest()
        return {
            "robot": self.robot.name,
            "task": self.task.name,
            "reference": digest_of_reference(self.task),
            "changes": changes,
            "description": description,
            "steps": self.steps,
            "samples": self.samples,
            **getattr(self.plant, "about", {}),
        }

    def log(self, number: int, model: Model) -> Dataset:
        """An episode with MPPI and this model; of a robot that missed periods or poses, without these holes."""
        draw = np.random.default_rng([self.seed, number])
        seeds = draw.integers(2**31, size=2).tolist()
        controller = self.controller(model, self.robot, self.task, samples=self.samples, seed=seeds[0])
        what = f"round {number}: {self.task.name} in the target"
        episode = run_episode(
            self.plant,
            controller,
            self.task,
            seed=seeds[1],
            start=self.task.start(np.random.default_rng(self.seed)),
            steps=self.steps,
            on_step=lambda step, *_: self.on_progress(Progress(what, step + 1, self.steps)),
            name=f"round_{number:02d}",
        )
        # A robot lands before training takes the processor from its pilot, and refuses what no model has ended.
        getattr(self.plant, "end_episode", lambda: None)()
        return Dataset([without_holes(episode, self.plant.dt)])

    def judged(self, log: Dataset) -> tuple[bool, float, float]:
        """A crash ends an episode; position error and cost count the rows that it has taken."""
        episode = log[0]
        return (
            len(episode) < self.steps,
            episode_error(episode, self.robot, self.steps),
            episode_cost(episode, self.task, self.robot, self.steps),
        )


@dataclass(frozen=True)
class Recordings:
    """Recorded logs in the order in which they were made; nothing flies.

    Args:
        recordings: one a round, each of one piece or, where it has gaps, of several.
    """

    recordings: Sequence[Dataset]

    recorded = True

    @property
    def layouts(self) -> Layouts:
        """Columns of the first recording, which all others share."""
        return self.recordings[0].layouts

    @property
    def dt(self) -> float:
        """Median time step in s over the recordings."""
        return float(np.nanmedian([recording.dt for recording in self.recordings]))

    @property
    def logs(self) -> float:
        """How many there are."""
        return len(self.recordings)

    @property
    def about(self) -> dict[str, Any]:
        """The logs by name, and a digest of what they hold."""
        digest, pieces = hashlib.sha256(), [piece for recording in self.recordings for piece in recording]
        for piece in pieces:
            digest.update(piece.state.tobytes() + piece.action.tobytes() + piece.inputs.tobytes())
        return {"logs": [piece.name for piece in pieces], "content": digest.hexdigest()}

    def log(self, number: int, model: Model) -> Dataset:
        """The recording of that number, whatever the model."""
        return self.recordings[number]

    def judged(self, log: Dataset) -> tuple[bool, float, float]:
        """The position error where the log holds a reference; crashes and costs are not known."""
        errors = reference_errors(log)
        return False, float(errors.mean()) if len(errors) else math.nan, math.nan


Target: TypeAlias = Flights | Recordings


def reference_errors(log: Dataset) -> Array:
    """Distance in m from the reference, row by row ``# (rows,)``; none of pieces without."""
    first = f"ref_{log.layouts.state.placing[0].columns[0]}"
    return np.concatenate([np.empty(0), *(position_errors(piece) for piece in log if first in piece.extra)])
