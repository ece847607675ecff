"""``sym2real nominal``: rigid-body equations from numbers alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from rich.console import Console, RenderableType

from sym2real.cli.numbers import NotNegative, OptionalPositive, OptionalThreePositive, Positive
from sym2real.cli.of_logs import OfLogs
from sym2real.cli.positionals import JsonFile, LogsOfModel
from sym2real.errors import ModelError
from sym2real.vocabulary import CAR_COMMANDS, CarCommand

if TYPE_CHECKING:
    from sym2real.robots import Motors
    from sym2real.symbolic import Equations

DT, CAR_DT = 0.02, 0.05  # s
BETWEEN = 1.5  # times the usual period, halfway to a log of every second row
SLOW_ROWS = (
    "note: commands are held for the {:g} s between two rows of the logs; if the controller sends more of them, make "
    "the model with its period, --dt: what it sent between is then estimated"
)


@dataclass(frozen=True)
class NominalQuadrotor(OfLogs):
    """Rigid-body equations of a quadrotor: no simulator, no regression.

    Interfaces: thrust_rates (thrust in N and body rates, tracked on board), thrust_torques (thrust in N and torques in
    N m about the body axes), thrust_attitude (thrust and attitude), or motors (four commands 0–1 or speeds in rad/s:
    front right, rear right, rear left, front left). With --attitude measured the log's quaternion is an input and only
    position and velocity are predicted, which suits logs without rate commands. Where a log's thrust is per mass, in
    m/s², the mass is 1.

    For example:
      sym2real nominal quadrotor --mass 1.2 --interface motors --out runs/nominal
      sym2real nominal quadrotor --interface motors --attitude measured --fit-thrust flight.csv --out runs/nominal
    """

    OUT_IS_NEW: ClassVar = True

    out: Path
    """Folder of the model."""
    mass: OptionalPositive = None
    """Mass in kg; without it forces and masses are per kilogram of the robot."""
    inertia: OptionalThreePositive = None
    """Principal moments in kg m²; by default the Crazyflie's, scaled by mass."""
    interface: Literal["thrust_rates", "thrust_torques", "thrust_attitude", "motors"] = "thrust_rates"
    """What the actions are."""
    attitude: Literal["predicted", "measured"] = "predicted"
    """Whether the attitude is predicted, or known along the log."""
    dt: OptionalPositive = None
    """Time between two commands of the controller in s; by default between rows of --log or --fit-thrust, else 0.02."""
    rate_gains: OptionalThreePositive = None
    """Gains of the on-board rate loop in 1/s (thrust_rates); by default the Crazyflie's, 50 50 20."""
    attitude_time_constant: NotNegative = 0.15
    """Of the on-board attitude loop in s (thrust_attitude)."""
    motor_unit: Literal["command", "rad/s"] | None = None
    """Unit of the motor actions (motors); by default what the log of --fit-thrust shows, else commands of 0 to 1."""
    motor_thrust: OptionalPositive = None
    """Thrust of one rotor in N per unit of command, which it is proportional to, or N s²/rad² (motors); by default
    hover at half command. Of a throttle that bends diagnose finds thrust_curve."""
    torque_per_thrust: float | None = None
    """Reaction torque per thrust of a rotor in m; with motors the Crazyflie's by default, else only a weak rotor needs
    it."""
    arm: OptionalPositive = None
    """Centre to rotor in m, of four on the diagonals (X); with motors the Crazyflie's by default, else only a weak
    rotor needs it."""
    spin: tuple[int, int, int, int] | None = None
    """Sign of each rotor's reaction torque about body z (motors); the Crazyflie's by default."""
    fit_thrust: Path | None = None
    """Fit the thrust per unit on the first two seconds of this log, or of its longest stretch without gaps (motors)."""
    log: LogsOfModel = ()
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Make the equations, print them, write the model."""
        from sym2real.robots import quadrotor

        self._check_together()
        motors, dt = self._motors(console)
        equations = quadrotor(
            self.mass,
            self.inertia,
            interface=self.interface,
            attitude=self.attitude,
            dt=dt,
            rate_gains=self.rate_gains,
            attitude_time_constant=self.attitude_time_constant,
            motors=motors,
        )
        # Without commands of motors these are numbers of the robot: what a weak rotor does to it needs them.
        numbers = equations.numbers if self.interface == "motors" else {**equations.numbers, **self._rotors}
        return save_nominal(replace(equations, numbers=numbers), self.out, console, None if self.dt else DT)

    @property
    def _rotors(self) -> dict[str, Any]:
        """The options on rotors that were given, but for their thrust and its unit."""
        given = {"torque_per_thrust": self.torque_per_thrust, "arm": self.arm, "spin": self.spin}
        return {name: value for name, value in given.items() if value is not None}

    def _check_together(self) -> None:
        """Refuse options that say nothing, or two things, together."""
        thrust = [self.motor_thrust, self.fit_thrust]
        motors = self.interface == "motors"
        if not motors and any(value is not None for value in (*thrust, self.motor_unit, self.spin)):
            raise ModelError(f"motor options and --fit-thrust need --interface motors, found {self.interface}")
        if None not in thrust:
            raise ModelError("expected --motor-thrust or --fit-thrust, found both")
        if thrust == [None, None] and self.motor_unit == "rad/s":
            raise ModelError("--motor-unit rad/s needs --motor-thrust or --fit-thrust: half of full speed is unknown")

    def _motors(self, console: Console) -> tuple[Motors | None, float]:
        """The rotors, None for the Crazyflie's that hover at half command, and the time step in s."""
        from sym2real.effects.body import GRAVITY
        from sym2real.experiments.measured import step_of_logs
        from sym2real.experiments.thrust_of_log import thrust_of_log
        from sym2real.robots import Motors

        naming = self.naming_of(self.fit_thrust or self.log, "--log or --fit-thrust")
        asked = step_of_logs(self.log, naming) if self.dt is None and self.log else self.dt
        dt = asked or DT
        if self.motor_thrust is not None:
            return Motors(thrust=self.motor_thrust, unit=self.motor_unit or "command", **self._rotors), dt
        mass = 1.0 if self.mass is None else self.mass
        if self.fit_thrust is None:
            if not self._rotors:
                return None, dt
            if self.interface == "motors":
                console.print("motors hover at command 0.5: fit the thrust per unit (--fit-thrust)", markup=False)
            return Motors(thrust=GRAVITY * mass / 2.0, **self._rotors), dt
        fit = thrust_of_log(self.fit_thrust, naming, asked, self.motor_unit)
        thrust = fit.per_mass * mass
        what, unit = ("squared speed", "N s²/rad²") if fit.unit == "rad/s" else ("unit of command", "N")
        for note in fit.notes:
            console.print(f"{self.fit_thrust.name}: {note}", markup=False)
        known = f" ± {200 * fit.scatter:.1g} %, as fits to every two seconds scatter" if fit.scatter > 0 else ""
        fitted = f"thrust per {what}, fitted on the first two seconds: {thrust:.4g} {unit}{known}"
        console.print(fitted, markup=False, soft_wrap=True)
        return Motors(thrust=thrust, unit=fit.unit, **self._rotors), fit.dt


