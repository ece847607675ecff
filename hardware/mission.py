"""A run from the command line: check, go to the start, the task with MPPI, stop, the record, the comparison.

A robot's launch script adds its link, its checks and its pilot.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import tyro
from rich.console import Console

from hardware.checks import Check, connected
from hardware.clock import SystemClock
from hardware.errors import LinkError
from hardware.interfaces import Pilot, Reading, RobotLink
from hardware.plant import HardwarePlant
from hardware.provenance import hash_of, revision
from hardware.recorder import Recorder, task_of
from sym2real.cli.places import Place
from sym2real.errors import DataError, ModelError
from sym2real.layout import Layouts
from sym2real.protocols import Controller
from sym2real.robots import Robot
from sym2real.tasks import Task, make_task

if TYPE_CHECKING:
    from sym2real.neural import Model

OBSERVED = 2.0  # s at rest before anything moves
PLANNED = 2.0  # s of a dry run
WARM = 30  # actions before arming: the first ones compile and fill caches


def require_columns(model: str, found: Layouts, wanted: Layouts) -> None:
    """Refuse a model whose states or commands are not the robot's, before anything warms up or arms.

    Args:
        model: as the user names it.
        found: its layouts; hidden states count for nothing.
        wanted: the robot's.

    Raises:
        ModelError: with both groups of columns.
    """
    seen = [name for field in found.state.fields if not field.hidden for name in field.columns]
    for group, columns, needed in (
        ("state", seen, wanted.state.columns),
        ("commands", found.action.columns, wanted.action.columns),
    ):
        if set(columns) != set(needed):
            raise ModelError(
                f"{model}: expected a model with the {group} {' '.join(needed)}, found {' '.join(columns)}"
            )


@dataclass(frozen=True)
class Mission(ABC):
    """One task of one robot; a script's options are these and its own."""

    RECORD: ClassVar[str]
    GOING: ClassVar[str]  # in words, before the task
    STOPPING: ClassVar[str]  # and behind it

    model: tyro.conf.Positional[Place]
    """A model folder, or a robot's name (its base is learned once and cached)."""
    task: tyro.conf.Positional[str]
    """Name of the task."""
    out: Path
    """New folder for the record, the task's log and the comparison."""
    seconds: float | None = None
    """Length of the task; its own by default."""
    samples: int | None = None
    """MPPI samples; the robot's own number by default, and fewer where this machine cannot hold the period."""
    seed: int = 0
    """Of the samples and of where the task starts."""
    dry_run: bool = False
    """Everything but arming and sending: MPPI plans for the robot where it stands."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    @property
    @abstractmethod
    def robot(self) -> Robot:
        """What is flown or driven, with the limits of its commands."""

    @abstractmethod
    def link(self, task: Task) -> AbstractContextManager[RobotLink]:
        """A link that is not yet connected, closed in the end."""

    @abstractmethod
    def checks(self, readings: Sequence[Reading]) -> list[Check]:
        """Judge what was observed at rest."""

    @abstractmethod
    def pilot(self) -> Pilot:
        """What may pass."""

    @abstractmethod
    def settings(self) -> dict[str, Any]:
        """What the record says of the pilot: numbers, texts, lists and dictionaries of them."""

    def run(self, console: Console) -> dict[str, Any]:
        """Check, go, stop, compare."""
        model = self._opened()
        task = make_task(self.task, self.robot)
        controller = self._controller(model, task, console.print)
        with self.link(task) as link:
            if not all(check.holds for check in connected(link, self.checks, OBSERVED, console.print)):
                raise LinkError("the robot is not ready, as said above")
            if self.dry_run:
                return self._plan_only(link, controller, console.print)
            result = self._go(link, controller, task, console)
        return result | self._compare(model, console)

    def _opened(self) -> Model:
        from sym2real.cli.model import open_with_progress  # noqa: PLC0415 — SymPy takes a second to load
        from sym2real.neural.model_folder import below  # noqa: PLC0415

        model = open_with_progress(self.model)
        described = below(model).robot
        if described not in ("", self.robot.name):
            raise ModelError(f"{self.model} is of a {described}; this script is for a {self.robot.name}")
        require_columns(str(self.model), below(model).layouts, self.robot.layouts)
        if (self.out / self.RECORD).exists():
            raise DataError(self.out, "a new folder: no run is written over another", f"{self.RECORD} in it")
        return model

    def _controller(self, model: Model, task: Task, say: Callable[[str], None]) -> Controller:
        """MPPI, used before anything is armed: its first actions compile and take long."""
        from sym2real.control import mppi_controller  # noqa: PLC0415

        say("warming the controller up")
        robot = self.robot
        controller = mppi_controller(model, robot, task, samples=self.samples, seed=self.seed, period=robot.dt)
        nothing, taken = np.zeros(robot.layouts.inputs.size), []
        for step in range(WARM):
            start = time.perf_counter()
            controller.act(robot.start, step, nothing)
            taken.append(time.perf_counter() - start)
        say(f"an action of {controller.samples} samples takes {1000.0 * float(np.median(taken)):.1f} ms")
        controller.reset()
        return controller

    def _go(self, link: RobotLink, controller: Controller, task: Task, console: Console) -> dict[str, Any]:
        from sym2real.cli.numbers import steps_in  # noqa: PLC0415
        from sym2real.cli.progress import steps_progress  # noqa: PLC0415
        from sym2real.experiments.flying import fly  # noqa: PLC0415

        seconds, steps = self.seconds or task.duration, steps_in(self.seconds or task.duration, self.robot.dt)
        with (
            Recorder(self.out / self.RECORD, self.robot, self._about(link)) as recorder,
            HardwarePlant(link, self.pilot(), record=recorder.add) as plant,
        ):
            console.print(self.GOING)
            with steps_progress(self.task, steps) as on_step:
                flight = fly(plant, controller, task, seconds=seconds, seed=self.seed, on_step=on_step, name=self.task)
            console.print(f"ended: {plant.ended}" if flight.crashed else self.STOPPING)
            plant.land()
            missed = plant.missed
        console.print(f"mean position error {flight.tracking:.3g} m, {missed} periods missed; record in {self.out}")
        return {
            "tracking": flight.tracking,
            "final": flight.final,
            "ended": plant.ended,
            "completed": not flight.crashed,
            "missed": missed,
            "act_median": flight.act_median,
            "act_p99": flight.act_p99,
            "record": self.out / self.RECORD,
        }

    def _about(self, link: RobotLink) -> dict[str, Any]:
        from sym2real.cli.model import folder_of  # noqa: PLC0415

        about = {"task": self.task, "model": self.model, "model_sha256": hash_of(folder_of(self.model))}
        return about | {"revision": revision(), **link.about, **self.settings()}

    def _plan_only(self, link: RobotLink, controller: Controller, say: Callable[[str], None]) -> dict[str, Any]:
        """MPPI at its rate on what is measured; actions go nowhere."""
        dt, clock, nothing = self.robot.dt, SystemClock(), np.zeros(self.robot.layouts.inputs.size)
        taken, due = [], clock.now()
        for step in range(round(PLANNED / dt)):
            start = clock.now()
            wanted = controller.act(link.state().state, step, nothing)
            controller.remember(link.send(wanted))
            taken.append(clock.now() - start)
            due += dt
            clock.sleep_until(due)
        median = float(np.median(taken))
        say(f"dry run: an action in {1000.0 * median:.1f} ms; the last, not sent: {np.round(wanted, 3)}")
        return {"act_median": median, "act_p99": float(np.quantile(taken, 0.99)), "sent": 0}

    def _compare(self, model: Model, console: Console) -> dict[str, Any]:
        from sym2real.cli.model import logs_for  # noqa: PLC0415
        from sym2real.diagnosis import compare  # noqa: PLC0415
        from sym2real.logs import write_log  # noqa: PLC0415
        from sym2real.neural.composed import in_double  # noqa: PLC0415
        from sym2real.neural.model_folder import below  # noqa: PLC0415
        from sym2real.report.comparison import comparison_report  # noqa: PLC0415

        log = self.out / f"{self.task}.csv"
        write_log(task_of(self.out / self.RECORD, self.robot, self.task), log)
        comparison = compare(in_double(model), logs_for(below(model), (log,), None))
        console.print(comparison_report(comparison))
        console.print(f"the task's log is {log}: sym2real diagnose {self.model} {log}")
        return {"log": log, "comparison": comparison.to_dict()}


def listed(settings: dict[str, Any]) -> dict[str, Any]:
    """Settings with lists in the place of tuples, which YAML has no word for."""
    return {name: list(value) if isinstance(value, tuple) else value for name, value in settings.items()}
