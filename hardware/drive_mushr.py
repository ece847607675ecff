"""``python -m hardware.drive_mushr``: check, drive to the start, drive a task with MPPI, brake, compare."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np
import tyro

from hardware.checks import Check
from hardware.command_line import main
from hardware.interfaces import Reading, RobotLink
from hardware.mission import Mission, listed
from hardware.mushr.checks import checks
from hardware.mushr.laboratory import Laboratory
from hardware.mushr.pilot import DriveLimits, DrivePilot
from sym2real.robots import MUSHR, Robot
from sym2real.tasks import Task

REAL, LIMITS = Laboratory(), DriveLimits()


@dataclass(frozen=True)
class DriveMushr(Mission):
    """Drive a task with MPPI and a model on a MuSHR: check, drive to the start, task, brake; then compare.

    Hold the button for autonomy. Ctrl-C brakes, a second one stops the wheels at once. The folder holds the record of
    the run (drive.parquet, drive.yaml) and the part that MPPI drove (TASK.csv), which `sym2real compare` and `diagnose`
    take.

    For example:
      python -m hardware.drive_mushr runs/base circle --sim --out runs/circle_1
      python -m hardware.drive_mushr runs/base park --master http://192.168.1.3:11311 --out runs/park_1
    """

    RECORD: ClassVar[str] = "drive.parquet"
    GOING: ClassVar[str] = "driving to the start"
    STOPPING: ClassVar[str] = "braking"

    task: tyro.conf.Positional[str]
    """circle, reverse_circle, lemniscate, track or park."""
    laboratory: tyro.conf.OmitArgPrefixes[Laboratory] = REAL
    """The robot and what sees it."""
    limits: DriveLimits = LIMITS
    """When the drive ends: the fence, ages, lateness."""

    @property
    def robot(self) -> Robot:
        """A MuSHR; MPPI may ask for more than its drivers take, so that its mean reaches what they do."""
        return MUSHR

    def link(self, task: Task) -> AbstractContextManager[RobotLink]:
        """To the car, or to a fake one that stands near the start."""
        return self.laboratory.link(dry=self.dry_run, near=task.start(np.random.default_rng(self.seed)))

    def checks(self, readings: Sequence[Reading]) -> list[Check]:
        """What a drive needs."""
        return checks(readings, self.limits)

    def pilot(self) -> DrivePilot:
        """Drives to the start, and brakes."""
        return DrivePilot(MUSHR, self.limits, self.laboratory.car)

    def settings(self) -> dict[str, Any]:
        """Limits."""
        return {"limits": listed(asdict(self.limits))}


if __name__ == "__main__":
    main(DriveMushr, "python -m hardware.drive_mushr")
