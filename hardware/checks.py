"""What must hold before a robot moves, measured over a few seconds at rest; what its own checks are made of."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hardware.clock import Clock, SystemClock
from hardware.errors import LinkError
from hardware.interfaces import Reading, RobotLink
from hardware.safety import outside
from sym2real.trajectory import Array

OBSERVED = 2.0  # s at rest before anything moves
STILL = 0.02  # m of spread from end to end while it stands


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


Judge = Callable[[Sequence[Reading]], list[Check]]


def connected(link: RobotLink, judge: Judge, seconds: float, say: Callable[[str], None]) -> list[Check]:
    """Connect and judge what is observed for some seconds, saying every check in a line.

    Raises:
        LinkError: naming what did not answer.
    """
    say("waiting for motion capture and the robot")
    link.connect()
    known = ", ".join(f"{name} {value}" for name, value in link.about.items() if isinstance(value, str | int))
    say(f"connected: {known}; measuring for {seconds:g} s")
    found = judge(observe(link, SystemClock(), seconds))
    for check in found:
        advice = "" if check.holds else f" ({check.advice})"
        say(f"{'ok  ' if check.holds else 'FAIL'}  {check.name}: {check.measured}{advice}")
    return found


def require_ready(link: RobotLink, judge: Judge, say: Callable[[str], None]) -> None:
    """Connect, observe for two seconds at rest, and go on only where everything holds.

    Raises:
        LinkError: where something does not answer or does not hold.
    """
    if not all(check.holds for check in connected(link, judge, OBSERVED, say)):
        raise LinkError("the robot is not ready, as said above")


def observe(link: RobotLink, clock: Clock, seconds: float) -> list[Reading]:
    """Readings of a link, one every half control period."""
    start, readings = clock.now(), [link.state()]
    while clock.now() - start < seconds:
        clock.sleep_until(clock.now() + 0.5 * link.robot.dt)
        readings.append(link.state())
    return readings


def stream(name: str, source: str, stamp: str, readings: Sequence[Reading], longest: float) -> Check:
    """Whether data comes in time: its age is within half of the greatest that is allowed, s.

    Args:
        name: in words.
        source: key of a reading's ages.
        stamp: key of a reading's further numbers.
        readings: in the order of time.
        longest: greatest age, s.
    """
    oldest = max(reading.ages[source] for reading in readings)
    elapsed = readings[-1].time - readings[0].time
    seen = len({reading.extra[stamp] for reading in readings if stamp in reading.extra})
    told = f"{(seen - 1) / max(elapsed, 1e-9):.0f} seen per second, the oldest {1000.0 * oldest:.0f} ms"
    return Check(name, told, oldest <= 0.5 * longest, f"at most {500.0 * longest:.0f} ms: look at network and radio")


def below(name: str, value: float, limit: float, unit: str, advice: str) -> Check:
    """Whether a number is within a limit."""
    return Check(name, f"{value:.3g} {unit}", value <= limit, advice)


def still(positions: Array, *, measured: bool = True) -> Check:
    """Whether positions ``# (readings, axes)`` in m spread little and, where they are measured, at all."""
    spread = float(np.ptp(positions, axis=0).max())
    advice = "let it stand still; look for reflections; none at all is a picture that stands still"
    holds = spread <= STILL and (spread > 0.0 or not measured)
    return Check("spread of the position", f"{spread:.3g} m", holds, advice)


def inside(place: Array, low: Sequence[float], high: Sequence[float]) -> Check:
    """Whether a place ``# (axes,)`` lies within the fence's corners, m."""
    told = ", ".join(f"{value:.2f}" for value in place.tolist())
    holds = not outside(place, low, high)
    return Check("position", f"{told} m", holds, "put it inside the fence; are the axes right?")
