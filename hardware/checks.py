"""What must hold before a take-off, measured over a few seconds on the ground."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hardware.clock import Clock
from hardware.frame import heading
from hardware.interfaces import Reading, RobotLink
from hardware.safety import CUTS, Limits, tilt_of
from sym2real.trajectory import Array

RESERVE = 0.3  # V above the limit: about what a take-off pulls a Crazyflie's battery down
STILL = 0.01  # m of spread while it stands
UPRIGHT = math.radians(10.0)
FACING = math.radians(15.0)


@dataclass(frozen=True)
class Check:
    """One thing that must hold.

    Args:
        name: of it.
        measured: in words.
        holds: whether it does.
        advice: what to do where it does not.
    """

    name: str
    measured: str
    holds: bool
    advice: str


def observe(link: RobotLink, clock: Clock, seconds: float) -> list[Reading]:
    """Readings of a link, one every half control period."""
    start, readings = clock.now(), [link.state()]
    while clock.now() - start < seconds:
        clock.sleep_until(clock.now() + 0.5 * link.robot.dt)
        readings.append(link.state())
    return readings


def checks(readings: Sequence[Reading], limits: Limits) -> list[Check]:
    """Judge what was observed on the ground."""
    last, states = readings[-1], np.array([reading.state for reading in readings])
    flagged = sorted(last.flags & set(CUTS))
    return [
        _stream("motion capture", "pose", "pose_stamp", readings, limits.pose_age),
        _stream("the robot's log", "attitude", "robot_stamp", readings, limits.attitude_age),
        _below("spread of the position", _spread(states), STILL, "m", "let it stand still; look for reflections"),
        _below("tilt", max(map(tilt_of, states[:, 3:7])), UPRIGHT, "rad", "stand it upright on level ground"),
        _below("yaw against motion capture", _facing(readings), FACING, "rad", "turn its front along x, restart it"),
        _fence(states[-1, :3], limits),
        Check("battery", f"{last.battery:.2f} V", last.battery >= limits.battery + RESERVE, "charge it"),
        Check("supervisor", " ".join(sorted(last.flags)) or "nothing set", not flagged, "restart the robot"),
    ]


def _stream(name: str, source: str, stamp: str, readings: Sequence[Reading], longest: float) -> Check:
    oldest = max(reading.ages[source] for reading in readings)
    elapsed = readings[-1].time - readings[0].time
    per_second = (len({reading.extra[stamp] for reading in readings if stamp in reading.extra}) - 1) / max(
        elapsed, 1e-9
    )
    told = f"{per_second:.0f} seen per second, the oldest {1000.0 * oldest:.0f} ms"
    return Check(name, told, oldest <= 0.5 * longest, f"at most {500.0 * longest:.0f} ms: look at network and radio")


def _below(name: str, value: float, limit: float, unit: str, advice: str) -> Check:
    return Check(name, f"{value:.3g} {unit}", value <= limit, advice)


def _spread(states: Array) -> float:
    return float(np.abs(states[:, :3] - states[:, :3].mean(0)).max())


def _facing(readings: Sequence[Reading]) -> float:
    """Greatest difference in rad between the robot's yaw and that of motion capture; zero where it sees a point."""
    seen = [(reading.state, reading.extra["capture_yaw"]) for reading in readings if "capture_yaw" in reading.extra]
    return max((abs(math.remainder(heading(state[3:7]) - yaw, 2.0 * math.pi)) for state, yaw in seen), default=0.0)


def _fence(place: Array, limits: Limits) -> Check:
    inside = bool(((np.array(limits.low) <= place) & (place <= np.array(limits.high))).all())
    told = ", ".join(f"{value:.2f}" for value in place.tolist())
    return Check("position", f"{told} m", inside, "put it inside the fence; are the axes right?")


def report(found: Sequence[Check], say: Callable[[str], None]) -> bool:
    """Say every check in a line; whether all hold."""
    for check in found:
        advice = "" if check.holds else f" ({check.advice})"
        say(f"{'ok  ' if check.holds else 'FAIL'}  {check.name}: {check.measured}{advice}")
    return all(check.holds for check in found)
