"""A task with MPPI and a model on a robot: check, go to the start, fly or drive, stop; then compare with the model.

For example:
  python -m hardware.run crazyflie runs/base hover --sim --out runs/hover_1
  python -m hardware.run crazyflie runs/base circle --thrust-map 2026.04 --out runs/circle_1
  python -m hardware.run mushr runs/base park --master http://192.168.1.3:11311 --out runs/park_1
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Generic

import numpy as np
import tyro
from rich.console import Console

from hardware.checks import require_ready
from hardware.clock import SystemClock
from hardware.command_line import main
from hardware.controller import require_model_of, warm_controller
from hardware.interfaces import RobotLink
from hardware.laboratory import Say
from hardware.plant import HardwarePlant
from hardware.provenance import about_run
from hardware.recorder import Recorder, task_of
from hardware.robots import Kind, of_every_robot
from sym2real.cli.numbers import OptionalSamples, OptionalSeconds, Seed, steps_in
from sym2real.cli.positionals import ModelPlace, TaskName
from sym2real.errors import DataError
from sym2real.protocols import Controller
from sym2real.tasks import Task, make_task

if TYPE_CHECKING:
    from sym2real.neural import Model

PLANNED = 2.0  # s of a dry run


@dataclass(frozen=True)
class Run(Generic[Kind]):
    """Fly or drive a task with MPPI and a model: check, go to the start, task, stop; then compare with the model.

    Ctrl-C lands or brakes, a second one stops the motors at once; a car drives while its button for autonomy is held.
    The folder holds the record of the run, that is flight.parquet or drive.parquet and a .yaml beside it, and the part
    that MPPI flew or drove, TASK.csv, which sym2real's compare and diagnose take.
    """

    model: ModelPlace
    task: TaskName
    """hover, circle or lemniscate; of a car circle, reverse_circle, lemniscate, track or park."""
    out: Path
    """New folder for the record, the task's log and the comparison."""
    laboratory: Annotated[Kind, tyro.conf.arg(name="")]
    """The robot and what sees it."""
    seconds: OptionalSeconds = None
    """Length of the task; its own by default."""
    samples: OptionalSamples = None
    """MPPI samples; the robot's own number by default, and fewer where this machine cannot hold the period."""
    seed: Seed = 0
    """Of the samples and of where the task starts."""
    dry_run: bool = False
    """Everything but arming and sending: MPPI plans for the robot where it stands."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    @property
    def record(self) -> Path:
        """Where every control period is written to."""
        return self.out / self.laboratory.RECORD

    def run(self, console: Console) -> dict[str, Any]:
        """Check, go, stop, compare."""
        from sym2real.cli.model import open_with_progress  # noqa: PLC0415 — SymPy takes a second to load

        robot, say = self.laboratory.ROBOT, console.print
        model = open_with_progress(self.model)
        require_model_of(model, self.model, robot)
        if self.record.exists():
            raise DataError(self.out, "a new folder: no run is written over another", f"{self.record.name} in it")
        task = make_task(self.task, robot)
        with self.laboratory.open(task.start(np.random.default_rng(self.seed)), say, dry=self.dry_run) as opened:
            controller = warm_controller(model, robot, task, samples=self.samples, seed=self.seed, say=say)
            require_ready(opened.link, self.laboratory.checks, say)
            if self.dry_run:
                return self._plan_only(opened.link, controller, say)
            result = self._go(opened.link, controller, task, console)
        return result | self._compare(model, console)

    def _go(self, link: RobotLink, controller: Controller, task: Task, console: Console) -> dict[str, Any]:
        from sym2real.cli.progress import steps_progress  # noqa: PLC0415
        from sym2real.experiments.flying import fly  # noqa: PLC0415

        robot, seconds = self.laboratory.ROBOT, self.seconds or task.duration
        steps = steps_in(seconds, robot.dt)
        about = about_run(self.task, self.model, link, self.laboratory.about)
        with (
            Recorder(self.record, robot, about) as recorder,
            HardwarePlant(link, self.laboratory.pilot(), record=recorder.add) as plant,
        ):
            console.print(self.laboratory.GOING)
            with steps_progress(self.task, steps) as on_step:
                flight = fly(plant, controller, task, seconds=seconds, seed=self.seed, on_step=on_step, name=self.task)
            console.print(f"ended: {plant.ended}" if flight.crashed else self.laboratory.STOPPING)
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
            "record": self.record,
        }

    def _plan_only(self, link: RobotLink, controller: Controller, say: Say) -> dict[str, Any]:
        """MPPI at its rate on what is measured; actions go nowhere."""
        robot, clock = self.laboratory.ROBOT, SystemClock()
        nothing, taken, due = np.zeros(robot.layouts.inputs.size), [], clock.now()
        for step in range(round(PLANNED / robot.dt)):
            start = clock.now()
            wanted = controller.act(link.state().state, step, nothing)
            controller.remember(link.send(wanted))
            taken.append(clock.now() - start)
            due += robot.dt
            clock.sleep_until(due)
        median = float(np.median(taken))
        say(f"dry run: an action in {1000.0 * median:.1f} ms; the last, not sent: {np.round(wanted, 3)}")
        return {"act_median": median, "act_p99": float(np.quantile(taken, 0.99)), "sent": 0}

    def _compare(self, model: Model, console: Console) -> dict[str, Any]:
        from sym2real.cli.model import logs_for  # noqa: PLC0415
        from sym2real.diagnosis import compare  # noqa: PLC0415
        from sym2real.logs import write_log  # noqa: PLC0415
        from sym2real.neural.model_folder import below  # noqa: PLC0415
        from sym2real.report.comparison import comparison_report  # noqa: PLC0415

        log, trajectory = self.out / f"{self.task}.csv", task_of(self.record, self.laboratory.ROBOT, self.task)
        write_log(trajectory, log)
        comparison = compare(model, logs_for(below(model), (log,), None))
        console.print(comparison_report(comparison))
        console.print(f"the task's log is {log}: sym2real diagnose {self.model} {log}")
        return {"log": log, "comparison": comparison.to_dict()}


if __name__ == "__main__":
    main(of_every_robot(Run), "python -m hardware.run", __doc__)
