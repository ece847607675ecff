"""Messages of ROS 2 as those of :mod:`hardware.ros1.messages`: the same types, as objects of ``rclpy``."""

import importlib
import math
from operator import attrgetter
from typing import Any

from hardware.ros1.messages import ACKERMANN, NANOSECONDS, POSE, TRANSFORM, Message, MessageType
from sym2real.errors import MissingDependencyError

AXES, TURN = ("x", "y", "z"), ("x", "y", "z", "w")
# Where a message holds the numbers of a type, in the order of its fields.
PLACES = {
    POSE.name: (*(f"pose.position.{axis}" for axis in AXES), *(f"pose.orientation.{axis}" for axis in TURN)),
    TRANSFORM.name: (
        *(f"transform.translation.{axis}" for axis in AXES),
        *(f"transform.rotation.{axis}" for axis in TURN),
    ),
    ACKERMANN.name: tuple(f"drive.{name}" for name in ACKERMANN.fields),
}


def class_of(kind: MessageType) -> Any:
    """ROS 2's class of a type.

    Raises:
        MissingDependencyError: where its package is not installed.
    """
    package, name = kind.name.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), name)
    except ImportError as error:
        raise MissingDependencyError(f"{kind.name} needs the ROS 2 package {package}") from error


def decoded(kind: MessageType, heard: Any) -> Message:
    """What was heard."""
    header, texts = heard.header, tuple(str(getattr(heard, name)) for name in kind.texts)
    numbers = tuple(float(attrgetter(place)(heard)) for place in PLACES[kind.name])
    return Message(header.stamp.sec + header.stamp.nanosec / NANOSECONDS, header.frame_id, texts, numbers)


def encoded(kind: MessageType, message: Message) -> Any:
    """What is to be sent."""
    told = class_of(kind)()
    seconds = math.floor(message.stamp)
    told.header.stamp.sec = seconds
    told.header.stamp.nanosec = min(round((message.stamp - seconds) * NANOSECONDS), NANOSECONDS - 1)
    told.header.frame_id = message.frame
    for name, text in zip(kind.texts, message.texts, strict=True):
        setattr(told, name, text)
    for place, number in zip(PLACES[kind.name], message.numbers, strict=True):
        inside, _, name = place.rpartition(".")
        setattr(attrgetter(inside)(told), name, float(number))
    return told
