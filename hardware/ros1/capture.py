"""Poses that a topic of ROS carries: Vicon's ``TransformStamped``, or a ``PoseStamped``."""

from dataclasses import dataclass

import numpy as np

from hardware.errors import LinkError
from hardware.frame import Frame
from hardware.ros import RosNode
from hardware.ros1.messages import POSE, Message, MessageType
from hardware.seen import FIRST_POSE, SeenBody


@dataclass(frozen=True)
class Topic:
    """Where poses come from.

    Args:
        name: of the topic.
        kind: of its messages.
    """

    name: str
    kind: MessageType = POSE


class RosCapture(SeenBody):
    """A :class:`~hardware.interfaces.MotionCapture` that hears a topic.

    Args:
        node: whose master knows the topic; it is not closed here.
        topic: to hear.
        frame: of the topic in the world.
    """

    measured = False

    def __init__(self, node: RosNode, topic: Topic, frame: Frame | None = None) -> None:
        super().__init__(frame)
        self._node, self._topic = node, topic

    def connect(self) -> None:
        """Hear the topic, and wait for a pose.

        Raises:
            LinkError: where none comes, naming the topic.
        """
        self._node.subscribe(self._topic.name, self._topic.kind, self._receive)
        if not self.comes():
            raise LinkError(
                f"{self._node.master}: no pose on {self._topic.name} ({self._topic.kind.name}) in {FIRST_POSE:g} s; "
                "does motion capture run, and does it see the robot?"
            )

    def close(self) -> None:
        """Nothing of its own: the node is somebody else's."""

    def _receive(self, message: Message) -> None:
        arrival, numbers = self.clock.now(), np.array(message.numbers)
        if np.isfinite(numbers).all():
            self.tell(numbers[:3], np.roll(numbers[3:], 1), arrival, message.stamp)
