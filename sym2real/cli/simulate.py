"""``sym2real simulate``: flights and drives in the simulator, without a model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from rich.console import Console

from sym2real.cli.numbers import NotNegative, OptionalSeconds, Seed, steps_in
from sym2real.cli.positionals import JsonFile, RobotPlace, TaskName, TaskOptions
from sym2real.errors import ModelError

if TYPE_CHECKING:
    from sym2real.plants import MujocoPlant


@dataclass(frozen=True)
class Simulate:
    """Fly or drive a task in the robot's simulator with a controller that needs no model, and write the log.

    The simulator is plain unless it is given effects, which MuJoCo's own means put into it, or is one that `diagnose`
    or `add` has written. Its states are exact unless there is --noise, without which a log is not fit for a diagnosis:
    errors of any size then count.

    For example:
      sym2real simulate crazyflie circle --noise --effects wind fx=0.01 added_mass value=0.003 --out windy.csv
      sym2real simulate runs/diagnosis/simulator circle --noise --out as_found.csv
      sym2real simulate runs/arm regulate q1=0.8 q2=-0.4 --dither 1 --noise --out swing.csv
    """

    OUT_IS_FILE: ClassVar[bool] = True
    OUT_IS_LOG: ClassVar[bool] = True

    robot: RobotPlace
    """Name of the robot (crazyflie, mushr, arm, cart_pole, …), the folder of a simulator, or that of a model for the
    plain robot that it is of."""
    task: TaskName
    """hover, circle, lemniscate, track, park, reverse_circle or, of any robot, regulate."""
    out: Path
    """The log to write, .csv or .parquet."""
    options: TaskOptions = ()
    controller: Literal["geometric", "random"] = "geometric"
    """Geometric tracking (of joints a linear-quadratic regulator), or the random commands that Stage I starts with."""
    seconds: OptionalSeconds = None
    """Length of the episode; the task's own by default."""
    effects: tuple[str, ...] = ()
    """Physical effects in it: each KIND or KIND:COLUMN, then its PARAMETER=VALUE (`sym2real effects` lists them)."""
    noise: bool = False
    """Sensor noise: position 0.5 mm, attitude 0.3°, rates 0.02 rad/s, velocity by differences of measured positions;
    joints 0.5 mm or 0.001 rad, their rates by differences."""
    dither: NotNegative = 0.0
    """Noise on the commands, as of `plan`: 1 is thrust 5 mN and rates 0.15 rad/s, or steering 0.03 rad and speed
    0.1 m/s; of other robots a fiftieth of the commands' range."""
    seed: Seed = 0
    """Of a car's start, random commands, dither and noise; a quadrotor's flight without these has nothing random."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Fly, print the figures, write the log."""
        import numpy as np

        from sym2real.adaptation import tracking_error
        from sym2real.cli.chosen import chosen_task
        from sym2real.cli.output import crash_of
        from sym2real.control import RandomCommands, geometric_controller
        from sym2real.experiments.excitation import dithered
        from sym2real.layout import unit_of_place
        from sym2real.logs import write_log
        from sym2real.plants import run_episode

        plant = self._plant(console)
        robot = plant.robot
        task = chosen_task(self.task, self.options, robot)
        geometric = self.controller == "geometric"
        controller = geometric_controller(robot, task.reference) if geometric else RandomCommands(robot, seed=self.seed)
        if self.dither:
            controller = dithered(controller, robot, np.random.default_rng(self.seed).spawn(2)[1], self.dither)
        steps = steps_in(self.seconds or task.duration, robot.dt)
        try:
            trajectory = run_episode(plant, controller, task, seed=self.seed, steps=steps, name=self.out.stem)
        except ModelError as failed:
            raise ModelError(f"{self.robot}: {failed}") from failed
        write_log(trajectory, self.out)
        error = tracking_error(trajectory)
        crashed = len(trajectory) < steps
        ended = f"{crash_of(plant, trajectory)}, " if crashed else ""
        unit = unit_of_place(robot.layouts.state)
        names = ", ".join(change.name for change in plant.changes) or "the plain simulator"
        console.print(
            f"{len(trajectory)} rows, {ended}mean error {error:.3g} {unit}, {names}; log in {self.out}",
            markup=False,
        )
        return {"log": self.out, "rows": len(trajectory), "tracking": error, "crashed": crashed}

    def _plant(self, console: Console) -> MujocoPlant:
        """The simulator, with effects and noise."""
        import numpy as np

        from sym2real.cli.chosen import chosen_effects, require_values, warn_of_values
        from sym2real.experiments.models import simulator_called
        from sym2real.experiments.standard_conditions import sensors
        from sym2real.plants import MujocoPlant
        from sym2real.plants.plant_file import PLANT

        plant = simulator_called(self.robot)
        robot = plant.robot
        effects = chosen_effects(self.effects, robot)
        require_values(effects)
        warn_of_values(effects, console)
        if effects and (Path(self.robot) / PLANT).exists():
            raise ModelError(f"{self.robot}: --effects are for a robot's plain simulator; add them to its {PLANT}")
        if effects:
            plant = MujocoPlant(robot, [chosen.inject(**values) for chosen, values in effects])
        if not self.noise:
            return plant
        noise = sensors(robot, np.random.default_rng(self.seed).spawn(1)[0])
        # Before the effects: a scale or a bias of a sensor's acts on what it measures.
        return MujocoPlant(robot, (noise, *plant.changes), description=plant.description)
