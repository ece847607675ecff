"""Messages of one topic as columns: stamps and numbers gathered one by one, arrays at the end."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sym2real.logs.recordings.recording import Recording, Topic
from sym2real.trajectory import Array

# Longer lists are clouds, images and covariances, not a robot's state.
LONGEST_LIST = 16
NANOSECONDS = 1e9  # in a second


@dataclass(frozen=True, eq=False)
class Messages:
    """What a file holds of one topic.

    Args:
        nanoseconds: when, by one clock for all topics ``# (messages,)``.
        columns: numbers by field ``# (messages,)``.
    """

    nanoseconds: Sequence[int]
    columns: Mapping[str, Array]


def recording(topics: Mapping[str, Messages]) -> Recording:
    """The topics that hold numbers; stamps count from the first of all messages, so that no digit is lost."""
    filled = {name: messages for name, messages in topics.items() if messages.columns and len(messages.nanoseconds)}
    stamps = {name: np.asarray(messages.nanoseconds, dtype=np.int64) for name, messages in filled.items()}
    start = min((values.min() for values in stamps.values()), default=0)
    return tuple(
        Topic(
            name,
            (stamps[name] - start) / NANOSECONDS,
            {
                f"{name}.{field}": np.asarray(values, float)
                for field, values in messages.columns.items()
                if not np.isnan(values).all()
            },
        )
        for name, messages in filled.items()
    )


def numbers(value: object, prefix: str = "") -> dict[str, float]:
    """The numbers in nested mappings and short lists by their paths: ``pose.position.x``, ``q[0]``; null is NaN."""
    if isinstance(value, bool | int | float):
        return {prefix: float(value)}
    if value is None:
        return {prefix: np.nan}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, Mapping):
        items = [(f"{prefix}.{key}" if prefix else str(key), part) for key, part in value.items()]
    elif isinstance(value, list) and len(value) <= LONGEST_LIST:
        items = [(f"{prefix}[{place}]", part) for place, part in enumerate(value)]
    else:
        return {}
    return {path: number for key, part in items for path, number in numbers(part, key).items()}


def gathered(rows: Sequence[Mapping[str, float]]) -> dict[str, Array]:
    """Columns ``# (rows,)`` of rows that may differ in what they hold; NaN where one does not hold it."""
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}
