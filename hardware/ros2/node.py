"""A node of ROS 2: the one file that imports ``rclpy``, inside its functions: a ROS installation brings it, not pip."""

import os
import threading
from collections.abc import Callable
from typing import Any

from hardware.closing import Closing
from hardware.ros1.messages import Message, MessageType
from hardware.ros2.messages import class_of, decoded, encoded
from sym2real.errors import MissingDependencyError

NEWEST = 1  # message that waits: an old command is worth nothing


class Publisher:
    """A :class:`~hardware.ros.RosPublisher`.

    Args:
        publisher: of rclpy.
        kind: of its messages.
    """

    def __init__(self, publisher: Any, kind: MessageType) -> None:
        self._publisher, self._kind = publisher, kind

    @property
    def subscribers(self) -> int:
        """How many hear it."""
        return int(self._publisher.get_subscription_count())

    def publish(self, message: Message) -> None:
        """Hand a message to all who hear it."""
        self._publisher.publish(encoded(self._kind, message))


class Node(Closing):
    """A :class:`~hardware.ros.RosNode` in a context of its own, so that Ctrl-C stays the launch script's.

    Args:
        name: in ROS.

    Raises:
        MissingDependencyError: without ``rclpy``.
    """

    def __init__(self, name: str) -> None:
        try:
            import rclpy  # noqa: PLC0415 — it comes with ROS
            from rclpy.executors import SingleThreadedExecutor  # noqa: PLC0415
        except ImportError as error:
            raise MissingDependencyError(
                "ROS 2 needs rclpy: source /opt/ros/DISTRIBUTION/setup.bash, with the Python that belongs to it"
            ) from error
        self.master = f"ROS 2, domain {os.environ.get('ROS_DOMAIN_ID', '0')}"
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node(name.lstrip("/"), context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._executor.spin, name="ROS 2", daemon=True)
        self._thread.start()
        self._open = True

    def advertise(self, topic: str, kind: MessageType) -> Publisher:
        """Publish messages of a type under a topic."""
        return Publisher(self._node.create_publisher(class_of(kind), topic, NEWEST), kind)

    def subscribe(self, topic: str, kind: MessageType, heard: Callable[[Message], None]) -> object:
        """Call ``heard`` with every message of a topic, also of publishers that do not repeat what was lost."""
        from rclpy.qos import qos_profile_sensor_data  # noqa: PLC0415

        def receive(message: Any) -> None:
            heard(decoded(kind, message))

        return self._node.create_subscription(class_of(kind), topic, receive, qos_profile_sensor_data)

    def close(self) -> None:
        """Leave; it may be called twice."""
        if self._open:
            self._open = False
            self._executor.shutdown()
            self._node.destroy_node()
            self._context.try_shutdown()
            self._thread.join(1.0)
