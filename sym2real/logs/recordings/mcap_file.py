"""MCAP files: JSON messages here, CDR messages (ROS 2) by :mod:`sym2real.logs.recordings.ros`."""

import json
from collections import defaultdict
from pathlib import Path

from sym2real.errors import DataError, needing
from sym2real.logs.recordings import ros
from sym2real.logs.recordings.messages import Messages, gathered, numbers, recording
from sym2real.logs.recordings.recording import Recording


def read(path: Path) -> Recording:
    """Topics of an MCAP file with their numbers.

    Raises:
        DataError: when it cannot be read, or its messages are neither CDR nor JSON.
        MissingDependencyError: without the extra ``recordings``.
    """
    with needing("reading MCAP needs", "recordings"):
        from mcap.reader import make_reader
    stamps: defaultdict[str, list[int]] = defaultdict(list)
    rows: defaultdict[str, list[dict[str, float]]] = defaultdict(list)
    encodings: set[str] = set()
    try:
        with path.open("rb") as file:
            reader = make_reader(file)
            for _, channel, message in reader.iter_messages(log_time_order=False):
                encodings.add(channel.message_encoding)
                if channel.message_encoding == "json":
                    stamps[channel.topic].append(message.publish_time or message.log_time)
                    rows[channel.topic].append(numbers(json.loads(message.data)))
                elif encodings == {"cdr"}:
                    break
    except Exception as error:  # a damaged file fails anywhere in the library, with errors of any kind
        raise DataError(path, "an MCAP file that can be read", f"{type(error).__name__}: {error}") from None
    if encodings == {"cdr"}:
        return ros.read(path)
    if "json" not in encodings:
        actual = f"messages in {', '.join(sorted(encodings))}" if encodings else "no message"
        raise DataError(path, "messages in json or cdr", actual)
    return recording({name: Messages(stamps[name], gathered(rows[name])) for name in rows})
