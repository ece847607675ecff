"""Controllers: MPPI over any dynamics model, geometric controllers for test runs, random commands for Stage I."""

from sym2real.control.flown_model import CorrectedMPPI, mppi_controller
from sym2real.control.geometric import Disturbed, geometric_controller
from sym2real.control.geometric_quadrotor import GeometricQuadrotor
from sym2real.control.linear_quadratic import LinearQuadratic
from sym2real.control.mppi import MPPI
from sym2real.control.plan import Plan
from sym2real.control.pure_pursuit import PurePursuit
from sym2real.control.random_commands import RandomCommands

__all__ = [
    "MPPI",
    "CorrectedMPPI",
    "Disturbed",
    "GeometricQuadrotor",
    "LinearQuadratic",
    "Plan",
    "PurePursuit",
    "RandomCommands",
    "geometric_controller",
    "mppi_controller",
]
