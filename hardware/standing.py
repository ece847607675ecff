"""Whether a drone stands: level, still, and turned as it believes. What a hand holds does not."""

import math
from collections.abc import Sequence

import numpy as np

from hardware.frame import heading
from hardware.interfaces import Reading
from hardware.safety import Limits, tilt_of


def tilt_among(readings: Sequence[Reading]) -> float:
    """Greatest tilt in rad; NaN where an attitude is none."""
    return float(np.max([tilt_of(reading.state[3:7]) for reading in readings]))


def rate_among(readings: Sequence[Reading]) -> float:
    """Root mean square of the rate about the body axis that turns most, rad/s."""
    return float(np.sqrt(np.mean([reading.state[10:13] ** 2 for reading in readings], axis=0)).max())


def yaw_off(readings: Sequence[Reading]) -> float:
    """Median difference in rad between the robot's yaw and that of motion capture; zero where it sees a point."""
    seen = [(reading.state, reading.extra["capture_yaw"]) for reading in readings if "capture_yaw" in reading.extra]
    off = [abs(math.remainder(heading(state[3:7]) - yaw, 2.0 * math.pi)) for state, yaw in seen]
    return float(np.median(off)) if off else 0.0


def unstable_reason(readings: Sequence[Reading], limits: Limits) -> str:
    """Why a drone does not stand as before a take-off, empty where it does."""
    tilt, rate, yaw = tilt_among(readings), rate_among(readings), yaw_off(readings)
    reasons = (
        "" if tilt <= limits.standing_tilt else f"it leans by {math.degrees(tilt):.0f}°: stand it on level ground",
        "" if rate <= limits.standing_rate else f"it turns by {rate:.2f} rad/s: let it stand still",
        "" if yaw <= limits.facing else f"its yaw is {math.degrees(yaw):.0f}° off: turn its front along x",
    )
    return next(filter(None, reasons), "")
