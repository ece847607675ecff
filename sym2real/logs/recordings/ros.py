"""ROS 1 bags (``.bag``) and ROS 2 bags (a folder with ``metadata.yaml``, ``.db3``, or ``.mcap`` with CDR messages).

A message counts at the stamp of its header, the sensor's clock, where it has one that agrees with the recorder's clock
to within :data:`CLOCKS_AGREE`; else at the time at which it was recorded.
"""

from __future__ import annotations

from collections.abc import Iterator
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

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
    gatherers = {
        topic: Gatherer(definitions, kind)
        for topic, (kind, *others) in kinds.items()
        if not others and kind in definitions and not _is_cloud(definitions, kind)
    }
    gatherers = {topic: gatherer for topic, gatherer in gatherers.items() if gatherer.fields}
    wanted = [connection for connection in bag.connections if connection.topic in gatherers]
    if wanted:  # the library takes none as all
        for connection, stamp, data in bag.messages(connections=wanted):
            gatherers[connection.topic].add(stamp, bag.deserialize(data, connection.msgtype))
    return {topic: gatherer.messages() for topic, gatherer in gatherers.items()}


class Gatherer:
    """Stamps and numbers of one topic's messages.

    Args:
        definitions: of all types of messages in the bag.
        kind: the topic's.
    """

    def __init__(self, definitions: Any, kind: str) -> None:
        self.fields = list(_fields(definitions, kind))
        self._has_header = any(field == ("header", (_NAME, HEADER)) for field in definitions[kind][1])
        self._names = [path for path, is_list in self.fields if not is_list]
        self._numbers = [attrgetter(path) for path in self._names]
        self._lists = [(path, attrgetter(path)) for path, is_list in self.fields if is_list]
        self._recorded: list[int] = []
        self._sensed: list[int] = []
        self._rows: list[list[float]] = []
        self._parts: list[dict[str, float]] = []

    def add(self, stamp: int, message: Any) -> None:
        """Take note of a message that was recorded at a stamp in ns."""
        self._recorded.append(stamp)
        if self._has_header:
            own = message.header.stamp
            self._sensed.append(own.sec * 10**9 + own.nanosec)
        self._rows.append([get(message) for get in self._numbers])
        if self._lists:
            values = {path: get(message).tolist() for path, get in self._lists}
            self._parts.append(numbers(values))

    def messages(self) -> Messages:
        """What was gathered."""
        if not self._rows:
            return Messages((), {})
        columns = dict(zip(self._names, np.array(self._rows, dtype=float).T, strict=True))
        return Messages(self._stamps(), columns | gathered(self._parts))

    def _stamps(self) -> list[int]:
        if not self._sensed:
            return self._recorded
        apart = np.abs(np.subtract(self._sensed, self._recorded)) * 1e-9
        return self._sensed if float(np.median(apart)) <= CLOCKS_AGREE else self._recorded


def _fields(definitions: Any, kind: str, prefix: str = "") -> Iterator[tuple[str, bool]]:
    """Paths of the numbers in a type of message, and whether each is a list of them."""
    for name, (node, description) in definitions[kind][1]:
        if node == _BASE and description[0] not in NO_NUMBERS:
            yield prefix + name, False
        elif node == _NAME and description not in TIMES:
            yield from _fields(definitions, description, f"{prefix}{name}.")
        elif node in (_ARRAY, _SEQUENCE):
            (inner, what), length = description
            if inner == _BASE and what[0] not in NO_NUMBERS and length <= LONGEST_LIST:
                yield prefix + name, True


def _is_cloud(definitions: Any, kind: str) -> bool:
    """Whether a type of message is mostly bytes, as images and clouds of points are."""
    return any(
        node == _SEQUENCE and description[0] == (_BASE, ("uint8", 0)) for _, (node, description) in definitions[kind][1]
    )
