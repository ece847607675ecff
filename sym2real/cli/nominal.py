"""``sym2real nominal``: rigid-body equations from numbers alone."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from rich.console import Console

from sym2real.cli.numbers import NotNegative, OptionalPositive, OptionalThreePositive, Positive, ThreePositive
from sym2real.cli.places import Place

if TYPE_CHECKING:
    from sym2real.robots import Motors
    from sym2real.symbolic import Equations


@dataclass(frozen=True)
class NominalQuadrotor:
    """Rigid-body equations of a quadrotor: no simulator, no regression.

    Interfaces: thrust_rates (thrust in N and body rates, tracked on board), thrust_attitude (thrust and attitude), or
    motors (four commands 0–1 or speeds in rad/s: front right, rear right, rear left, front left). With --attitude
    measured the log's quaternion is an input and only position and velocity are predicted, which suits logs without
    rate commands. Where a log's thrust is per mass, in m/s², the mass is 1.

    For example:
      sym2real nominal quadrotor --mass 1.2 --interface motors --out runs/nominal
      sym2real nominal quadrotor --interface motors --attitude measured --fit-thrust flight.csv --out runs/nominal
    """

    out: Path
    """Folder of the model."""
    mass: OptionalPositive = None
    """Mass in kg; without it forces and masses are per kilogram of the robot."""
    inertia: OptionalThreePositive = None
    """Principal moments in kg m²; by default the Crazyflie's, scaled by mass."""
    interface: Literal["thrust_rates", "thrust_attitude", "motors"] = "thrust_rates"
    """What the actions are."""
    attitude: Literal["predicted", "measured"] = "predicted"
    """Whether the attitude is predicted, or known along the log."""
    dt: Positive = 0.02
    """Time step in s."""
    rate_gains: ThreePositive = (50.0, 50.0, 20.0)
    """Gains of the on-board rate loop in 1/s (thrust_rates)."""
    attitude_time_constant: NotNegative = 0.15
    """Of the on-board attitude loop in s (thrust_attitude)."""
    motor_unit: Literal["command", "rad/s"] = "command"
    """Unit of the motor actions (motors)."""
    motor_thrust: OptionalPositive = None
    """Thrust of one rotor in N per unit of command, or N s²/rad² (motors); by default hover at half command."""
    torque_per_thrust: float | None = None
    """Reaction torque per thrust of a rotor in m (motors); the Crazyflie's by default."""
    arm: OptionalPositive = None
    """Centre to rotor in m (motors); the Crazyflie's by default."""
    spin: tuple[int, int, int, int] | None = None
    """Sign of each rotor's reaction torque about body z (motors); the Crazyflie's by default."""
    fit_thrust: Path | None = None
    """Fit the thrust per unit on the first two seconds of this log (motors, or mass-normalised thrust)."""
    spec: Place | None = None
    """How that log's columns are named: a shipped specification's name or a TOML file."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    def run(self, console: Console) -> dict[str, Any]:
        """Make the equations, print them, write the model."""
        from sym2real.robots import quadrotor

        equations = quadrotor(
            self.mass,
            self.inertia,
            interface=self.interface,
            attitude=self.attitude,
            dt=self.dt,
            rate_gains=self.rate_gains,
            attitude_time_constant=self.attitude_time_constant,
            motors=self._motors(console),
        )
        return save_nominal(equations, self.out, console)

    def _motors(self, console: Console) -> Motors | None:
        from sym2real.errors import ModelError
        from sym2real.experiments.real_flight import thrust_of_log
        from sym2real.robots import Motors

        given = {
            "torque_per_thrust": self.torque_per_thrust,
            "arm": self.arm,
            "spin": self.spin,
        }
        chosen: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        if self.interface != "motors":
            if chosen or self.motor_thrust is not None or self.fit_thrust is not None:
                raise ModelError(f"motor options and --fit-thrust need --interface motors, found {self.interface}")
            return None
        thrust = self.motor_thrust
        if self.fit_thrust is not None:
            per_mass = thrust_of_log(self.fit_thrust, self.spec, self.dt, self.motor_unit)
            thrust = per_mass * (1.0 if self.mass is None else self.mass)
            what, unit = ("squared speed", "N s²/rad²") if self.motor_unit == "rad/s" else ("unit of command", "N")
            console.print(f"thrust per {what}, fitted on the first two seconds: {thrust:.4g} {unit}", markup=False)
        if thrust is None:
            if chosen:
                raise ModelError("--torque-per-thrust, --arm and --spin need --motor-thrust or --fit-thrust")
            return None
        return Motors(thrust=thrust, unit=self.motor_unit, **chosen)


@dataclass(frozen=True)
class NominalCar:
    """Kinematic bicycle of a front-steered car: no simulator, no regression.

    Example: sym2real nominal car --wheelbase 0.2955 --out runs/bicycle
    """

    out: Path
    """Folder of the model."""
    wheelbase: Positive
    """Distance between the axles in m."""
    time_constant: NotNegative = 0.0
    """Of the speed loop in s; 0 reaches the commanded speed at once."""
    mass: Positive = 3.5
    """Mass in kg, for external forces."""
    dt: Positive = 0.05
    """Time step in s."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    def run(self, console: Console) -> dict[str, Any]:
        """Make the equations, print them, write the model."""
        from sym2real.robots import car

        equations = car(self.wheelbase, time_constant=self.time_constant, mass=self.mass, dt=self.dt)
        return save_nominal(equations, self.out, console)


def save_nominal(equations: Equations, out: Path, console: Console) -> dict[str, Any]:
    """Print and write equations; what ``--json`` says of them."""
    from sym2real.report.tables import equation_table
    from sym2real.symbolic import save_model

    save_model(equations, out)
    console.print(equation_table(equations))
    for note in equations.notes:
        console.print(f"note: {note}", markup=False)
    console.print(f"model in {out}", markup=False)
    return {"model": out, "nodes": equations.complexity(), "notes": list(equations.notes)}
