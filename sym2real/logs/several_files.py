"""One log in several files: which belong together, and the table that they make.

Logs of one kind have the same columns, parts of one log have none in common but the stamps. Where the parts have stamps
they are put together by these, like the topics of a recording; else row by row. Commands may be one row fewer than
states: nothing was sent after the last state, where the last command stands on.
"""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sym2real.errors import DataError
from sym2real.logs import csv_file, parquet_file
from sym2real.logs.names import is_time
from sym2real.logs.recordings.recording import BY_NAMES, TIME, ColumnKinds, Topic, put_together
from sym2real.logs.table import TABLES, TEXTS, Table, file_type, read_table
from sym2real.trajectory import Array

LogFiles = tuple[Path, ...]


def files_by_log(files: Sequence[Path], header: Sequence[str] = ()) -> list[LogFiles]:
    """The files of each log.

    Args:
        files: in the order given: the first of every kind are the first log, and so on.
        header: names of the columns of files that have none, which are dealt out to files in a row.

    Raises:
        DataError: for a file whose columns cannot be read, for parts that are not as many of each kind, or where
            files without a header have another number of columns than there are names.
    """
    if len(files) < 2 or not all(file.is_file() and file_type(file) in TABLES for file in files):
        return [(file,) for file in files]
    if header:
        return _by_number(files, len(header))
    kinds: dict[frozenset[str], list[Path]] = {}
    for file in files:
        kinds.setdefault(frozenset(name for name in _names(file) if not is_time(name)), []).append(file)
    if len(kinds) == 1 or len(frozenset.union(*kinds)) < sum(map(len, kinds)):
        return [(file,) for file in files]
    parts, counts = [*kinds.values()], {len(part) for part in kinds.values()}
    if len(counts) > 1:
        actual = " and ".join(f"{len(part)} like {part[0].name}" for part in parts)
        raise DataError(parts[-1][0], "logs with the same columns, or as many files of each part of a log", actual)
    return [*zip(*parts, strict=True)]


def read_parts(
    files: LogFiles, wanted: Sequence[str] | None = None, header: Sequence[str] = (), kinds: ColumnKinds = BY_NAMES
) -> Table:
    """The one table of a log's files; arguments and errors as of :func:`~sym2real.logs.table.read_table`.

    Raises:
        DataError: also for files whose rows do not belong together.
    """
    tables, rest = list[Table](), list(header)
    for file in files:
        own = rest[: len(_names(file))] if header and len(files) > 1 else rest
        rest = rest[len(own) :]
        tables.append(read_table(file, wanted, own, kinds))
    if len(tables) == 1:
        return tables[0]
    shared = set.intersection(*({*table.columns} for table in tables))
    clock = next((name for name in tables[0].columns if name in shared and is_time(name)), "")
    if clock and not _same_stamps(tables, clock):
        return _by_stamps(tables, clock, kinds)
    return _row_by_row(tables)


def _by_number(files: Sequence[Path], wanted: int) -> list[LogFiles]:
    """Files in a row that have so many columns together."""
    logs: list[list[Path]] = [[]]
    width = 0
    for file in files:
        if width >= wanted:
            logs.append([])
            width = 0
        logs[-1].append(file)
        width += len(_names(file))
        if width > wanted:
            raise DataError(
                file, f"{wanted} columns, as many as are named (alone or with the files before it)", f"{width}"
            )
    return [tuple(parts) for parts in logs]


def _names(file: Path) -> list[str]:
    """Names of a file's columns; of one without a header the numbers of its first row."""
    return csv_file.first_cells(file) if file_type(file) in TEXTS else parquet_file.names(file)


def _same_stamps(tables: Sequence[Table], clock: str) -> bool:
    """Whether the rows of all tables were taken together, but for a last one."""
    fewest = min(len(table) for table in tables)
    first = tables[0].columns[clock][:fewest]
    alike = all(np.array_equal(table.columns[clock][:fewest], first) for table in tables)
    return alike and max(len(table) for table in tables) <= fewest + 1


def _by_stamps(tables: Sequence[Table], clock: str, kinds: ColumnKinds) -> Table:
    """Rows of the fastest, the others interpolated or held."""
    recording = tuple(
        Topic(
            table.path.stem,
            table.column(clock, "of time stamps"),
            {k: v for k, v in table.columns.items() if k != clock},
        )
        for table in tables
    )
    columns = put_together(recording, [name for table in tables for name in table.columns], kinds)
    how = f"by {clock!r}: measurements interpolated, commands held"
    stamps = columns.pop(TIME)
    return replace(_named(tables, {clock: stamps, **columns}, 1 + np.arange(len(stamps)), how), polled=False)


def _row_by_row(tables: Sequence[Table]) -> Table:
    longest = max(tables, key=len)
    columns: dict[str, Array] = {}
    for table in tables:
        if len(table) < len(longest) - 1:
            stamps = "or stamps in both, in columns of one name"
            expected = f"as many rows as {longest.path.name} ({len(longest)}), or one fewer, {stamps}"
            raise DataError(table.path, expected, f"{len(table)} rows")
        for name, values in table.columns.items():
            columns[name] = values if len(values) == len(longest) else np.append(values, values[-1])
    columns |= longest.columns
    short = " (the last row keeps what was sent)" if any(len(table) < len(longest) for table in tables) else ""
    return _named(tables, columns, longest.lines, f"row by row{short}")


def _named(tables: Sequence[Table], columns: dict[str, Array], lines: NDArray[np.int64], how: str) -> Table:
    """A table that errors call by all of its files."""
    names = [table.path.name for table in tables]
    own = {
        "name": "+".join(table.path.stem for table in tables),
        "notes": json.dumps([f"{' and '.join(names)} are one log, put together {how}"]),
    }
    texts = tuple(name for table in tables for name in table.texts)
    return Table(tables[0].path.with_name("+".join(names)), columns, lines, texts, own)
