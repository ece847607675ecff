"""The two robots of the paper, for tests of what they alone have: paths, a wrench, numbers of their kind."""

from __future__ import annotations

from sym2real.robots import CRAZYFLIE, MUSHR, Robot

PAPER_ROBOTS: dict[str, Robot] = {robot.name: robot for robot in (CRAZYFLIE, MUSHR)}
