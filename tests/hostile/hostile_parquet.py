"""Damaged Parquet files: bytes, and columns of kinds that no log has."""

from collections.abc import Callable
from pathlib import Path
from random import Random

import pyarrow as pa
import pyarrow.parquet as pq
from hostile_case import Case, kind, reading

LOG = "flight.parquet"


@kind("Parquet: bytes changed, cut off or added")
def bytes_changed(folder: Path, random: Random) -> Case:
    content = bytearray((folder / LOG).read_bytes())
    how = random.choice(("cut", "changed", "zeros", "begin", "other", "empty"))
    # In the pages, which have checksums: the footer behind them has none, and says what the file is.
    pages = len(content) - 8 - int.from_bytes(content[-8:-4], "little")
    place = random.randrange(4, pages - 100)
    if how == "cut":
        del content[place:]
    elif how == "changed":
        content[place] ^= 1 << random.randrange(8)
    elif how == "zeros":
        content[place : place + 100] = bytes(100)
    elif how == "begin":
        del content[: random.randrange(1, 100)]
    else:
        content = bytearray(random.randbytes(3000) if how == "other" else b"")
    (folder / LOG).write_bytes(content)
    return reading(LOG, r"flight\.parquet: expected a whole Parquet file, found \w")


@kind("Parquet: columns of other kinds")
def columns(folder: Path, random: Random) -> Case:
    table = pq.read_table(folder / LOG)
    name = random.choice(("time", "x", "qw", "vz", "thrust"))
    place, values = table.column_names.index(name), table[name].to_pylist()

    def with_cell(cell: float | None) -> pa.Array:
        return pa.array([cell if i == 7 else value for i, value in enumerate(values)])

    text, none = f"row 1, column '{name}': expected numbers, found ", f"in all of {name}, found none"
    left_out = rf"1 of 100 rows left out, for want of numbers in {name}: rows 8\b"
    huge = f"row 8, column '{name}': expected a .*number.*, found "
    kinds: tuple[tuple[Callable[[], pa.Array], str, str], ...] = (
        (lambda: pa.array([f"cell {value}" for value in values]), text, ""),
        (lambda: pa.array([[value, value] for value in values]), text, ""),
        (lambda: pa.array([{"value": value} for value in values]), text, ""),
        (lambda: pa.array([b"\xff\xfe"] * len(values)), text, ""),
        (lambda: pa.array([None] * len(values), pa.float64()), none, ""),
        (lambda: pa.array([None] * len(values)), none, ""),
        (lambda: with_cell(float("inf")), huge, ""),
        (lambda: with_cell(1e300), huge, ""),
        (lambda: with_cell(float("nan")), left_out, left_out),
        (lambda: with_cell(None), left_out, left_out),
    )
    changed, named, told = random.choice(kinds)
    pq.write_table(table.set_column(place, name, changed()), folder / LOG)
    return reading(LOG, r"flight\.parquet", named, told=told)


@kind("Parquet: columns gone, twice or without rows")
def shape(folder: Path, random: Random) -> Case:
    table = pq.read_table(folder / LOG)
    changes: tuple[tuple[Callable[[], pa.Table], str], ...] = (
        (lambda: table.slice(0, 0), "rows of numbers, found column names only"),
        (lambda: table.slice(0, 1), r"rows .*found 1\b"),
        (lambda: table.select([]), "columns?, found"),
        (lambda: table.drop_columns(["vx"]), r"columns of the model: vx \(m/s\), found"),
        (lambda: table.append_column("x", table["x"]), "row 1, column 'x': .*found the name twice"),
        (lambda: table.rename_columns(["", *table.column_names[1:]]), "row 1: .*found none for column 1"),
        (lambda: table.take(list(range(len(table)))[::-1]), "row 2, column 'time': .*an earlier stamp"),
    )
    changed, named = random.choice(changes)
    pq.write_table(changed(), folder / LOG)
    return reading(LOG, r"flight\.parquet", named)


@kind("Parquet: metadata")
def metadata(folder: Path, random: Random) -> Case:
    """Ours is damaged, or gone: without it the columns have the groups of the vocabulary, as a CSV's."""
    table = pq.read_table(folder / LOG)
    known = dict(table.schema.metadata)
    values = (b"\xff\xfe", b"", b"{", b"[" * 3000, b"null", b"9" * 400, b'{"state": 3}', b'"text"', b"NaN")
    how = random.choice(("layouts", "notes", "no text", "a name", "gone"))
    if how == "gone":
        known = {b"\xff": b"\xff", b"pandas": b"\x80"}
    elif how == "a name":
        known[b"sym2real.name"] = random.choice((b"another", b"[bold]", b"", b"../..", "ψ".encode(), b"{"))
    elif how == "no text":
        known[random.choice([key for key in known if key.startswith(b"sym2real.")])] = b"\xff\xfe"
    else:
        known[f"sym2real.{how}".encode()] = random.choice(values)
    pq.write_table(table.replace_schema_metadata(known), folder / LOG)
    named = {"gone": (), "a name": ()}.get(how, (r"flight\.parquet", "metadata" if how == "no text" else how))
    return reading(LOG, *named, renamed=how == "a name")
