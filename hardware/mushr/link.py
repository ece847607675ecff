"""A MuSHR racecar as a robot link: poses from motion capture, Ackermann commands by ROS, zeros on every way out."""

import math
import threading
import time
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hardware.clock import SystemClock
from hardware.closing import Closing
from hardware.errors import LinkError
from hardware.interfaces import MotionCapture, Reading, finite_action
from hardware.mushr.limits import CarLimits
from hardware.mushr.pose_filter import PoseFilter
from hardware.ros import RosNode, RosPublisher
from hardware.ros1 import ACKERMANN, Message
from sym2real.robots import MUSHR
from sym2real.trajectory import Array

COMMANDS = "/car/mux/ackermann_cmd_mux/input/navigation"  # lowest priority but one: a person's joystick comes before
CONNECTING = 10.0  # s
LISTENING = 2.0  # s until the car has heard of a topic, where it listens
UNHEARD = "unheard"  # the flag of a car that nobody hears the commands of
ZEROS = 5  # periods of zeros on the way out: the mux holds a command for 0.2 s


class MushrLink(Closing):
    """A :class:`~hardware.interfaces.RobotLink`.

    Args:
        node: of ROS; it is closed with this link.
        capture: sees the car.
        limits: of what is sent.
        topic: of the commands.
        dry: everything but sending.
    """

    def __init__(
        self,
        node: RosNode,
        capture: MotionCapture,
        *,
        limits: CarLimits | None = None,
        topic: str = COMMANDS,
        dry: bool = False,
    ) -> None:
        self.robot, self.limits, self.topic, self.dry = MUSHR, limits or CarLimits(), topic, dry
        self._node, self._capture, self._clock = node, capture, SystemClock()
        self._filter, self._heard, self._stamp = PoseFilter(), -math.inf, math.nan
        self._lock = threading.Lock()  # a plant's guard reads too
        self._publisher: RosPublisher | None = None
        self._sent, self._sent_at = np.zeros(2), -math.inf
        self._locked = False

    @property
    def about(self) -> dict[str, Any]:
        """Master, topic of the commands, and limits of the drivers."""
        return {"master": self._node.master, "commands": self.topic, "car": asdict(self.limits)}

    def connect(self) -> None:
        """Hear poses until the state is whole, then wait for the car to listen.

        Raises:
            LinkError: naming what did not answer.
        """
        self._capture.connect()
        if not self._within(CONNECTING, lambda: bool(np.isfinite(self.state().state).all())):
            raise self._missing("whole state: poses with stamps that go on")
        publisher = self._publisher = self._node.advertise(self.topic, ACKERMANN)
        heard = self._within(LISTENING if self.dry else CONNECTING, lambda: publisher.subscribers > 0)
        if not (heard or self.dry):  # a dry link goes on without: a check says it in its own words
            raise self._missing(f"subscriber of {self.topic}: is the car's mux running?")

    def arm(self) -> None:
        """Zeros: the car stands. Autonomy itself is the button that a person holds.

        Raises:
            LinkError: after an emergency stop.
        """
        if self._locked:
            raise LinkError("expected a new link after an emergency stop")
        self._tell(np.zeros(2))

    def state(self) -> Reading:
        """State of the filtered poses; a flag where nobody hears the commands."""
        with self._lock:
            for pose in self._capture.recent():
                if pose.arrival > self._heard:
                    self._filter.add(pose)
                    self._heard, self._stamp = pose.arrival, pose.stamp
            state = self._filter.state
        now = self._clock.now()
        unheard = self._publisher is not None and not self._publisher.subscribers
        flags = frozenset({UNHEARD} if unheard else ())
        extra = {"pose_stamp": self._stamp} if math.isfinite(self._stamp) else {}
        return Reading(now, state.copy(), {"pose": now - self._heard}, flags=flags, extra=extra)

    def send(self, action: ArrayLike) -> Array:
        """Steering in rad and speed in m/s ``# (2,)``; the same as the car is told them, within :class:`CarLimits`.

        Raises:
            ShapeError: for an action that is not finite or has other columns; nothing is sent then.
        """
        wanted = finite_action(action, self.robot)
        if self._locked:
            return self._tell(np.zeros(2))
        # After a pause the car stands, or the mux has given the wheel to somebody else.
        seconds = min(self._clock.now() - self._sent_at, self.robot.dt)
        return self._tell(self.limits.reachable(wanted, self._sent, seconds))

    def stop(self, *, emergency: bool = False) -> None:
        """Zeros at once, whatever the acceleration; after an emergency stop nothing else is sent any more."""
        self._locked = self._locked or emergency
        if self._publisher is not None:
            self._tell(np.zeros(2))

    def close(self) -> None:
        """Zeros for a moment, so that one of them arrives, and goodbye to the master."""
        if self._publisher is not None:
            for _ in range(0 if self.dry else ZEROS):
                self.stop()
                self._clock.sleep_until(self._clock.now() + self.robot.dt)
            self._publisher = None
        self._capture.close()
        self._node.close()

    def _tell(self, action: Array) -> Array:
        if self._publisher is None:
            raise LinkError("expected an open link: connect first")
        told = action.astype(np.float32).astype(np.float64)  # as the message holds them
        if not self.dry:
            steer, speed = told.tolist()
            self._publisher.publish(Message(time.time(), "", (), (steer, 0.0, speed, 0.0, 0.0)))
        self._sent, self._sent_at = told, self._clock.now()
        return told.copy()

    def _within(self, seconds: float, ready: Callable[[], bool]) -> bool:
        start = due = self._clock.now()
        while not ready():
            if due - start > seconds:
                return False
            due += self.robot.dt / 2
            self._clock.sleep_until(due)
        return True

    def _missing(self, what: str) -> LinkError:
        return LinkError(f"{self._node.master}: no {what} ({CONNECTING:g} s)")
