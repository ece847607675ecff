"""``python -m hardware.check_link``: is everything there that a flight needs? Nothing moves."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

import tyro

from hardware.checking import Checking
from hardware.checks import Check
from hardware.command_line import main
from hardware.crazyflie.checks import checks
from hardware.crazyflie.laboratory import Laboratory
from hardware.interfaces import Reading, RobotLink
from hardware.safety import Limits

REAL, LIMITS = Laboratory(), Limits()


@dataclass(frozen=True)
class CheckLink(Checking):
    """Connect to a Crazyflie and its motion capture, and measure for some seconds what a flight needs. Nothing moves.

    For example:
      python -m hardware.check_link --sim
      python -m hardware.check_link --thrust-map 2026.04 --capture vicon --settings hostname=192.168.1.2
    """

    laboratory: tyro.conf.OmitArgPrefixes[Laboratory] = REAL
    """The robot and what sees it."""
    limits: Limits = LIMITS
    """Of the flight: what is measured must keep within half of its ages."""

    def link(self) -> AbstractContextManager[RobotLink]:
        """To the robot, or to a fake one."""
        return self.laboratory.link(dry=True)

    def checks(self, readings: Sequence[Reading]) -> list[Check]:
        """What a take-off needs."""
        return checks(readings, self.limits)


if __name__ == "__main__":
    main(CheckLink, "python -m hardware.check_link")
