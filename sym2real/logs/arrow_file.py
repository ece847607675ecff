"""Arrow streams: logs that grow while they are flown, and are whole up to their last batch whenever somebody reads.

A Parquet file without its footer is unreadable; a stream that a killed process leaves behind is not.
"""

from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa

from sym2real.errors import DataError
from sym2real.logs import parquet_file
from sym2real.trajectory import Array


def read(path: Path) -> tuple[list[str], list[Array | Sequence[str]], int, dict[str, str]]:
    """Column names, cells by column, the number of the first row, and this package's metadata.

    A last batch that is cut off is left out.

    Raises:
        DataError: when the file is no Arrow stream.
    """
    return parquet_file.parts(whole_batches(path), path)


def whole_batches(path: Path) -> pa.Table:
    """Rows of all batches that are whole; see :func:`read`."""
    try:
        with path.open("rb") as file, pa.ipc.open_stream(file) as stream:
            batches, schema = [], stream.schema
            while True:
                try:
                    batches.append(stream.read_next_batch())
                except (StopIteration, pa.ArrowException, OSError):  # the end, or a batch that is cut off
                    return pa.Table.from_batches(batches, schema)
    except pa.ArrowException as error:
        raise DataError(path, "an Arrow stream", str(error).split("\n", maxsplit=1)[0]) from None
