"""Trajectories as MCAP for Foxglove and PlotJuggler: JSON messages, a topic for each group of columns, and the pose.

The pose is a ``foxglove.PoseInFrame`` and a ``foxglove.FrameTransform`` (https://docs.foxglove.dev/docs/sdk/schemas),
which 3D panels draw without any setting. A number that is none is null, since JSON has no NaN.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sym2real.errors import needing
from sym2real.logs.pose import poses
from sym2real.logs.recordings.mcap_file import OWN, POSE, TRANSFORM
from sym2real.trajectory import Array, Trajectory

if TYPE_CHECKING:
    from mcap.writer import Writer

Columns = Mapping[str, Array]
Messages = Sequence[Mapping[str, Any]]
SCHEMAS = {POSE: "foxglove.PoseInFrame", TRANSFORM: "foxglove.FrameTransform"}
WORLD, BODY = "world", "base_link"
SECOND = 1_000_000_000  # ns


def write(
    path: Path, groups: Mapping[str, Mapping[str, Array]], trajectory: Trajectory, own: Mapping[str, str]
) -> None:
    """Write a trajectory, stamped by its own time.

    Args:
        path: of the file.
        groups: its columns ``# (rows,)`` by group and name; empty groups are left out.
        trajectory: whose pose is written too, where its state holds one.
        own: texts by name that lead back to the trajectory.

    Raises:
        MissingDependencyError: without the extra ``recordings``.
    """
    with needing("writing MCAP needs", "recordings"):
        from mcap.writer import Writer
    start = min(0.0, float(trajectory.time[0]))  # a stamp is no negative number
    stamps = [round((time - start) * SECOND) for time in trajectory.time.tolist()]
    topics: dict[str, Messages] = {f"/{group}": _rows(columns) for group, columns in groups.items() if columns}
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(library="sym2real")
        writer.add_metadata(OWN, dict(own))
        for topic, messages in {**topics, **_poses(trajectory, stamps)}.items():
            _send(writer, topic, stamps, messages)
        writer.finish()


def _rows(columns: Columns) -> Messages:
    values = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [_named(columns, row) for row in values]


def _poses(trajectory: Trajectory, stamps: Sequence[int]) -> dict[str, Messages]:
    found = poses(trajectory.layouts.state, trajectory.state)
    if found is None:
        return {}
    places, turns = (
        [_named(names, row) for row in part.tolist()] for names, part in zip(("xyz", "wxyz"), found, strict=True)
    )
    at = [{"sec": stamp // SECOND, "nsec": stamp % SECOND} for stamp in stamps]
    bodies = list(zip(at, places, turns, strict=True))
    return {
        POSE: [{"timestamp": t, "frame_id": WORLD, "pose": {"position": p, "orientation": q}} for t, p, q in bodies],
        TRANSFORM: [
            {"timestamp": t, "parent_frame_id": WORLD, "child_frame_id": BODY, "translation": p, "rotation": q}
            for t, p, q in bodies
        ],
    }


def _send(writer: Writer, topic: str, stamps: Sequence[int], messages: Messages) -> None:
    schema = json.dumps(_schema(messages[0])).encode()
    kind = writer.register_schema(SCHEMAS.get(topic, f"sym2real{topic.replace('/', '.')}"), "jsonschema", schema)
    channel = writer.register_channel(topic, "json", kind)
    for stamp, message in zip(stamps, messages, strict=True):
        writer.add_message(channel, stamp, json.dumps(message, allow_nan=False).encode(), stamp)


def _schema(value: object) -> dict[str, Any]:
    """The JSON schema of a message, which viewers ask for before they plot."""
    if isinstance(value, Mapping):
        return {"type": "object", "properties": {key: _schema(part) for key, part in value.items()}}
    return {"type": "string" if isinstance(value, str) else "number"}


def _named(names: Mapping[str, Any] | str, row: Sequence[float]) -> dict[str, float | None]:
    return {name: value if math.isfinite(value) else None for name, value in zip(names, row, strict=True)}
