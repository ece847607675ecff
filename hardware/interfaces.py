"""What a robot and a motion capture system must offer; every adapter is one of the two.

Times are seconds of one monotonic clock (:mod:`hardware.clock`); an age is the time since something has arrived.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from types import TracebackType
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike

from sym2real.errors import ShapeError
from sym2real.robots import Robot
from sym2real.trajectory import Array


@dataclass(frozen=True, eq=False)
class Pose:
    """Where motion capture sees a body.

    Args:
        position: m, world axes ``# (3,)``.
        attitude: unit quaternion w x y z, body→world ``# (4,)``; None from systems that see a point.
        stamp: when it was captured, s; the arrival where the system tells no time.
        arrival: when it arrived here, s.
        velocity: m/s, world axes, from consecutive stamps; NaN after the first pose, after a gap, and from systems
            that leave it to their reader ``# (3,)``.
    """

    position: Array
    attitude: Array | None
    stamp: float
    arrival: float
    velocity: Array = field(default_factory=lambda: np.full(3, math.nan))


@dataclass(frozen=True, eq=False)
class Reading:
    """What is known of a robot at one moment.

    Args:
        time: of the reading, s.
        state: columns of the robot's state; NaN where nothing has arrived yet ``# (state,)``.
        ages: s since the newest data of every source ("pose", "attitude"); infinite where nothing has arrived.
        battery: V; NaN where it is not reported.
        flags: what the robot says of itself: "armed", "can_fly", "flying", "tumbled", "locked", "crashed";
            "lost" where the link has ended.
        extra: further numbers for the record, by name.
    """

    time: float
    state: Array
    ages: Mapping[str, float]
    battery: float = math.nan
    flags: frozenset[str] = frozenset()
    extra: Mapping[str, float] = field(default_factory=dict)


class Verdict(IntEnum):
    """What a pilot does; within a flight or a drive a greater one is never taken back."""

    GO = 0
    LAND = 1  # a car brakes
    CUT = 2


@dataclass(frozen=True, eq=False)
class Command:
    """What a pilot lets through, and why.

    Args:
        action: within the robot's limits ``# (action,)``; zero where the motors are cut.
        verdict: go on, land or cut.
        phase: the same in words for the record, with how ("blind landing").
        reason: for leaving GO; empty before.
        fault: what a person looks at the robot for before it moves again, though a landing was asked for; empty else.
        remedy: what a person does where no action ended the flight, but an empty battery, say; empty else.
    """

    action: Array
    verdict: Verdict
    phase: str
    reason: str
    fault: str = ""
    remedy: str = ""


class Pilot(Protocol):
    """Stands between a controller and a robot: what is wanted becomes what is safe."""

    @property
    def late(self) -> float:
        """s that an action may be late before the pilot ends the flight without it."""

    @property
    def holding(self) -> float:
        """s that a start is held for a controller's first action."""

    def begin(self, readings: Sequence[Reading]) -> None:
        """A flight or drive begins where the robot was seen to stand; UnreachableError where it must not."""

    def approach(self, reading: Reading, state: Array) -> float:
        """Head for a state ``# (state,)`` by a safe controller; s that it may take, or UnreachableError."""

    def towards(self, reading: Reading) -> Array:
        """The safe controller's action of this control period ``# (action,)``."""

    def arrived(self, reading: Reading) -> bool:
        """Whether the robot is where it was to go, at rest."""

    def act(
        self, reading: Reading, wanted: Array | None, *, late: float = 0.0, overruns: int = 0, asked: str = ""
    ) -> Command:
        """The command of this control period.

        Args:
            reading: of the robot.
            wanted: the controller's action ``# (action,)``; None where there is none.
            late: s since it was due.
            overruns: actions in a row that came too late.
            asked: why somebody wants to land; empty where nobody does.
        """


class MotionCapture(Protocol):
    """Poses of one body, in world axes; neither question waits."""

    def connect(self) -> None:
        """Start to receive; LinkError without a pose in time. Call it before the robot is armed."""

    def latest(self) -> Pose | None:
        """The newest pose, None before the first."""

    def recent(self) -> Sequence[Pose]:
        """The last poses in the order of their arrival, for filters that need every one of them."""

    def close(self) -> None:
        """Stop to receive."""


class RobotLink(Protocol):
    """A robot that takes actions and says how it is."""

    @property
    def robot(self) -> Robot:
        """Columns, limits and control period."""

    @property
    def about(self) -> Mapping[str, Any]:
        """What a record says of the link: addresses and settings, as numbers, texts, lists and mappings of them."""

    def connect(self) -> None:
        """Open the link and wait until state arrives; LinkError with what was waited for."""

    def arm(self) -> None:
        """Make it ready to move; LinkError where it refuses. Nothing moves yet."""

    def state(self) -> Reading:
        """What is known now; it never waits."""

    def send(self, action: ArrayLike) -> Array:
        """Send an action ``# (action,)``; what the robot is really told, after rounding and saturation.

        Raises:
            ShapeError: for an action that is not finite or has other columns; nothing is sent then.
        """

    def stop(self, *, emergency: bool = False) -> None:
        """Motors off at once. An emergency stop also keeps them off until a person restarts the robot."""

    def close(self) -> None:
        """Stop and let go of the link; it may be called twice."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


def finite_action(action: ArrayLike, robot: Robot) -> Array:
    """An action as an array ``# (action,)``.

    Raises:
        ShapeError: for other columns, or numbers that are not finite.
    """
    wanted, columns = np.asarray(action, dtype=np.float64), robot.layouts.action.columns
    if wanted.shape != (len(columns),) or not np.isfinite(wanted).all():
        raise ShapeError(f"expected finite numbers for {', '.join(columns)}, found {wanted.tolist()}")
    return wanted
