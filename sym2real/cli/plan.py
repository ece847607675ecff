"""``sym2real plan``: what a manoeuvre can show, before it is flown or driven."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro
from rich.console import Console

from sym2real.cli.numbers import NotNegative, Seconds, steps_in
from sym2real.cli.of_logs import OfLogs
from sym2real.cli.places import Place, there
from sym2real.cli.positionals import JsonFile

if TYPE_CHECKING:
    from sym2real.dataset import Dataset
    from sym2real.diagnosis import AssumedNoise
    from sym2real.robots import Robot


@dataclass(frozen=True)
class PlanFlight(OfLogs):
    """Say what a planned manoeuvre can show: the smallest effect of each kind, and which it cannot tell apart.

    Manoeuvres are flown or driven in the plain simulator of MODEL's robot: hover, circle or eight (cars: circle or
    eight), each followed by its size= and speed= (m, m/s), height= and swing= (m), modulation= (part of the speed) or
    clockwise=1; of joints regulate, followed by their goals (m, rad). With logs, what was flown is judged, with the
    noise that the logs have.

    For example:
      sym2real plan crazyflie hover
      sym2real plan crazyflie hover circle size=0.5 speed=1 eight --yaw-rate 0.6 --seconds 10
      sym2real plan mushr circle speed=1 circle speed=1 clockwise=1
      sym2real plan runs/arm regulate q1=0.8 q2=-0.4 regulate q1=-0.8
      sym2real plan runs/nominal flight1.csv flight2.csv --spec flight.toml
    """

    model: Annotated[
        Place,
        tyro.conf.Positional,
        tyro.conf.arg(metavar="MODEL", help="A model folder, or a robot's name for its first-principles equations."),
    ]
    what: tyro.conf.Positional[tuple[Place, ...]]
    """Manoeuvres, the robot's usual ones by default; or logs."""
    seconds: Seconds = 8.0
    """Length of each manoeuvre in s."""
    yaw_rate: float = 0.0
    """Of a quadrotor's heading in rad/s."""
    dither: NotNegative = 1.0
    """Noise on the commands: 1 is thrust 5 mN and rates 0.15 rad/s, or steering 0.03 rad and speed 0.1 m/s; of other
    robots a fiftieth of the commands' range."""
    exclude: tuple[str, ...] = ()
    """Effects that are not looked at (KIND or KIND:COLUMN)."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Simulate or read, print the table."""
        from sym2real.cli.model import equations_below, logs_for
        from sym2real.cli.progress import stages_progress
        from sym2real.diagnosis import plan
        from sym2real.effects.catalogue import require_patterns
        from sym2real.experiments.models import robot_called
        from sym2real.logs.table import IN_FOLDERS
        from sym2real.report.plan import plan_report
        from sym2real.robots import ROBOTS

        require_patterns(self.exclude)
        first = Path(self.what[0]) if self.what else Path()
        of_logs = bool(self.what) and (there(first) or first.suffix.lower() in IN_FOLDERS)
        robot = None if of_logs else robot_called(self.model)
        named = self.model in ROBOTS and not Path(self.model).is_dir()
        equations, notes = (ROBOTS[self.model].nominal(), ()) if named else equations_below(self.model, console)
        with stages_progress() as on_progress:
            if robot is None:
                runs, noise = logs_for(equations, [Path(name) for name in self.what], self.naming), None
            else:
                on_progress("flying in the plain simulator")
                runs, noise = self._simulated(robot)
            on_progress("computing the Fisher information of every effect")
            planned = plan(equations, runs, noise, self.exclude)
        planned = replace(planned, notes=(*notes, *planned.notes))
        console.print(plan_report(planned))
        return planned.to_dict()

    def _simulated(self, robot: Robot) -> tuple[Dataset, AssumedNoise | None]:
        """Runs of a robot, and the noise that they lack."""
        from sym2real.cli.chosen import with_values
        from sym2real.experiments.planned import manoeuvre, planned_moves, planned_runs, usual_noise
        from sym2real.tasks.task import follows_paths

        steps_in(self.seconds, robot.dt)
        typed = with_values(self.what, "a manoeuvre")
        if not follows_paths(robot):
            return planned_moves(robot, typed, seconds=self.seconds, dither=self.dither), None
        chosen = [manoeuvre(robot, shape, options) for shape, options in typed]
        runs = planned_runs(robot, chosen, seconds=self.seconds, yaw_rate=self.yaw_rate, dither=self.dither)
        return runs, usual_noise(robot)
