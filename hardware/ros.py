"""What a link and motion capture need of ROS, whichever version it is."""

from collections.abc import Callable
from typing import Protocol

from hardware.ros1.messages import Message, MessageType


class RosPublisher(Protocol):
    """A topic that is sent."""

    @property
    def subscribers(self) -> int:
        """How many hear it."""

    def publish(self, message: Message) -> None:
        """Hand a message to all who hear it; it never waits for them."""


class RosNode(Protocol):
    """A node: what it sends and hears."""

    @property
    def master(self) -> str:
        """Where others are found."""

    def advertise(self, topic: str, kind: MessageType) -> RosPublisher:
        """Publish messages of a type under a topic."""

    def subscribe(self, topic: str, kind: MessageType, heard: Callable[[Message], None]) -> object:
        """Call ``heard`` with every message of a topic, from a thread of the node's own."""

    def close(self) -> None:
        """Leave; it may be called twice."""
