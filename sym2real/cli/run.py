"""``sym2real run``: one task with one model on one plant."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from sym2real.cli.numbers import OptionalSamples, OptionalSeconds, Seed, steps_in
from sym2real.cli.places import Place
from sym2real.cli.positionals import JsonFile, ModelPlace, TaskName, TaskOptions
from sym2real.errors import ModelError, UnknownNameError

if TYPE_CHECKING:
    from sym2real.neural import Model
    from sym2real.plants import EquationsPlant, ModelPlant, MujocoPlant
    from sym2real.robots import Robot

# Plants that are no folders.
PLAIN = ("simulator", "model")


@dataclass(frozen=True)
class Run:
    """Fly or drive one task with MPPI and a model, in the robot's simulator or in the model itself.

    For example:
      sym2real run runs/base circle --out runs/circle
      sym2real run runs/found/model circle radius=0.4 --plant runs/found/simulator
    """

    model: ModelPlace
    task: TaskName
    """hover, circle, lemniscate, track, park, reverse_circle or, of any robot, regulate."""
    options: TaskOptions = ()
    plant: Place = "simulator"
    """What is flown: the plain MuJoCo simulator, the model itself ("model"), or the folder of a simulator, or of a
    model for the plain robot that it is of."""
    seconds: OptionalSeconds = None
    """Length of the episode; the task's own by default."""
    samples: OptionalSamples = None
    realtime: bool = False
    """Draw only as many samples as hold the control period on this machine."""
    seed: Seed = 0
    """Of the start and the samples."""
    out: Path | None = None
    """Folder for the log (CSV) and a figure of the path."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Fly, print the figures, write the log."""
        from sym2real.cli.chosen import chosen_task
        from sym2real.cli.model import open_with_progress
        from sym2real.cli.output import crash_of
        from sym2real.cli.progress import steps_progress
        from sym2real.control import mppi_controller
        from sym2real.experiments.flying import fly
        from sym2real.experiments.models import described_robot
        from sym2real.logs import write_log
        from sym2real.neural.model_folder import below
        from sym2real.report.figures import path_figure
        from sym2real.report.style import save
        from sym2real.report.tables import flight_table

        model = open_with_progress(self.model)
        robot = described_robot(below(model), self.model)
        plant = self._plant(model, robot)
        task = chosen_task(self.task, self.options, robot)
        period = robot.dt if self.realtime else None
        controller = mppi_controller(model, robot, task, samples=self.samples, seed=self.seed, period=period)
        steps = steps_in(self.seconds or task.duration, robot.dt)
        with steps_progress(f"{self.task} with {controller.samples} samples", steps) as on_step:
            flight = fly(plant, controller, task, seconds=self.seconds, seed=self.seed, on_step=on_step, name=self.task)
        console.print(flight_table(flight, self.plant if self.plant in PLAIN else f"simulator of {self.plant}"))
        if flight.crashed:
            console.print(crash_of(plant, flight.trajectory), markup=False)
        name = flight.trajectory.name
        judged = ("tracking", "final", "crashed", "act_median", "act_p99")
        result = {"task": name, **{part: getattr(flight, part) for part in judged}, "samples": controller.samples}
        if self.out:
            result["log"] = log = self.out / f"{name}.csv"
            write_log(flight.trajectory, log)
            result["figure"] = save(path_figure(flight.trajectory), self.out, name)
            console.print(f"log in {log}, path in {result['figure']}", markup=False)
        return result

    def _plant(self, model: Model, robot: Robot) -> MujocoPlant | EquationsPlant | ModelPlant:
        """What is flown.

        Raises:
            ModelError: for another robot's, or for one that cannot give what the model needs.
            UnknownNameError: when there is none of that name.
        """
        from sym2real.effects.inputs import TIME
        from sym2real.experiments.models import target_called
        from sym2real.neural.model_folder import below
        from sym2real.plants import EquationsPlant, ModelPlant, MujocoPlant
        from sym2real.symbolic import Equations

        base = below(model)
        missing = [name for name in base.layouts.inputs if name != TIME and name not in robot.layouts.inputs]
        if missing:
            raise ModelError(f"{self.model}: no simulator gives {', '.join(missing)}, which the model uses as an input")
        if self.plant == "simulator":
            return MujocoPlant(robot)
        if self.plant == "model":
            if isinstance(model, Equations):
                return EquationsPlant(model, robot)
            if isinstance(base, Equations) and (base.filters or base.output or base.start):
                raise ModelError(
                    f"--plant model: {self.model} has a residual, and delays, sensors or hidden states below it that a "
                    "model as a plant would start anew with every step; fly it in the simulator"
                )
            return ModelPlant(model, robot)
        if not Path(self.plant).is_dir():
            raise UnknownNameError("plant: neither a folder nor", self.plant, PLAIN)
        return target_called(self.plant, robot)
