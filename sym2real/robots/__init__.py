"""Robots: description files, limits, default weights, and rigid-body equations from numbers alone.

>>> ROBOTS["crazyflie"].title
'Crazyflie 2.1'
"""

from sym2real.registry import Registry
from sym2real.robots.crazyflie import CRAZYFLIE as CRAZYFLIE
from sym2real.robots.description import Description as Description
from sym2real.robots.motors import Motors as Motors
from sym2real.robots.mushr import MUSHR as MUSHR
from sym2real.robots.nominal_car import car as car
from sym2real.robots.nominal_quadrotor import quadrotor as quadrotor
from sym2real.robots.recipe import Recipe as Recipe
from sym2real.robots.robot import Limits as Limits, MPPISettings as MPPISettings, Robot as Robot
from sym2real.robots.thrust_fit import fit_thrust_per_unit as fit_thrust_per_unit

# Robots that come from their MJCF alone are opened when they are asked for: MuJoCo stays out of light imports.
ROBOTS: Registry[Robot] = Registry(
    "robot",
    {"crazyflie": CRAZYFLIE, "mushr": MUSHR},
    later={
        "arm": "sym2real.robots.arm:ARM",
        "cart_pole": "sym2real.robots.cart_pole:CART_POLE",
        "differential_drive": "sym2real.robots.differential_drive:DIFFERENTIAL_DRIVE",
        "hexarotor": "sym2real.robots.hexarotor:HEXAROTOR",
    },
)
