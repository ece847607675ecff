"""First-principles equations at motor level for a real flight whose log has motor commands and no rate commands."""

from __future__ import annotations

from pathlib import Path

from sym2real.logs import read_log
from sym2real.robots import Motors, fit_thrust_per_unit, quadrotor
from sym2real.robots.motors import MotorUnit
from sym2real.symbolic import Equations

DT = 0.02
CALIBRATION_SECONDS = 2.0


def thrust_of_log(path: Path, spec: str | None, dt: float = DT, unit: MotorUnit = "command") -> float:
    """Acceleration per unit of motor command (m/s²), or per squared speed (m/rad²), in a log's first two seconds.

    Raises:
        DataError: when the log cannot be read, or has no motor commands or attitude.
    """
    layouts = quadrotor(interface="motors", attitude="measured", dt=dt).layouts
    return fit_thrust_per_unit(read_log(path, spec=spec, layouts=layouts, dt=dt), CALIBRATION_SECONDS, unit)


def motor_level_equations(path: Path, spec: str) -> Equations:
    """Equations per unit of mass, attitude measured, thrust per command fitted on the flight's first two seconds."""
    motors = Motors(thrust=thrust_of_log(path, spec))
    return quadrotor(1.0, interface="motors", attitude="measured", motors=motors, dt=DT)
