"""A recorded exchange in the place of ``rclpy``, where no ROS 2 is installed.

What a node hears comes from a ROS 2 bag; what it sends must be messages that ROS 2 can write as bytes (CDR), by the
same definitions, or it fails. It stands in for the modules that :mod:`hardware.ros2` loads, and offers what it uses.
"""

import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from recordings import ACKERMANN, stores
from rosbags.rosbag2 import Reader
from rosbags.typesys import get_types_from_msg

STAMPED = "ackermann_msgs/msg/AckermannDriveStamped"
SUBSCRIBERS = 1  # that the recorded car's multiplexer was
ZERO: dict[str, Any] = {"string": "", "float32": 0.0, "float64": 0.0, "int32": 0, "uint32": 0}


class Replay:
    """The exchange.

    Args:
        bag: folder of a ROS 2 bag, whose messages are heard at their pace.

    Attributes:
        sent: bytes by topic.
    """

    def __init__(self, bag: Path) -> None:
        self.bag, self.sent = bag, dict[str, list[bytes]]()
        self.store = stores(2)
        self.store.register(get_types_from_msg(f"std_msgs/Header header\n{ACKERMANN} drive", STAMPED))
        self.over = threading.Event()

    def install(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """In the place of the real modules, until the test ends."""
        executors, qos, rclpy = (ModuleType(name) for name in ("rclpy.executors", "rclpy.qos", "rclpy"))
        rclpy.Context = lambda: SimpleNamespace(try_shutdown=self.over.set)  # type: ignore[attr-defined]
        rclpy.init = lambda context: None  # type: ignore[attr-defined]
        rclpy.create_node = lambda name, context: self  # type: ignore[attr-defined]
        executors.SingleThreadedExecutor = lambda context: self  # type: ignore[attr-defined]
        qos.qos_profile_sensor_data = "best effort"  # type: ignore[attr-defined]
        modules = {"rclpy": rclpy, "rclpy.executors": executors, "rclpy.qos": qos}
        for package in ("geometry_msgs", "ackermann_msgs"):
            modules[package], modules[f"{package}.msg"] = ModuleType(package), ModuleType(f"{package}.msg")
        for name in ("geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/TransformStamped", STAMPED):
            package, _, short = name.split("/")
            setattr(modules[f"{package}.msg"], short, self._class(name))
        for name, module in modules.items():
            monkeypatch.setitem(sys.modules, name, module)

    def create_subscription(self, kind: Any, topic: str, heard: Callable[[Any], None], qos: str) -> object:
        assert qos == "best effort", "motion capture's bridges do not repeat what was lost"

        def replay() -> None:
            with Reader(self.bag) as reader:
                first, begin = reader.start_time, time.monotonic()
                for connection, stamp, raw in reader.messages():
                    if connection.topic == topic and connection.msgtype == kind.NAME:
                        time.sleep(max(0.0, begin + (stamp - first) / 1e9 - time.monotonic()))
                        if self.over.is_set():
                            return
                        heard(self.store.deserialize_cdr(raw, connection.msgtype))

        threading.Thread(target=replay, daemon=True).start()
        return object()

    def create_publisher(self, kind: Any, topic: str, depth: int) -> Any:
        def publish(message: Any) -> None:
            self.sent.setdefault(topic, []).append(bytes(self.store.serialize_cdr(self._typed(message), kind.NAME)))

        return SimpleNamespace(publish=publish, get_subscription_count=lambda: SUBSCRIBERS)

    def add_node(self, node: object) -> None:
        """It spins one node."""

    def spin(self) -> None:
        self.over.wait()

    def shutdown(self) -> None:
        self.over.set()

    def destroy_node(self) -> None:
        """Nothing is held."""

    def _class(self, name: str) -> type:
        """As ROS 2's are made: without arguments, every field at zero."""

        def fill(message: Any) -> None:
            for field, (_, kind) in self.store.fielddefs[name][1]:
                of = kind[0] if isinstance(kind, tuple) else kind
                setattr(message, field, ZERO[of] if of in ZERO else self._class(of)())

        return type(name.rsplit("/", 1)[1], (), {"__init__": fill, "NAME": name})

    def _typed(self, message: Any) -> Any:
        if not hasattr(message, "NAME"):
            return message
        fields = self.store.fielddefs[message.NAME][1]
        return self.store.types[message.NAME](*(self._typed(getattr(message, field)) for field, _ in fields))
