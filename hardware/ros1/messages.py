"""Messages of ROS 1 as bytes: a header, texts behind it, numbers behind them; all that poses and commands need.

Bytes, little-endian: sequence number, seconds and nanoseconds (uint32 each), the frame's name as its length (uint32)
and UTF-8; texts likewise; numbers. Definitions and their MD5 sums are those of ROS Noetic and of ackermann_msgs 1.0.
"""

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass

from hardware.errors import LinkError

HEADER = struct.Struct("<III")
LENGTH = struct.Struct("<I")
RULER = "=" * 80
NANOSECONDS = 10**9


@dataclass(frozen=True)
class Message:
    """One message.

    Args:
        stamp: of its header, s since 1970.
        frame: that its numbers are in.
        texts: behind the header.
        numbers: in the order of the type's fields.
    """

    stamp: float
    frame: str
    texts: tuple[str, ...]
    numbers: tuple[float, ...]


@dataclass(frozen=True)
class MessageType:
    """How messages of one type are written.

    Args:
        name: in ROS, ``package/Type``.
        md5sum: by which two nodes see that they mean the same.
        definition: of the type and those in it, as a bag keeps it.
        texts: names of the texts between header and numbers.
        fields: names of the numbers.
        number: "d" for float64, "f" for float32.
    """

    name: str
    md5sum: str
    definition: str
    texts: tuple[str, ...]
    fields: tuple[str, ...]
    number: str

    def encode(self, message: Message, sequence: int = 0) -> bytes:
        """The bytes of a message."""
        seconds = math.floor(message.stamp)
        nanoseconds = min(round((message.stamp - seconds) * NANOSECONDS), NANOSECONDS - 1)
        parts = [HEADER.pack(sequence % 2**32, seconds, nanoseconds), _text(message.frame)]
        parts += [_text(text) for text in message.texts]
        return b"".join([*parts, self._numbers.pack(*message.numbers)])

    def decode(self, data: bytes) -> Message:
        """The message in some bytes.

        Raises:
            LinkError: when they are none of this type.
        """
        try:
            _, seconds, nanoseconds = HEADER.unpack_from(data)
            frame, place = _read_text(data, HEADER.size)
            texts = []
            for _ in self.texts:
                text, place = _read_text(data, place)
                texts.append(text)
            numbers = self._numbers.unpack_from(data, place)
        except (struct.error, UnicodeDecodeError) as error:
            raise LinkError(f"expected a {self.name}, found {len(data)} bytes that are none ({error})") from None
        if place + self._numbers.size != len(data):
            left = len(data) - place - self._numbers.size
            raise LinkError(f"expected a {self.name}, found one with {left} bytes more behind it")
        return Message(seconds + nanoseconds / NANOSECONDS, frame, tuple(texts), numbers)

    @property
    def _numbers(self) -> struct.Struct:
        return struct.Struct(f"<{len(self.fields)}{self.number}")


def _text(text: str) -> bytes:
    content = text.encode()
    return LENGTH.pack(len(content)) + content


def _read_text(data: bytes, place: int) -> tuple[str, int]:
    (length,) = LENGTH.unpack_from(data, place)
    end = place + LENGTH.size + length
    if end > len(data):
        raise struct.error(f"a text of {length} bytes in a message of {len(data)}")
    return data[place + LENGTH.size : end].decode(), end


def _defined(own: str, *inner: tuple[str, Sequence[str]]) -> str:
    parts = [own, *(f"MSG: {name}\n" + "".join(f"{line}\n" for line in lines) for name, lines in inner)]
    return f"{RULER}\n".join(parts)


_HEADER = ("std_msgs/Header", ("uint32 seq", "time stamp", "string frame_id"))
_AXES = tuple(f"float64 {axis}" for axis in "xyz")
_QUATERNION = ("geometry_msgs/Quaternion", (*_AXES, "float64 w"))
PLACE = ("x", "y", "z", "qx", "qy", "qz", "qw")

POSE = MessageType(
    "geometry_msgs/PoseStamped",
    "d3812c3cbc69362b77dc0b19b345f8f5",
    _defined(
        "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
        _HEADER,
        ("geometry_msgs/Pose", ("geometry_msgs/Point position", "geometry_msgs/Quaternion orientation")),
        ("geometry_msgs/Point", _AXES),
        _QUATERNION,
    ),
    (),
    PLACE,
    "d",
)
TRANSFORM = MessageType(
    "geometry_msgs/TransformStamped",
    "b5764a33bfeb3588febc2682852579b0",
    _defined(
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
        _HEADER,
        ("geometry_msgs/Transform", ("geometry_msgs/Vector3 translation", "geometry_msgs/Quaternion rotation")),
        ("geometry_msgs/Vector3", _AXES),
        _QUATERNION,
    ),
    ("child_frame_id",),
    PLACE,
    "d",
)
_DRIVE = ("steering_angle", "steering_angle_velocity", "speed", "acceleration", "jerk")
ACKERMANN = MessageType(
    "ackermann_msgs/AckermannDriveStamped",
    "1fd5d7f58889cefd44d29f6653240d0c",
    _defined(
        "std_msgs/Header header\nackermann_msgs/AckermannDrive drive\n",
        _HEADER,
        ("ackermann_msgs/AckermannDrive", tuple(f"float32 {name}" for name in _DRIVE)),
    ),
    (),
    _DRIVE,
    "f",
)
