"""ROS 1 bags (``.bag``) and ROS 2 bags (a folder with ``metadata.yaml``, ``.db3``, or ``.mcap`` with CDR messages).

A message counts at the stamp of its header, the sensor's clock, where it has one that agrees with the recorder's clock
to within :data:`CLOCKS_AGREE`; else at the time at which it was recorded.
"""

from collections.abc import Iterator, Sequence
from operator import attrgetter
from pathlib import Path
from statistics import median
from typing import Any

from sym2real.errors import DataError, needing
from sym2real.logs.recordings.messages import LONGEST_LIST, Messages, gathered, numbers, recording
from sym2real.logs.recordings.recording import Recording

CLOCKS_AGREE = 1.0  # s; two machines whose clocks are set by a server agree to milliseconds, others to minutes
HEADER = "std_msgs/msg/Header"
TIMES = frozenset({"builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration", HEADER})
NO_NUMBERS = frozenset({"string", "wstring"})
METADATA = "metadata.yaml"
_BASE, _NAME, _ARRAY, _SEQUENCE = 1, 2, 3, 4  # rosbags.interfaces.Nodetype, which is there only with the extra


def is_bag_folder(path: Path) -> bool:
    """Whether a folder is a ROS 2 bag."""
    return (path / METADATA).is_file()


def read(path: Path) -> Recording:
    """Topics of a bag with their numbers.

    Raises:
        DataError: when it cannot be read, or no topic holds numbers.
        MissingDependencyError: without the extra ``recordings``.
    """
    with needing("reading bags needs", "recordings"):
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    try:
        # Bags of before ROS 2 Iron hold no definitions: those of the last release with them are taken.
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as bag:
            return recording(_topics(bag))
    except Exception as error:  # a damaged bag fails anywhere in the library, with errors of any kind
        raise DataError(path, "a ROS bag that can be read", f"{type(error).__name__}: {error}") from None


def _topics(bag: Any) -> dict[str, Messages]:
    """All topics in one pass: a bag of hours is read once."""
    definitions = bag.typestore.fielddefs
    kinds: dict[str, set[str]] = {}
    for connection in bag.connections:
        kinds.setdefault(connection.topic, set()).add(connection.msgtype)
    fields = {
        topic: [(path, attrgetter(path)) for path in _fields(definitions, kind)]
        for topic, (kind, *others) in kinds.items()
        if not others and kind in definitions and not _is_cloud(definitions, kind)
    }
    stamps: dict[str, list[tuple[int, int]]] = {topic: [] for topic, getters in fields.items() if getters}
    rows: dict[str, list[dict[str, float]]] = {topic: [] for topic in stamps}
    wanted = [connection for connection in bag.connections if connection.topic in stamps]
    for connection, recorded, data in bag.messages(connections=wanted) if wanted else ():  # none is all to the library
        topic, message = connection.topic, bag.deserialize(data, connection.msgtype)
        sensed = recorded
        if ("header", (_NAME, HEADER)) in definitions[connection.msgtype][1]:
            sensed = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        stamps[topic].append((sensed, recorded))
        rows[topic].append(numbers({path: get(message) for path, get in fields[topic]}))
    return {topic: Messages(_clock(stamps[topic]), gathered(rows[topic])) for topic in stamps}


def _clock(stamps: Sequence[tuple[int, int]]) -> list[int]:
    """The sensor's, where it agrees with the recorder's, in ns."""
    apart = [1e-9 * abs(sensed - recorded) for sensed, recorded in stamps]
    clock = 0 if apart and median(apart) <= CLOCKS_AGREE else 1
    return [both[clock] for both in stamps]


def _fields(definitions: Any, kind: str, prefix: str = "") -> Iterator[str]:
    """Paths of the numbers, and of lists of them, in a type of message."""
    for name, (node, description) in definitions[kind][1]:
        if node == _NAME and description not in TIMES:
            yield from _fields(definitions, description, f"{prefix}{name}.")
            continue
        (inner, what), length = description if node in (_ARRAY, _SEQUENCE) else ((node, description), 0)
        if inner == _BASE and what[0] not in NO_NUMBERS and length <= LONGEST_LIST:
            yield prefix + name


def _is_cloud(definitions: Any, kind: str) -> bool:
    """Whether a type of message is mostly bytes, as images and clouds of points are."""
    return any(
        node == _SEQUENCE and description[0] == (_BASE, ("uint8", 0)) for _, (node, description) in definitions[kind][1]
    )
