"""``sym2real nominal mjcf``: equations of motion of a robot of a user's own, from its MJCF."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from rich.console import Console

from sym2real.cli.nominal import CAR_DT, save_nominal
from sym2real.cli.numbers import OptionalPositive
from sym2real.cli.of_logs import OfLogs
from sym2real.cli.positionals import DescriptionFile, JsonFile, LogsOfModel
from sym2real.errors import DataError
from sym2real.files import require_file

if TYPE_CHECKING:
    from sym2real.logs import LogSpec
    from sym2real.robots import Robot


@dataclass(frozen=True)
class NominalMjcf(OfLogs):
    """Equations of motion of a robot's own MJCF, by its bodies: nothing is simulated or fitted.

    For trees of hinges and slides with actuators on joints (arms, pendulums, cart-poles), robots of the plane on
    wheels of one axle, and free bodies with rotors at sites (actuators motor1, motor2 and so on). The joint J becomes
    the states J (rad or m) and J_rate, every actuator an action in its unit, a site S of a moving body a place where
    load:S may hang. The folder holds the robot too: simulate, plan and effects take it in the place of a robot's name,
    the other verbs as a model. Give --log where you have logs: a model with their time step uses all of their rows.

    For example:
      sym2real nominal mjcf arm.xml --log swing1.csv swing2.csv --out runs/arm
      sym2real nominal mjcf arm.xml --actions shoulder_motor=tau1 elbow_motor=tau2 --out runs/arm
      sym2real nominal mjcf rover.xml --state x y sin_yaw cos_yaw vx vy wz --out runs/rover
    """

    OUT_IS_NEW: ClassVar = True

    file: DescriptionFile
    """The robot's MJCF; meshes and includes are looked for beside it."""
    out: Path
    """Folder of the model."""
    actions: tuple[str, ...] = ()
    """Actuators that are commanded, ACTUATOR or ACTUATOR=COLUMN to call the column otherwise; all by default."""
    state: tuple[str, ...] = ()
    """Columns of the state; all joints and their rates by default. With x y sin_yaw cos_yaw vx vy wz a free body on
    wheels is a robot of the plane."""
    dt: OptionalPositive = None
    """Control period in s, whole time steps of the file; by default that of --log, else about 0.02."""
    log: LogsOfModel = ()
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Make the equations, print what the robot measures and takes, write the model."""
        from sym2real.cli.progress import stages_progress
        from sym2real.report.tables import columns_table
        from sym2real.robots.naming import named_in
        from sym2real.robots.own import robot_of
        from sym2real.robots.runge_kutta import telling

        robot = self._robot()
        with stages_progress() as show, telling(show):
            equations = robot.nominal()
        console.print(f"a log of it holds the time in s, in steps of about {robot.dt:g} s, and")
        result = save_nominal(equations, self.out, console, None if self.dt else CAR_DT, columns_table(robot))
        if robot_of(equations) is None:
            console.print(
                "note: the file needs others beside it (a field of heights), so no simulator goes with the model"
            )
        if named := named_in(self.file):
            renamed = ", ".join(f"{old} → {new}" for old, new in named.items())
            console.print(f"names by which columns and --actions go: {renamed}", markup=False)
        console.print(f"what it may lack: sym2real effects --robot {self.out}", markup=False)
        return {**result, "dt": robot.dt, "columns": {**robot.layouts.state.units, **robot.layouts.action.units}}

    def _robot(self) -> Robot:
        from sym2real.robots import Robot

        naming = self.naming_of(self.log, "--log")
        require_file(self.file)
        parts = (text.partition("=") for text in self.actions)
        actions = {actuator: column or actuator for actuator, _, column in parts}
        made = partial(Robot.from_mjcf, self.file, actions=actions or None, state=self.state or None)
        robot = made(dt=self.dt)
        return made(dt=self._step(robot, naming)) if self.log and self.dt is None else robot

    def _step(self, robot: Robot, naming: LogSpec | None) -> float:
        """Time step of the logs in s; without a specification by the column that holds their stamps."""
        from sym2real.experiments.measured import step_of_logs
        from sym2real.logs import inspect_logs

        if self.spec is not None:
            return step_of_logs(self.log, naming, robot.layouts)
        step = inspect_logs(self.log, self.columns).spec.time.dt
        if step is None:
            raise DataError(self.log[0], "a column of stamps, or --dt", "neither")
        return step
