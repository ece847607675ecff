"""First-principles equations at motor level for a real flight whose log has motor commands and no rate commands."""

from pathlib import Path

from sym2real.experiments.thrust_of_log import CALIBRATION_SECONDS
from sym2real.logs import read_log
from sym2real.robots import Motors, fit_thrust_per_unit, quadrotor
from sym2real.symbolic import Equations

DT = 0.02


def motor_level_equations(path: Path, spec: str) -> Equations:
    """Equations per unit of mass, attitude measured, thrust per unit of the motors as linear in whatever they hold.

    It is fitted on the flight's first two seconds.
    """
    layouts = quadrotor(interface="motors", attitude="measured", dt=DT).layouts
    per_mass = fit_thrust_per_unit(read_log(path, spec=spec, layouts=layouts, dt=DT), CALIBRATION_SECONDS)
    return quadrotor(None, interface="motors", attitude="measured", motors=Motors(thrust=per_mass), dt=DT)
