"""Reading and writing of Parquet files; ours say in their metadata which group a column belongs to."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sym2real.errors import DataError
from sym2real.trajectory import Array

FIRST_ROW = 1  # a Parquet file has no header line: the first row of data is row 1
PREFIX = "sym2real."
SHOWN = 200  # letters of a library's words in an error


def read(path: Path) -> tuple[list[str], list[Array | Sequence[str]], int, dict[str, str]]:
    """Column names, cells by column, the number of the first row, and this package's metadata.

    Raises:
        DataError: when the file is no Parquet file, or is cut off.
    """
    with _opened(path) as file:
        return parts(file.read(), path)


def names(path: Path) -> list[str]:
    """Column names alone; errors as of :func:`read`."""
    with _opened(path) as file:
        return list(file.schema_arrow.names)


@contextmanager
def _opened(path: Path) -> Iterator[pq.ParquetFile]:
    try:
        with path.open("rb") as file:  # pyarrow takes no name whose bytes are no text
            yield pq.ParquetFile(file, page_checksum_verification=True)
    except (pa.ArrowException, OSError, ValueError) as error:
        actual = str(error).split("\n", maxsplit=1)[0][:SHOWN]
        raise DataError(path, "a whole Parquet file", actual or type(error).__name__) from None


def parts(table: pa.Table, path: Path) -> tuple[list[str], list[Array | Sequence[str]], int, dict[str, str]]:
    """The same of a table in memory; ``path`` is where it is from."""
    cells: list[Array | Sequence[str]] = [_cells(column) for column in table.columns]
    return table.column_names, cells, FIRST_ROW, _own(path, table.schema.metadata or {})


def _own(path: Path, metadata: Mapping[bytes, bytes]) -> dict[str, str]:
    """What this package wrote about the columns; other programs' metadata may be anything."""
    prefix = PREFIX.encode()
    own = {key.decode(errors="replace"): value for key, value in metadata.items() if key.startswith(prefix)}
    return {key.removeprefix(PREFIX): _text(path, key, value) for key, value in own.items()}


def _text(path: Path, key: str, value: bytes) -> str:
    try:
        return value.decode()
    except UnicodeDecodeError as error:
        actual = f"bytes that are no UTF-8 (0x{value[error.start]:02x})"
        raise DataError(path, f"metadata under {key!r} in UTF-8", actual) from None


def _cells(column: pa.ChunkedArray) -> Array | list[str]:
    kind = column.type
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        # Stamps count in the unit of their type; a log specification names it.
        column = column.cast(pa.int64())
    if pa.types.is_boolean(kind):
        column = column.cast(pa.int8())
    if pa.types.is_decimal(kind):
        column = column.cast(pa.float64())
    if not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)):
        return ["" if cell is None else str(cell) for cell in column.to_pylist()]
    return np.array(column.to_numpy(), dtype=np.float64)


def write(path: Path, columns: Mapping[str, Array], metadata: Mapping[str, str]) -> None:
    """Write columns ``# (rows,)`` as float64, with texts by name as metadata."""
    table = pa.table({name: pa.array(values, pa.float64()) for name, values in columns.items()})
    pq.write_table(
        table.replace_schema_metadata({PREFIX + key: value for key, value in metadata.items()}),
        path,
        write_page_checksum=True,
    )
