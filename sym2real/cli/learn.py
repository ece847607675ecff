"""``sym2real learn``: a base model from a plain simulator, or from recorded logs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from rich.console import Console

from sym2real.cli.numbers import Count, OptionalCount, OptionalSamples, Seed, number_of
from sym2real.cli.of_logs import OfLogs
from sym2real.cli.positionals import JsonFile, RobotName
from sym2real.errors import ModelError, UnknownNameError

if TYPE_CHECKING:
    from sym2real.experiments.learning import Learned


@dataclass(frozen=True)
class Learn(OfLogs):
    """Learn a base model: one equation per next-state component.

    Without --data the robot is flown in its plain MuJoCo simulation (Stage I of the paper): random commands first,
    then MPPI with the equations found so far, one episode at a time. Every episode and fit is kept in OUT/episodes,
    so an interrupted run continues where it stopped. With --data recorded logs are fitted instead; on noisy logs the
    dependence table shows what gets lost, which is why the simulator comes first. Logs need no registered robot: a
    quadrotor has thrust and rate commands (N, rad/s), a car steer and speed, and the step is that of the logs.

    For example:
      sym2real learn crazyflie --out runs/base
      sym2real learn car --data drive1.csv drive2.csv --spec drive.toml --numbers mass=4.1 --out runs/car
    """

    FOLDERS: ClassVar = ("episodes",)

    robot: RobotName
    """Name of the robot (crazyflie, mushr, arm, …); of logs (--data) also quadrotor or car, of no known numbers."""
    out: Path
    """Folder of the model."""
    data: tuple[Path, ...] = ()
    """Recorded logs (CSV, Parquet, bags, MCAP, ULog) to fit instead of a simulator."""
    numbers: tuple[str, ...] = ()
    """Numbers of the robot that --data was measured on, NAME=VALUE in SI units (mass=0.032); else the registered.
    Effects that act by them need them: a centre of mass that is off is tested where jx, jy and jz are known."""
    engine: str = "beam"
    """Search engine: beam (built in), operon or pysr (extras)."""
    episodes: OptionalCount = None
    """At most so many episodes; by default 10 for a quadrotor and 20 for a car, fewer when nothing gets better. Of a
    robot of joints or of wheels on one axle the base is its first-principles equations unless this is given."""
    steps: Count = 400
    """Control steps an episode at most."""
    samples: OptionalSamples = None
    wrench: bool = True
    """Learn how external forces and torques enter, from as many episodes again with known disturbances."""
    seed: Seed = 0
    """Of starts, commands, disturbances and samples."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Learn, print the tables, write the model."""
        from sym2real.report.tables import dependence_table, episode_table, equation_table

        if self.numbers and not self.data:
            raise ModelError("--numbers: expected --data with it, found none: the plain simulator has its own numbers")
        learned = self._from_logs() if self.data else self._in_simulation(console)
        learned.save(self.out)
        if learned.reports:
            console.print(episode_table(learned.reports))
        console.print(equation_table(learned.equations), dependence_table(learned.dependence))
        console.print(f"model in {self.out}", markup=False)
        missing = [f"{row.action} → {row.state}" for row in learned.dependence if not row.holds]
        if missing:
            instead = (
                "learn from the plain simulator instead of recorded logs"
                if learned.equations.robot
                else f"logs with more varied commands, or `sym2real nominal {self.robot} --help` from numbers alone"
            )
            raise ModelError(
                f"the model in {self.out} cannot fly: expected every action to reach its states, found nothing of "
                f"{', '.join(missing)} in the equations; {instead}"
            )
        return {
            "model": self.out,
            "nodes": learned.equations.complexity(),
            "episodes": learned.reports,
            "dependence": learned.dependence,
        }

    def _from_logs(self) -> Learned:
        """Equations fitted to the logs of a robot, with the numbers that were typed.

        Raises:
            UnknownNameError: for a number that such a robot does not have.
            ModelError: for what is not NAME=VALUE with a finite value.
        """
        from sym2real.cli.progress import stages_progress
        from sym2real.experiments.learning import learn_from_logs
        from sym2real.experiments.measured import measured

        robot, numbers = measured(self.robot), {}
        for typed in self.numbers:
            name, _, value = typed.partition("=")
            if name not in robot.like.numbers:
                raise UnknownNameError(f"number of {self.robot}", name, robot.like.numbers)
            numbers[name] = number_of(value)
            if not math.isfinite(numbers[name]):
                raise ModelError(f"--numbers: expected {name}=VALUE with a finite number, found {typed!r}")
        with stages_progress() as on_progress:
            return learn_from_logs(robot, self.data, self.naming, self.engine, numbers=numbers, on_progress=on_progress)

    def _in_simulation(self, console: Console) -> Learned:
        """The base of a robot that has a simulator.

        Raises:
            ModelError: when it is known by its logs alone.
            UnknownNameError: when there is none of that name.
        """
        from sym2real.adaptation import StageOne
        from sym2real.cli.progress import stage_one_progress
        from sym2real.experiments.learning import from_description, learn_in_simulation
        from sym2real.experiments.measured import LIKE
        from sym2real.robots import ROBOTS

        if self.robot in LIKE:
            raise ModelError(
                f"any {self.robot} has no simulator: expected --data LOGS with it, or a robot that has one "
                f"({', '.join(ROBOTS)}); `sym2real nominal {self.robot} --help` starts from numbers alone"
            )
        robot = ROBOTS[self.robot]
        if robot.recipe.base == "nominal" and self.episodes is None:
            console.print("its base is its first-principles equations; --episodes N learns one by regression instead")
            return from_description(robot)
        settings = StageOne(
            episodes=self.episodes or robot.recipe.most_episodes,
            steps=self.steps,
            samples=self.samples,
            pushed=self.wrench,
            until_settled=self.episodes is None,
            seed=self.seed,
        )
        with stage_one_progress() as on_progress:
            return learn_in_simulation(robot, self.engine, settings, self.out / "episodes", on_progress)
