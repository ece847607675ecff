"""Motion capture by the name of its kind: what the library `motioncapture` knows, or a topic of ROS."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from hardware.frame import Frame
from hardware.interfaces import MotionCapture
from hardware.motion_capture import LaboratoryCapture
from hardware.ros1 import POSE, TRANSFORM, Node
from hardware.ros1.capture import RosCapture, Topic
from sym2real.errors import UnknownNameError

NODE = "/sym2real_capture"
ROS, SETTINGS = "ros", ("topic", "type", "master", "host")
KINDS = {"PoseStamped": POSE, "TransformStamped": TRANSFORM}


@contextmanager
def capture_of(kind: str, body: str, settings: Mapping[str, str], frame: Frame) -> Iterator[MotionCapture]:
    """Motion capture that is not yet connected.

    Args:
        kind: "ros", or as the library calls it: "vicon", "optitrack", "qualisys", "vrpn", "mock", …
        body: name of the rigid body there.
        settings: of the library for that kind; of ros the topic (Vicon's of the body by default), the type of its
            messages (a key of :data:`KINDS`), master and host as of :class:`hardware.ros1.Node`.
        frame: of the system in the world.

    Raises:
        UnknownNameError: for a setting or a type that ros has not.
        LinkError: where no ROS master answers.
    """
    if kind != ROS:
        yield LaboratoryCapture(kind, body, settings, frame)
        return
    for name in settings:
        if name not in SETTINGS:
            raise UnknownNameError("setting of ros", name, SETTINGS)
    topic, messages = settings.get("topic", f"/vicon/{body}/{body}"), settings.get("type", "TransformStamped")
    if messages not in KINDS:
        raise UnknownNameError("type of a pose", messages, KINDS)
    with Node(NODE, settings.get("master"), settings.get("host")) as node:
        yield RosCapture(node, Topic(topic, KINDS[messages]), frame)
