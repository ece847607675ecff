"""Robots: description files, limits, default weights, and rigid-body equations from numbers alone.

>>> ROBOTS["crazyflie"].title
'Crazyflie 2.1'
"""

from sym2real.registry import Registry
from sym2real.robots.crazyflie import CRAZYFLIE
from sym2real.robots.description import Description
from sym2real.robots.motors import Motors
from sym2real.robots.mushr import MUSHR
from sym2real.robots.nominal_car import car
from sym2real.robots.nominal_quadrotor import quadrotor
from sym2real.robots.recipe import Recipe
from sym2real.robots.robot import Limits, MPPISettings, Robot
from sym2real.robots.thrust_fit import fit_thrust_per_unit

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

__all__ = [
    "CRAZYFLIE",
    "MUSHR",
    "ROBOTS",
    "Description",
    "Limits",
    "MPPISettings",
    "Motors",
    "Recipe",
    "Robot",
    "car",
    "fit_thrust_per_unit",
    "quadrotor",
]
