"""Logs that grow while they are flown: Arrow streams, which :mod:`sym2real.logs.arrow_file` reads."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from sym2real.errors import DataError, reason
from sym2real.logs import arrow_file, parquet_file


def prepare() -> None:
    """Load what the first batch loads, pandas among it where it is installed: that takes part of a second."""
    pa.RecordBatch.from_pylist([{"loaded": 0.0}])


class ArrowStream:
    """A file that rows are appended to; what has been appended survives the process.

    Args:
        path: of a new file.
        columns: name → whether it holds text; else float64.
        metadata: texts by name, as of a Parquet file of this package.

    Raises:
        DataError: when there is no writing there.
    """

    def __init__(self, path: Path, columns: Mapping[str, bool], metadata: Mapping[str, str]) -> None:
        fields = [pa.field(name, pa.string() if text else pa.float64()) for name, text in columns.items()]
        own = {parquet_file.PREFIX + key: value for key, value in metadata.items()}
        self._schema = pa.schema(fields, metadata=own)
        try:
            self._file = path.open("xb")
        except OSError as error:
            raise DataError(path, "a new file", reason(error)) from error
        self._writer = pa.ipc.new_stream(self._file, self._schema)

    def append(self, rows: Sequence[Mapping[str, float | str]]) -> None:
        """Rows by column, which are with the operating system when this returns."""
        self._writer.write_batch(pa.RecordBatch.from_pylist(list(rows), self._schema))
        self._file.flush()

    def close(self) -> None:
        """End the stream."""
        self._writer.close()
        self._file.close()


def to_parquet(stream: Path, target: Path) -> None:
    """Write a stream's whole batches as a Parquet file."""
    pq.write_table(arrow_file.whole_batches(stream), target)
