"""``python -m hardware.fly_crazyflie``: check, arm, take off, fly a task with MPPI, land, compare."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import tyro
from rich.console import Console

from hardware.checks import checks, observe, report
from hardware.clock import SystemClock
from hardware.command_line import main
from hardware.crazyflie.laboratory import Laboratory
from hardware.crazyflie.link import CrazyflieLink
from hardware.errors import LinkError
from hardware.pilot import FlightPilot
from hardware.plant import HardwarePlant
from hardware.provenance import hash_of, revision
from hardware.recorder import Recorder, task_of
from hardware.safety import Limits
from sym2real.cli.places import Place
from sym2real.errors import DataError, ModelError
from sym2real.protocols import Controller
from sym2real.robots import CRAZYFLIE
from sym2real.tasks import Task, make_task

if TYPE_CHECKING:
    from sym2real.neural import Model

RECORD = "flight.parquet"
REAL, LIMITS = Laboratory(), Limits()
OBSERVED = 2.0  # s on the ground before a take-off
WARM = 30  # actions before arming: the first ones compile and fill caches


@dataclass(frozen=True)
class FlyCrazyflie:
    """Fly a task with MPPI and a model on a Crazyflie: check, arm, take off, task, land; then compare with the model.

    Ctrl-C lands, a second one cuts the motors. The folder holds the record of the run (flight.parquet, flight.yaml) and
    the part that MPPI flew (TASK.csv), which `sym2real compare` and `diagnose` take.

    For example:
      python -m hardware.fly_crazyflie runs/base hover --sim --out runs/hover_1
      python -m hardware.fly_crazyflie runs/base circle --thrust-map 2026.04 --out runs/circle_1
    """

    model: tyro.conf.Positional[Place]
    """A model folder, or a robot's name (its base is learned once and cached)."""
    task: tyro.conf.Positional[str]
    """hover, circle or lemniscate."""
    out: Path
    """New folder for the record, the task's log and the comparison."""
    laboratory: tyro.conf.OmitArgPrefixes[Laboratory] = REAL
    """The robot and what sees it."""
    seconds: float | None = None
    """Length of the task; its own by default."""
    samples: int | None = None
    """MPPI samples; the robot's own number by default, and fewer where this machine cannot hold the period."""
    seed: int = 0
    """Of the samples."""
    limits: Limits = LIMITS
    """When the flight ends: the fence, ages, battery, tilt."""
    dry_run: bool = False
    """Everything but arming and sending: MPPI plans for the robot where it stands."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    def run(self, console: Console) -> dict[str, Any]:
        """Fly, land, compare."""
        from sym2real.cli.model import open_with_progress  # noqa: PLC0415 — SymPy takes a second to load
        from sym2real.experiments.models import below  # noqa: PLC0415

        model = open_with_progress(self.model)
        robot = below(model).robot
        if robot not in ("", CRAZYFLIE.name):
            raise ModelError(f"{self.model} is of a {robot}; this script flies a {CRAZYFLIE.name}")
        if (self.out / RECORD).exists():
            raise DataError(self.out, "a new folder: no flight is written over another", f"{RECORD} in it")
        task = make_task(self.task, CRAZYFLIE)
        controller = self._controller(model, task, console.print)
        with self.laboratory.link(dry=self.dry_run) as link:
            console.print("waiting for motion capture, the robot's tables and its first log packet")
            link.connect()
            console.print(f"connected: CRTP protocol {link.connection.protocol}; measuring for {OBSERVED:g} s")
            if not report(checks(observe(link, SystemClock(), OBSERVED), self.limits), console.print):
                raise LinkError("the robot is not ready to fly, as said above")
            if self.dry_run:
                return self._plan_only(link, controller, console.print)
            result = self._fly(link, controller, task, console)
        return result | self._compare(model, console)

    def _controller(self, model: Model, task: Task, say: Callable[[str], None]) -> Controller:
        """MPPI, used before anything is armed: its first actions compile and take long."""
        from sym2real.control import mppi_controller  # noqa: PLC0415

        say("warming the controller up")
        controller = mppi_controller(model, CRAZYFLIE, task, samples=self.samples, seed=self.seed, period=CRAZYFLIE.dt)
        nothing, taken = np.zeros(CRAZYFLIE.layouts.inputs.size), []
        for step in range(WARM):
            start = time.perf_counter()
            controller.act(CRAZYFLIE.start, step, nothing)
            taken.append(time.perf_counter() - start)
        say(f"an action of {controller.samples} samples takes {1000.0 * float(np.median(taken)):.1f} ms")
        controller.reset()
        return controller

    def _fly(self, link: CrazyflieLink, controller: Controller, task: Task, console: Console) -> dict[str, Any]:
        from sym2real.cli.numbers import steps_in  # noqa: PLC0415
        from sym2real.cli.progress import steps_progress  # noqa: PLC0415
        from sym2real.experiments.flying import fly  # noqa: PLC0415

        seconds, pilot = self.seconds or task.duration, FlightPilot(CRAZYFLIE, self.limits, self.laboratory.mass)
        with (
            Recorder(self.out / RECORD, CRAZYFLIE, self._about(link)) as recorder,
            HardwarePlant(link, pilot, record=recorder.add) as plant,
        ):
            console.print("arming, taking off, flying to the start")
            with steps_progress(self.task, steps_in(seconds, CRAZYFLIE.dt)) as on_step:
                flight = fly(plant, controller, task, seconds=seconds, on_step=on_step, name=self.task)
            console.print(f"landed: {plant.ended}" if flight.crashed else "landing")
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
            "record": self.out / RECORD,
        }

    def _about(self, link: CrazyflieLink) -> dict[str, Any]:
        from sym2real.cli.model import folder_of  # noqa: PLC0415

        about = {"task": self.task, "model": self.model, "model_sha256": hash_of(folder_of(self.model))}
        about |= {"revision": revision(), "uri": link.connection.uri, "route": link.route.name}
        said = {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self.limits).items()}
        mass = self.laboratory.mass or CRAZYFLIE.mass
        return about | {"thrust_map": asdict(link.thrust_map), "mass": mass, "limits": said}

    def _plan_only(
        self, link: CrazyflieLink, controller: Controller, say: Callable[[str], None], seconds: float = 2.0
    ) -> dict[str, Any]:
        """MPPI at its rate on what is measured; actions go nowhere."""
        clock, nothing = SystemClock(), np.zeros(CRAZYFLIE.layouts.inputs.size)
        taken, due = [], clock.now()
        for step in range(round(seconds / CRAZYFLIE.dt)):
            start = clock.now()
            wanted = controller.act(link.state().state, step, nothing)
            controller.remember(link.send(wanted))
            taken.append(clock.now() - start)
            due += CRAZYFLIE.dt
            clock.sleep_until(due)
        median = float(np.median(taken))
        say(f"dry run: an action in {1000.0 * median:.1f} ms; the last, not sent: {np.round(wanted, 3)}")
        return {"act_median": median, "act_p99": float(np.quantile(taken, 0.99)), "sent": 0}

    def _compare(self, model: Model, console: Console) -> dict[str, Any]:
        from sym2real.cli.model import logs_for  # noqa: PLC0415
        from sym2real.diagnosis import compare  # noqa: PLC0415
        from sym2real.experiments.models import below  # noqa: PLC0415
        from sym2real.logs import write_log  # noqa: PLC0415
        from sym2real.neural.composed import in_double  # noqa: PLC0415
        from sym2real.report.comparison import comparison_report  # noqa: PLC0415

        log = self.out / f"{self.task}.csv"
        write_log(task_of(self.out / RECORD, CRAZYFLIE, self.task), log)
        comparison = compare(in_double(model), logs_for(below(model), (log,), None))
        console.print(comparison_report(comparison))
        console.print(f"the task's log is {log}: sym2real diagnose {self.model} {log}")
        return {"log": log, "comparison": comparison.to_dict()}


if __name__ == "__main__":
    main(FlyCrazyflie, "python -m hardware.fly_crazyflie")
