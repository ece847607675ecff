"""What must hold before a take-off."""

import math
from collections.abc import Sequence

import numpy as np

from hardware.checks import Check, below, inside, still, stream
from hardware.frame import heading
from hardware.interfaces import Reading
from hardware.safety import CUTS, Limits, tilt_of

RESERVE = 0.3  # V above the limit: about what a take-off pulls a Crazyflie's battery down
UPRIGHT = math.radians(10.0)
FACING = math.radians(15.0)


def checks(readings: Sequence[Reading], limits: Limits) -> list[Check]:
    """Judge what was observed on the ground."""
    last, states = readings[-1], np.array([reading.state for reading in readings])
    flagged = sorted(last.flags & set(CUTS))
    return [
        stream("motion capture", "pose", "pose_stamp", readings, limits.pose_age),
        stream("the robot's log", "attitude", "robot_stamp", readings, limits.attitude_age),
        still(states[:, :3]),
        below("tilt", max(map(tilt_of, states[:, 3:7])), UPRIGHT, "rad", "stand it upright on level ground"),
        below("yaw against motion capture", _facing(readings), FACING, "rad", "turn its front along x, restart it"),
        inside(states[-1, :3], limits.low, limits.high),
        Check("battery", f"{last.battery:.2f} V", last.battery >= limits.battery + RESERVE, "charge it"),
        Check("supervisor", " ".join(sorted(last.flags)) or "nothing set", not flagged, "restart the robot"),
    ]


def _facing(readings: Sequence[Reading]) -> float:
    """Greatest difference in rad between the robot's yaw and that of motion capture; zero where it sees a point."""
    seen = [(reading.state, reading.extra["capture_yaw"]) for reading in readings if "capture_yaw" in reading.extra]
    return max((abs(math.remainder(heading(state[3:7]) - yaw, 2.0 * math.pi)) for state, yaw in seen), default=0.0)
