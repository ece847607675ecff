"""``sym2real demo``: the whole path on both robots, and what a model is missing in simulated and real flights."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from sym2real.cli.numbers import OptionalSamples, Seed
from sym2real.cli.positionals import JsonFile
from sym2real.cli.terminal import Report

if TYPE_CHECKING:
    from sym2real.symbolic import Equations

SHOWN = ("crazyflie", "mushr")
STEPS = 400
SECONDS = 5.0


@dataclass(frozen=True)
class Demo:
    """Learn, fly, compare, diagnose: both robots from their description files, then what a model is missing.

    The last two acts are the package's main story, on simulated flights with an effect that the seed draws and on a
    real flight. Everything that is printed is also written under OUT: models, logs (CSV), figures (PNG).
    """

    out: Path = Path("runs/demo")
    """Folder for models, logs and figures."""
    samples: OptionalSamples = None
    seed: Seed = 0
    """Of starts, commands, disturbances and samples."""
    json: JsonFile = None

    def run(self, console: Report) -> dict[str, Any]:
        """Run the four acts."""
        from sym2real.cli.story import Story

        started = time.perf_counter()
        robots = {}
        for name in SHOWN:
            robots[name] = self._robot(name, console)
            console.release()  # what an act says stands beside files that are written
        story = Story(self.out, self.samples, self.seed, SECONDS)
        hidden = story.simulated(self.out / "crazyflie" / "model", console)
        console.release()
        real = story.real(console)
        seconds = time.perf_counter() - started
        console.print(f"\neverything is in {self.out}; {seconds:.0f} s", markup=False)
        return {"robots": robots, "hidden_effect": hidden, "real_flight": real, "seconds": seconds}

    def _robot(self, name: str, console: Console) -> dict[str, Any]:
        from sym2real.adaptation import StageOne
        from sym2real.cli.progress import stage_one_progress
        from sym2real.experiments.learning import learn_in_simulation
        from sym2real.report.tables import dependence_table, equation_table
        from sym2real.robots import ROBOTS

        robot = ROBOTS[name]
        console.rule(f"{robot.title}: from description file to equations")
        settings = StageOne(robot.recipe.episodes, STEPS, samples=self.samples, until_settled=False, seed=self.seed)
        folder = self.out / name / "model"
        with stage_one_progress() as on_progress:
            learned = learn_in_simulation(robot, "beam", settings, folder / "episodes", on_progress)
        learned.save(folder)
        console.print(equation_table(learned.equations), dependence_table(learned.dependence))
        flights = self._fly(name, learned.equations, console)
        return {"model": folder, "nodes": learned.equations.complexity(), "flights": flights}

    def _fly(self, name: str, equations: Equations, console: Console) -> list[dict[str, Any]]:
        from sym2real.cli.progress import steps_progress
        from sym2real.cli.run import flight_result, write_flight
        from sym2real.control import mppi_controller
        from sym2real.experiments.flying import fly
        from sym2real.plants import MujocoPlant
        from sym2real.report.tables import flight_table
        from sym2real.robots import ROBOTS
        from sym2real.tasks import make_task

        robot, flights = ROBOTS[name], []
        for task_name in dict.fromkeys(task for task, _ in robot.recipe.tasks):
            task = make_task(task_name, robot)
            controller = mppi_controller(equations, robot, task, samples=self.samples, seed=self.seed)
            with steps_progress(f"flying {task_name}", round(SECONDS / robot.dt)) as on_step:
                plant = MujocoPlant(robot)
                flights.append(
                    fly(plant, controller, task, seconds=SECONDS, seed=self.seed, on_step=on_step, name=task_name)
                )
        console.print(flight_table(flights))
        return [flight_result(flight) | write_flight(flight, self.out / name) for flight in flights]
