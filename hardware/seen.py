"""What every motion capture keeps of the body that it sees: its newest poses, in the world's axes."""

import threading
from abc import abstractmethod

import numpy as np

from hardware.clock import SystemClock
from hardware.closing import Closing
from hardware.frame import Frame
from hardware.interfaces import Pose
from hardware.reach import Reach
from hardware.velocity import Velocity
from sym2real.trajectory import Array

FIRST_POSE = 5.0  # s
KEPT = 64  # poses: more than half a second of them
UNIT = 0.1  # that a quaternion's square may differ from 1


class SeenBody(Closing):
    """Part of a :class:`~hardware.interfaces.MotionCapture` that is told what a system sees.

    Args:
        frame: of the system in the world.
    """

    measured = True  # by cameras; a topic may tell what a filter makes of a robot that stands, the same again and again

    def __init__(self, frame: Frame | None = None) -> None:
        self._frame, self.clock = frame or Frame(), SystemClock()
        self._poses: tuple[Pose, ...] = ()
        self._velocity, self._reach = Velocity(), Reach()
        self._first = threading.Event()

    @abstractmethod
    def connect(self) -> None:
        """Start to receive, and wait for a pose."""

    def latest(self) -> Pose | None:
        """The newest pose, in the world's axes."""
        poses = self._poses
        return poses[-1] if poses else None

    def recent(self) -> tuple[Pose, ...]:
        """The newest poses, in the world's axes."""
        return self._poses

    def comes(self) -> bool:
        """Whether a pose comes in time."""
        return self._first.wait(FIRST_POSE)

    def tell(self, position: Array, attitude: Array, arrival: float, stamp: float | None = None) -> None:
        """A pose has arrived: m ``# (3,)`` and w x y z ``# (4,)`` in the system's axes, and s; stamped then by default.

        A position that is no number is how systems tell of a body that they lost; one that the body cannot have
        reached has not arrived, until several agree.
        """
        stamp, place = arrival if stamp is None else stamp, self._frame.position(position)
        if not np.isfinite(place).all() or self._repeats(stamp, place) or not self._reach.holds(place, arrival):
            return
        turned = self._frame.attitude(attitude) if abs(attitude @ attitude - 1.0) < UNIT else None
        if self._reach.anew:
            self._velocity = Velocity()
        pose = Pose(place, turned, stamp, arrival, self._velocity.add(stamp, place))
        self._poses = (*self._poses, pose)[-KEPT:]
        self._first.set()

    def _repeats(self, stamp: float, place: Array) -> bool:
        """Whether a stamp or a position is told again: no camera measures one twice to the last bit."""
        before = self.latest()
        return before is not None and (
            stamp == before.stamp or (self.measured and np.array_equal(place, before.position))
        )
