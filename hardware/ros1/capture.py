"""Poses that a topic of ROS carries: Vicon's ``TransformStamped``, or a ``PoseStamped``."""

import threading
from dataclasses import dataclass

import numpy as np

from hardware.clock import Clock, SystemClock
from hardware.errors import LinkError
from hardware.frame import Frame
from hardware.interfaces import Pose
from hardware.ros import RosNode
from hardware.ros1.messages import POSE, Message, MessageType
from hardware.velocity import Velocity

FIRST_POSE = 5.0  # s
KEPT = 64  # poses: more than half a second of them
UNIT = 0.1  # that a quaternion's square may differ from 1


@dataclass(frozen=True)
class Topic:
    """Where poses come from.

    Args:
        name: of the topic.
        kind: of its messages.
    """

    name: str
    kind: MessageType = POSE


class RosCapture:
    """A :class:`~hardware.interfaces.PoseStream` that hears a topic.

    Args:
        node: whose master knows the topic; it is not closed here.
        topic: to hear.
        frame: of the topic in the world.
        clock: the computer's by default.
    """

    def __init__(self, node: RosNode, topic: Topic, frame: Frame | None = None, clock: Clock | None = None) -> None:
        self._node, self._topic = node, topic
        self._frame, self._clock = frame or Frame(), clock or SystemClock()
        self._poses: tuple[Pose, ...] = ()
        self._velocity = Velocity()
        self._first = threading.Event()

    def connect(self) -> None:
        """Hear the topic, and wait for a pose.

        Raises:
            LinkError: where none comes, naming the topic.
        """
        self._node.subscribe(self._topic.name, self._topic.kind, self._receive)
        if not self._first.wait(FIRST_POSE):
            raise LinkError(
                f"{self._node.master}: no pose on {self._topic.name} ({self._topic.kind.name}) in {FIRST_POSE:g} s; "
                "does motion capture run, and does it see the robot?"
            )

    def latest(self) -> Pose | None:
        """The newest pose, in the world's axes."""
        poses = self._poses
        return poses[-1] if poses else None

    def recent(self) -> tuple[Pose, ...]:
        """The newest poses, in the world's axes."""
        return self._poses

    def close(self) -> None:
        """Nothing of its own: the node is somebody else's."""

    def _receive(self, message: Message) -> None:
        arrival = self._clock.now()
        place, (x, y, z, w) = np.array(message.numbers[:3]), message.numbers[3:]
        again = self._poses and message.stamp == self._poses[-1].stamp
        if again or not np.isfinite(message.numbers).all():  # how systems tell of a body that they lost
            return
        turned = np.array([w, x, y, z])
        attitude = self._frame.attitude(turned) if abs(turned @ turned - 1.0) < UNIT else None
        position = self._frame.position(place)
        velocity = self._velocity.add(message.stamp, position)
        pose = Pose(position, attitude, message.stamp, arrival, velocity)
        self._poses = (*self._poses, pose)[-KEPT:]
        self._first.set()
