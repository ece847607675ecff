"""The Crazyflie's log on its micro SD card (``log00``, ``log01`` …, or named ``.usd``), versions 1 and 2.

Bytes, little-endian: 0xBC; version and number of kinds of events, uint16; per kind its number (uint16), its name with a
zero behind, its number of variables (uint16), each variable's name and type as ``name(f)`` with a zero behind; then
events: number (uint16), stamp (uint32 in ms in version 1, uint64 in µs in version 2), values; a CRC-32 of the rest.
Source: Bitcraze, documentation of the micro SD card deck.
"""

import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

import numpy as np

from sym2real.errors import DataError
from sym2real.logs.recordings.messages import Messages, recording
from sym2real.logs.recordings.recording import Recording
from sym2real.trajectory import Array

MAGIC = 0xBC
HEADER = struct.Struct("<BHH")
COUNT = struct.Struct("<H")
CHECK = struct.Struct("<I")
STAMPS = {1: ("I", 10**6), 2: ("Q", 10**3)}  # type and ns of a tick, by version
VARIABLE = re.compile(r"(.+)\(([bBhHiIefd])\)")


@dataclass(frozen=True)
class Event:
    """One kind of events.

    Args:
        name: of the topic.
        variables: their names.
        row: of its number, its stamp and its values.
    """

    name: str
    variables: tuple[str, ...]
    row: np.dtype[np.void]


def is_card_log(path: Path) -> bool:
    """Whether a file has the name that the firmware gives, and begins as its logs do."""
    if path.suffix or not path.name.startswith("log") or not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(1) == bytes([MAGIC])


def read(path: Path) -> Recording:
    """Topics of a card's log with their numbers; one whose end is missing is read as far as it goes.

    Raises:
        DataError: when it is none, or damaged before its end.
    """
    content = path.read_bytes()
    if len(content) < HEADER.size or content[0] != MAGIC:
        raise DataError(path, "a Crazyflie's log, which begins with 0xbc", content[:1].hex() or "an empty file")
    _, version, kinds = HEADER.unpack_from(content)
    if version not in STAMPS:
        raise DataError(path, "a Crazyflie's log of version 1 or 2", f"version {version}")
    try:
        events, place = _events(content, kinds, STAMPS[version][0])
    except (struct.error, ValueError) as error:
        raise DataError(path, "the kinds of events at the head of a Crazyflie's log", str(error)) from None
    closed = len(content) >= place + CHECK.size and crc32(content[: -CHECK.size]) == CHECK.unpack(content[-4:])[0]
    rows = _rows(path, memoryview(content)[: -CHECK.size if closed else None], place, events, closed)
    tick = STAMPS[version][1]
    return recording(
        {
            event.name: Messages((table["stamp"].astype(np.int64) * tick).tolist(), _columns(event, table))
            for event, table in rows.items()
        }
    )


def _events(content: bytes, kinds: int, stamp: str) -> tuple[dict[int, Event], int]:
    """Kinds of events by their numbers, and where the first event begins."""
    place = HEADER.size
    events = {}
    for _ in range(kinds):
        (number,) = COUNT.unpack_from(content, place)
        name, place = _text(content, place + COUNT.size)
        (variables,) = COUNT.unpack_from(content, place)
        place += COUNT.size
        columns: dict[str, str] = {}
        for _ in range(variables):
            text, place = _text(content, place)
            match = VARIABLE.fullmatch(text)
            if match is None or match[1] in columns:
                raise ValueError(f"{text!r}, where name(type) stands, every name once")
            columns[match[1]] = f"<{match[2]}"
        fields = [("number", "<H"), ("stamp", f"<{stamp}"), *((f"_{name}", kind) for name, kind in columns.items())]
        events[number] = Event(name, tuple(columns), np.dtype(fields))
    return events, place


def _text(content: bytes, place: int) -> tuple[str, int]:
    end = content.index(b"\0", place)
    return content[place:end].decode(), end + 1


def _rows(
    path: Path, content: memoryview, place: int, events: Mapping[int, Event], closed: bool
) -> dict[Event, np.ndarray]:
    """Events of each kind as a structured array."""
    parts: dict[int, list[memoryview]] = {number: [] for number in events}
    while place + COUNT.size <= len(content):
        (number,) = COUNT.unpack_from(content, place)
        if number not in events:
            if closed:
                raise DataError(path, f"an event at byte {place} of a kind in {sorted(events)}", str(number))
            break  # what an open file's last block holds behind its last event
        size = events[number].row.itemsize
        if place + size > len(content):
            break
        parts[number].append(content[place : place + size])
        place += size
    filled = {events[number]: b"".join(rows) for number, rows in parts.items() if rows}
    return {event: np.frombuffer(rows, dtype=event.row) for event, rows in filled.items()}


def _columns(event: Event, table: np.ndarray) -> dict[str, Array]:
    return {name: table[f"_{name}"].astype(np.float64) for name in event.variables}
