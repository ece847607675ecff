"""``python -m hardware.check_car``: is everything there that a drive needs? Nothing moves."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

import tyro

from hardware.checking import Checking
from hardware.checks import Check
from hardware.command_line import main
from hardware.interfaces import Reading, RobotLink
from hardware.mushr.checks import checks
from hardware.mushr.laboratory import Laboratory
from hardware.mushr.pilot import DriveLimits

REAL, LIMITS = Laboratory(), DriveLimits()


@dataclass(frozen=True)
class CheckCar(Checking):
    """Connect to a MuSHR and its motion capture, and measure for some seconds what a drive needs. Nothing moves.

    For example:
      python -m hardware.check_car --sim
      python -m hardware.check_car --master http://192.168.1.3:11311 --poses /vicon/car/car --kind TransformStamped
    """

    laboratory: tyro.conf.OmitArgPrefixes[Laboratory] = REAL
    """The robot and what sees it."""
    limits: DriveLimits = LIMITS
    """Of the drive: what is measured must keep within half of its age."""

    def link(self) -> AbstractContextManager[RobotLink]:
        """To the robot, or to a fake one."""
        return self.laboratory.link(dry=True)

    def checks(self, readings: Sequence[Reading]) -> list[Check]:
        """What a drive needs."""
        return checks(readings, self.limits)


if __name__ == "__main__":
    main(CheckCar, "python -m hardware.check_car")
