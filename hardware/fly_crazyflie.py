"""``python -m hardware.fly_crazyflie``: check, arm, take off, fly a task with MPPI, land, compare."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import tyro

from hardware.checks import Check
from hardware.command_line import main
from hardware.crazyflie.checks import checks
from hardware.crazyflie.laboratory import Laboratory
from hardware.interfaces import Reading, RobotLink
from hardware.mission import Mission, listed
from hardware.pilot import FlightPilot
from hardware.safety import Limits
from sym2real.robots import CRAZYFLIE, Robot
from sym2real.tasks import Task

REAL, LIMITS = Laboratory(), Limits()


@dataclass(frozen=True)
class FlyCrazyflie(Mission):
    """Fly a task with MPPI and a model on a Crazyflie: check, arm, take off, task, land; then compare with the model.

    Ctrl-C lands, a second one cuts the motors. The folder holds the record of the run (flight.parquet, flight.yaml) and
    the part that MPPI flew (TASK.csv), which `sym2real compare` and `diagnose` take.

    For example:
      python -m hardware.fly_crazyflie runs/base hover --sim --out runs/hover_1
      python -m hardware.fly_crazyflie runs/base circle --thrust-map 2026.04 --out runs/circle_1
    """

    RECORD: ClassVar[str] = "flight.parquet"
    GOING: ClassVar[str] = "arming, taking off, flying to the start"
    STOPPING: ClassVar[str] = "landing"

    task: tyro.conf.Positional[str]
    """hover, circle or lemniscate."""
    laboratory: tyro.conf.OmitArgPrefixes[Laboratory] = REAL
    """The robot and what sees it."""
    limits: Limits = LIMITS
    """When the flight ends: the fence, ages, battery, tilt."""

    @property
    def robot(self) -> Robot:
        """A Crazyflie."""
        return CRAZYFLIE

    def link(self, task: Task) -> AbstractContextManager[RobotLink]:
        """To the robot, or to a fake one."""
        return self.laboratory.link(dry=self.dry_run)

    def checks(self, readings: Sequence[Reading]) -> list[Check]:
        """What a take-off needs."""
        return checks(readings, self.limits)

    def pilot(self) -> FlightPilot:
        """Takes off, lands, and knows the mass."""
        return FlightPilot(CRAZYFLIE, self.limits, self.laboratory.mass)

    def settings(self) -> dict[str, Any]:
        """Mass and limits."""
        return {"mass": self.laboratory.mass or CRAZYFLIE.mass, "limits": listed(asdict(self.limits))}


if __name__ == "__main__":
    main(FlyCrazyflie, "python -m hardware.fly_crazyflie")
