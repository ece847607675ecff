"""Robots: description files, limits, default weights, and rigid-body equations from numbers alone."""

from sym2real.registry import Registry
from sym2real.robots.crazyflie import CRAZYFLIE
from sym2real.robots.mushr import MUSHR
from sym2real.robots.robot import MPPISettings, Robot

ROBOTS: Registry[Robot] = Registry("robot", {"crazyflie": CRAZYFLIE, "mushr": MUSHR})

__all__ = ["CRAZYFLIE", "MUSHR", "ROBOTS", "MPPISettings", "Robot"]
