"""A log file as numbers: every numeric column as it stands there, with the lines they stand on."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sym2real.errors import DataError
from sym2real.files import require_file
from sym2real.logs import arrow_file, csv_file, parquet_file
from sym2real.logs.cells import numbers
from sym2real.logs.missing import listed
from sym2real.logs.recordings import RECORDINGS, is_bag_folder, is_card_log
from sym2real.logs.recordings.recording import BY_NAMES, ColumnKinds, Recording, put_together
from sym2real.trajectory import Array

# What physical quantities, counters and stamps in ns stay far below; its fourth power is still a number.
LARGEST = 1e30
TEXTS = (".csv", ".txt", ".tsv", ".dat")
COLUMNAR = {".parquet": parquet_file.read, ".pq": parquet_file.read}
TABLES = (*TEXTS, *COLUMNAR)
GROWING = {**COLUMNAR, ".arrow": arrow_file.read}
READERS = (*TEXTS, *GROWING, *RECORDINGS)
# Stamps in two columns, as ROS' messages have them: whole seconds, and the nanoseconds since.
SECONDS = re.compile(r"((.*?)[._/]?)secs?")
NANOSECONDS = ("nanosec", "nsecs", "nsec")
# Texts of other endings are more often about the logs beside them.
IN_FOLDERS = tuple(ending for ending in READERS if ending not in (".txt", ".dat"))


@dataclass(frozen=True, eq=False)
class Table:
    """The numeric columns of a log file.

    Args:
        path: the file.
        columns: values by the file's own column names, each ``# (rows,)``; an empty cell is NaN.
        lines: what an error calls each row (a CSV's line, counted from 1; a Parquet row, counted from 1) ``# (rows,)``.
        texts: names of the columns that hold text and were left out.
        metadata: what a file of this package says about itself (Parquet, Arrow).
        polled: whether a row has the last command that it knows of; else, of a recording, that in force halfway to the
            next row.
    """

    path: Path
    columns: Mapping[str, Array]
    lines: NDArray[np.int64]
    texts: tuple[str, ...] = ()
    metadata: Mapping[str, str] = field(default_factory=dict)
    polled: bool = True

    def __len__(self) -> int:
        return len(self.lines)

    def __getitem__(self, rows: slice | NDArray[np.bool_]) -> Table:
        """Some of the rows; they keep their line numbers."""
        columns = {name: values[rows] for name, values in self.columns.items()}
        return replace(self, columns=columns, lines=self.lines[rows])

    def with_columns(self, changed: Mapping[str, Array]) -> Table:
        """The table with other values ``# (rows,)`` in some of its columns."""
        return replace(self, columns={**self.columns, **changed})

    def column(self, name: str, purpose: str) -> Array:
        """One column ``# (rows,)`` of finite numbers.

        Raises:
            DataError: when there is no such column, or a cell is not a finite number of a size that is measured.
        """
        if name in self.texts:
            raise DataError(self.path, "numbers", "text", int(self.lines[0]), name)
        if name not in self.columns:
            raise self.without(name, purpose)
        values = self.columns[name]
        self.check_finite(name, values)
        return values

    def without(self, name: str, purpose: str, otherwise: str = "") -> DataError:
        """An error for a column that is not there: those that are, the nearest, and what else may be done."""
        holding = [column for column in self.columns if name in column]  # gyro_p_dps, not gyro_r_dps, for gyro_p
        near = holding[:1] or difflib.get_close_matches(name, self.columns, n=1, cutoff=0.5)
        hints = [f"only {listed(self.columns)}", *(f"did you mean {near_name!r}?" for near_name in near), otherwise]
        return DataError(self.path, f"a column {name!r} {purpose}", "; ".join(filter(None, hints)))

    def check_finite(self, name: str, values: Array) -> None:
        """Refuse values ``# (rows,)`` that are not finite or beyond all measure, naming the first.

        Raises:
            DataError: with row and column.
        """
        if len(bad := np.flatnonzero(~np.isfinite(values))):
            empty = "an empty cell or NaN (such rows may be left out of the file)"
            actual = empty if np.isnan(values[bad[0]]) else str(values[bad[0]])
            raise self.error("a finite number", actual, int(bad[0]), name)
        if len(bad := np.flatnonzero(np.abs(values) > LARGEST)):
            raise self.error(f"a number of at most {LARGEST:g}", f"{values[bad[0]]:g}", int(bad[0]), name)

    def error(self, expected: str, found: str, position: int, column: str | None = None) -> DataError:
        """An error at the row that stands at ``position`` of this table."""
        return DataError(self.path, expected, found, int(self.lines[position]), column)


def read_table(
    path: str | Path, wanted: Collection[str] | None = None, header: Sequence[str] = (), kinds: ColumnKinds = BY_NAMES
) -> Table:
    """Read a CSV or Parquet file, an Arrow stream, or a recording.

    Args:
        path: of the file; of a ROS 2 bag its folder.
        wanted: columns that a specification names, which decide which topics of a recording are taken; None for those
            whose names are known.
        header: names of the columns of a text file that has none.
        kinds: of columns of a recording, where their names do not say so.

    Raises:
        DataError: naming the file and, where it applies, row, column, what was expected and what was found.
        MissingDependencyError: for a recording, without the extra ``recordings``.
    """
    file = Path(path)
    kind = file_type(file)
    if kind not in READERS:
        raise DataError(file, f"a file that ends in {', '.join(READERS)}", repr(file.suffix))
    if not is_bag_folder(file):
        require_file(file)
    try:
        if kind in RECORDINGS:
            return _of_recording(file, RECORDINGS[kind](file), wanted, kinds)
        if header and kind not in TEXTS:
            raise DataError(file, "a text file, where names of the columns are given", f"{kind}, which has names")
        return table_of(file, *(csv_file.read(file, header) if kind in TEXTS else GROWING[kind](file)))
    except OSError as error:
        raise DataError(file, "a readable file", error.strerror or type(error).__name__) from None


def table_of(
    file: Path,
    names: Sequence[str],
    cells: Sequence[Array | Sequence[str]],
    first_row: int,
    metadata: Mapping[str, str],
) -> Table:
    """The table of columns by their names and cells, as numbers where they are any.

    Raises:
        DataError: for names that are none or stand twice, no rows, a column with a few cells of text, or no numbers.
    """
    _check_names(file, names, cells)
    if not len(cells[0]):
        raise DataError(file, "rows of numbers", "column names only")
    table = Table(file, {}, first_row + np.arange(len(cells[0])), metadata=metadata)
    columns = {name: numbers(table, name, values) for name, values in zip(names, cells, strict=True)}
    texts = tuple(name for name, values in columns.items() if values is None)
    if len(texts) == len(columns):
        raise DataError(file, "a column of numbers", "text in all of them", first_row)
    return replace(table, columns=whole_stamps({k: v for k, v in columns.items() if v is not None}), texts=texts)


def file_type(file: Path) -> str:
    """The ending that says how a file is read; a bag's folder and a card's ``log00`` have none of their own."""
    if is_bag_folder(file):
        return ".db3"
    return ".usd" if is_card_log(file) else file.suffix.lower()


def _of_recording(file: Path, recording: Recording, wanted: Collection[str] | None, kinds: ColumnKinds) -> Table:
    if not recording:
        raise DataError(file, "a topic with numbers", "none")
    columns = put_together(recording, wanted, kinds)
    return replace(table_of(file, [*columns], [*columns.values()], 1, {}), polled=False)


def _check_names(file: Path, names: Sequence[str], cells: Sequence[object]) -> None:
    if not names or not cells:
        raise DataError(file, "named columns", "none")
    for position, name in enumerate(names):
        if not name:
            raise DataError(file, "a name for every column", f"none for column {position + 1}", row=1)
        if name in names[:position]:
            raise DataError(file, "every column name once", "the name twice", row=1, column=name)


def whole_stamps(columns: Mapping[str, Array]) -> dict[str, Array]:
    """The columns ``# (rows,)``, where both halves of a stamp stand one column in s in the place of the first.

    It is called what both names begin with, ``header.stamp``, or ``stamp``.
    """
    joined = dict[str, Array]()
    halves = set[str]()
    for name, values in columns.items():
        match = SECONDS.fullmatch(name)
        beside = [match[1] + word for word in NANOSECONDS if match[1] + word in columns] if match else []
        whole = (match[2] or "stamp") if match and beside else name
        if whole == name or whole in columns:
            joined[name] = values
        else:
            joined[whole] = values + 1e-9 * columns[beside[0]]
            halves.add(beside[0])
    return {name: values for name, values in joined.items() if name not in halves}