@dataclass(frozen=True)
class NominalCar(OfLogs):
    """Kinematic bicycle of a front-steered car: no simulator, no regression.

    Its position and velocity are those of the middle of the rear axle; steer is the angle of the front wheels in rad,
    left positive. A command acts from its row to the next; a yaw rate is that at the row. Of a wrong --time-constant
    diagnose finds speed_loop, of a wrong --wheelbase gain:steer.

    For example:
      sym2real nominal car --wheelbase 0.2955 --out runs/bicycle
      sym2real nominal car --wheelbase 0.2955 --log drive1.csv drive2.csv --spec drive.toml --out runs/bicycle
    """

    OUT_IS_NEW: ClassVar = True

    out: Path
    """Folder of the model."""
    wheelbase: Positive
    """Distance between the axles in m."""
    command: CarCommand = CAR_COMMANDS[0]
    """What is commanded beside the steering: a speed in m/s, or an acceleration along the heading in m/s²."""
    time_constant: NotNegative = 0.0
    """Of the speed loop in s; 0 reaches the commanded speed at once, and diagnose finds no other one then."""
    mass: Positive = 3.5
    """Mass in kg, for external forces."""
    dt: OptionalPositive = None
    """Time between two commands of the controller in s; by default between rows of --log, else 0.05."""
    log: LogsOfModel = ()
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Make the equations, print them, write the model."""
        from sym2real.experiments.measured import step_of_logs
        from sym2real.robots import car

        naming = self.naming_of(self.log, "--log")
        dt = self.dt or (step_of_logs(self.log, naming) if self.log else CAR_DT)
        equations = car(self.wheelbase, command=self.command, time_constant=self.time_constant, mass=self.mass, dt=dt)
        return save_nominal(equations, self.out, console, None if self.dt else CAR_DT)


def save_nominal(
    equations: Equations, out: Path, console: Console, usual: float | None = None, about: RenderableType = ""
) -> dict[str, Any]:
    """Write equations, print what they are of, their interface by default; what ``--json`` says of them.

    Args:
        equations: of the robot.
        out: folder of the model.
        console: to print on.
        usual: control period in s beyond which logs may lack commands that were sent; None where the period was given.
        about: what to print of the equations.
    """
    from sym2real.report.tables import interface_lines
    from sym2real.symbolic import save_model

    save_model(equations, out)
    console.print(about or "\n".join(interface_lines(equations)), markup=False)
    for note in equations.notes:
        console.print(f"note: {note}", markup=False)
    if usual is not None and equations.dt > usual * BETWEEN:
        console.print(SLOW_ROWS.format(equations.dt), markup=False)
    console.print(f"model in {out}; `sym2real show {out}` prints its equations", markup=False)
    return {"model": out, "nodes": equations.complexity(), "notes": list(equations.notes)}
