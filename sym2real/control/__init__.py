"""Controllers: MPPI over any dynamics model, geometric controllers for test runs, random commands for Stage I."""

from sym2real.control.flown_model import CorrectedMPPI as CorrectedMPPI, mppi_controller as mppi_controller
from sym2real.control.geometric import Disturbed as Disturbed, geometric_controller as geometric_controller
from sym2real.control.geometric_quadrotor import GeometricQuadrotor as GeometricQuadrotor
from sym2real.control.mppi import MPPI as MPPI
from sym2real.control.plan import Plan as Plan
from sym2real.control.pure_pursuit import PurePursuit as PurePursuit
from sym2real.control.random_commands import RandomCommands as RandomCommands
