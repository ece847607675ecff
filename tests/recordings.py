"""Recordings as the real writers make them: bags and MCAP by their libraries; ULog and the Crazyflie's card by the
layout that their makers document, since nobody ships a writer."""

import json
import struct
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Bag1
from rosbags.rosbag2 import StoragePlugin, Writer as Bag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

Columns = Mapping[str, np.ndarray]
EPOCH = 1_700_000_000 * 10**9  # ns; bags count from 1970
ACKERMANN = "ackermann_msgs/msg/AckermannDrive"
POSE, DRIVE = "/car/pose", "/car/command"


def stores(ros: int) -> Any:
    store = get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_HUMBLE)
    text = "float32 steering_angle\nfloat32 steering_angle_velocity\nfloat32 speed\nfloat32 acceleration\nfloat32 jerk"
    store.register(get_types_from_msg(text, ACKERMANN))
    return store


def pose(store: Any, nanoseconds: int, x: float, y: float, yaw: float) -> Any:
    types = store.types
    stamp = types["builtin_interfaces/msg/Time"](nanoseconds // 10**9, nanoseconds % 10**9)
    header_type = types["std_msgs/msg/Header"]
    header = header_type(0, stamp, "map") if "seq" in header_type.__annotations__ else header_type(stamp, "map")
    place = types["geometry_msgs/msg/Point"](x, y, 0.0)
    turned = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2))
    return types["geometry_msgs/msg/PoseStamped"](header, types["geometry_msgs/msg/Pose"](place, turned))


def write_bag(path: Path, ros: int, poses: Columns, commands: Columns, late: float = 0.0) -> Path:
    """A ROS 1 bag, or a ROS 2 bag's folder, of a car's poses and commands.

    Args:
        path: of the file or folder.
        ros: 1 or 2.
        poses: t, x, y, yaw.
        commands: t, steer, speed.
        late: s from a pose's own stamp to its recording.
    """
    store = stores(ros)
    writer: Any = Bag1(path) if ros == 1 else Bag2(path, version=9, storage_plugin=StoragePlugin.SQLITE3)
    encode: Callable[[Any, str], Any] = store.serialize_ros1 if ros == 1 else store.serialize_cdr
    with writer as bag:
        place = bag.add_connection(POSE, "geometry_msgs/msg/PoseStamped", typestore=store)
        drive = bag.add_connection(DRIVE, ACKERMANN, typestore=store)
        rows = []
        for t, x, y, yaw in zip(*(poses[name] for name in ("t", "x", "y", "yaw")), strict=True):
            stamp = EPOCH + round(t * 1e9)
            message = pose(store, stamp, float(x), float(y), float(yaw))
            rows.append((stamp + round(late * 1e9), place, encode(message, "geometry_msgs/msg/PoseStamped")))
        for t, steer, speed in zip(*(commands[name] for name in ("t", "steer", "speed")), strict=True):
            message = store.types[ACKERMANN](float(steer), 0.0, float(speed), 0.0, 0.0)
            rows.append((EPOCH + round(t * 1e9), drive, encode(message, ACKERMANN)))
        for stamp, connection, data in sorted(rows, key=lambda row: row[0]):
            bag.write(connection, stamp, data)
    return path


def write_mcap(path: Path, topics: Mapping[str, Columns]) -> Path:
    """An MCAP file with JSON messages; dots in a column's name nest."""
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        for topic, columns in topics.items():
            schema = writer.register_schema(topic, "jsonschema", b'{"type": "object"}')
            channel = writer.register_channel(topic, "json", schema)
            for place, t in enumerate(columns["t"]):
                message: dict[str, Any] = {"frame": "map"}
                for name in columns.keys() - {"t"}:
                    *parents, leaf = name.split(".")
                    inner = message
                    for parent in parents:
                        inner = inner.setdefault(parent, {})
                    inner[leaf] = float(columns[name][place])
                stamp = EPOCH + round(t * 1e9)
                writer.add_message(channel, stamp, json.dumps(message).encode(), stamp)
        writer.finish()
    return path


def write_ulog(path: Path, topics: Mapping[str, Columns]) -> Path:
    """A ULog of version 1, as https://docs.px4.io (ULog File Format) lays it out."""

    def message(kind: str, data: bytes) -> bytes:
        return struct.pack("<HB", len(data), ord(kind)) + data

    content = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)
    names = {topic: [name for name in columns if name != "t"] for topic, columns in topics.items()}
    for topic, fields in names.items():
        groups: dict[str, int] = {}
        for name in fields:
            groups[name.split("[")[0]] = groups.get(name.split("[")[0], 0) + 1
        declared = [f"float[{size}] {name}" if size > 1 else f"float {name}" for name, size in groups.items()]
        content += message("F", f"{topic}:{';'.join(['uint64_t timestamp', *declared])};".encode())
    for number, topic in enumerate(topics):
        content += message("A", struct.pack("<BH", 0, number) + topic.encode())
    for number, (topic, columns) in enumerate(topics.items()):
        for place, t in enumerate(columns["t"]):
            values = [columns[name][place] for name in names[topic]]
            row = struct.pack(f"<HQ{len(values)}f", number, round(t * 1e6), *values)
            content += message("D", row)
    path.write_bytes(content)
    return path


def write_card(path: Path, topics: Mapping[str, Columns], version: int = 2) -> Path:
    """A Crazyflie's log, as Bitcraze's page on the micro SD card deck lays it out."""
    content = struct.pack("<BHH", 0xBC, version, len(topics))
    rows = []
    for number, (topic, columns) in enumerate(topics.items()):
        names = [name for name in columns if name != "t"]
        content += struct.pack("<H", number) + topic.encode() + b"\0" + struct.pack("<H", len(names))
        content += b"".join(f"{name}(f)".encode() + b"\0" for name in names)
        for place, t in enumerate(columns["t"]):
            stamp = struct.pack("<I", round(t * 1e3)) if version == 1 else struct.pack("<Q", round(t * 1e6))
            values = struct.pack(f"<{len(names)}f", *(columns[name][place] for name in names))
            rows.append((t, struct.pack("<H", number) + stamp + values))
    content += b"".join(row for _, row in sorted(rows, key=lambda row: row[0]))
    path.write_bytes(content + struct.pack("<I", crc32(content)))
    return path
