"""PX4's ULog: every logged message is a topic, ``vehicle_attitude``; of several instances ``vehicle_attitude_1``."""

import sys
from contextlib import redirect_stdout
from pathlib import Path

from sym2real.errors import DataError, needing
from sym2real.logs.recordings.messages import Messages, recording
from sym2real.logs.recordings.recording import Recording

STAMP = "timestamp"  # µs since boot
NOT_MEASURED = ("timestamp", "timestamp_sample")


def read(path: Path) -> Recording:
    """Topics of a ULog with their numbers.

    Raises:
        DataError: when it cannot be read.
        MissingDependencyError: without the extra ``recordings``.
    """
    with needing("reading ULog needs", "recordings"):
        from pyulog import ULog
    try:
        # The library prints its warnings, where only results go.
        with redirect_stdout(sys.stderr):
            log = ULog(str(path))
        topics = {
            f"{data.name}_{data.multi_id}" if data.multi_id else data.name: Messages(
                [int(stamp) * 1000 for stamp in data.data[STAMP]],
                {name: values for name, values in data.data.items() if name not in NOT_MEASURED},
            )
            for data in log.data_list
        }
        return recording(topics)
    except Exception as error:  # a damaged file fails anywhere in the library, with errors of any kind
        raise DataError(path, "a ULog that can be read", f"{type(error).__name__}: {error}") from None
