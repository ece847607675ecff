"""Motion capture by the name of its kind: what the library `motioncapture` knows, or a topic of ROS."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from hardware import ros2
from hardware.frame import Frame
from hardware.interfaces import MotionCapture
from hardware.motion_capture import LaboratoryCapture
from hardware.ros1 import POSE, TRANSFORM, Node
from hardware.ros1.capture import RosCapture, Topic
from sym2real.errors import UnknownNameError

NODE = "/sym2real_capture"
SETTINGS = {"ros": ("topic", "type", "master", "host"), "ros2": ("topic", "type")}
KINDS = {"PoseStamped": POSE, "TransformStamped": TRANSFORM}


@contextmanager
def capture_of(kind: str, body: str, settings: Mapping[str, str], frame: Frame) -> Iterator[MotionCapture]:
    """Motion capture that is not yet connected.

    Args:
        kind: "ros", "ros2", or as the library calls it: "vicon", "optitrack", "qualisys", "vrpn", "mock", …
        body: name of the rigid body there.
        settings: of the library for that kind; of ros and ros2 the topic (Vicon's of the body by default) and
            the type of its messages (a key of :data:`KINDS`); of ros master and host as of :class:`hardware.ros1.Node`.
        frame: of the system in the world.

    Raises:
        UnknownNameError: for a setting or a type that ros has not.
        MissingDependencyError: for ros2 without rclpy.
        LinkError: where no ROS master answers.
    """
    if kind not in SETTINGS:
        yield LaboratoryCapture(kind, body, settings, frame)
        return
    for name in settings:
        if name not in SETTINGS[kind]:
            raise UnknownNameError(f"setting of {kind}", name, SETTINGS[kind])
    topic, messages = settings.get("topic", f"/vicon/{body}/{body}"), settings.get("type", "TransformStamped")
    if messages not in KINDS:
        raise UnknownNameError("type of a pose", messages, KINDS)
    made = ros2.Node(NODE) if kind == "ros2" else Node(NODE, settings.get("master"), settings.get("host"))
    with made as node:
        yield RosCapture(node, Topic(topic, KINDS[messages]), frame)
