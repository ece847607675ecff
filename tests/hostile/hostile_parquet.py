"""Damaged Parquet files: bytes, and columns of kinds that no log has."""

from __future__ import annotations

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
    place = random.randrange(len(content))
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
    return reading(LOG, r"flight\.parquet")


@kind("Parquet: columns of other kinds")
def columns(folder: Path, random: Random) -> Case:
    table = pq.read_table(folder / LOG)
    name = random.choice(("time", "x", "qw", "vz", "thrust"))
    place, values = table.column_names.index(name), table[name].to_pylist()
    kinds: tuple[Callable[[], pa.Array], ...] = (
        lambda: pa.array([f"cell {value}" for value in values]),
        lambda: pa.array([[value, value] for value in values]),
        lambda: pa.array([{"value": value} for value in values]),
        lambda: pa.array([None] * len(values), pa.float64()),
        lambda: pa.array([None] * len(values)),
        lambda: pa.array([b"\xff\xfe"] * len(values)),
        lambda: pa.array([float("nan") if i == 7 else value for i, value in enumerate(values)]),
        lambda: pa.array([float("inf") if i == 7 else value for i, value in enumerate(values)]),
        lambda: pa.array([1e300 if i == 7 else value for i, value in enumerate(values)]),
        lambda: pa.array([True] * len(values)),
        lambda: pa.array([None if i == 7 else value for i, value in enumerate(values)]),
    )
    changed = random.choice(kinds)()
    pq.write_table(table.set_column(place, name, changed), folder / LOG)
    return reading(LOG, r"flight\.parquet", rf"{name}\b|time|stamp|quaternion", told=rf"{name}\b|left out|gap|pieces?")


@kind("Parquet: columns gone, twice or without rows")
def shape(folder: Path, random: Random) -> Case:
    table = pq.read_table(folder / LOG)
    changes: tuple[Callable[[], pa.Table], ...] = (
        lambda: table.slice(0, 0),
        lambda: table.slice(0, 1),
        lambda: table.select([]),
        lambda: table.drop_columns(["vx"]),
        lambda: table.append_column("x", table["x"]),
        lambda: table.rename_columns(["", *table.column_names[1:]]),
        lambda: table.take(list(range(len(table)))[::-1]),
    )
    pq.write_table(random.choice(changes)(), folder / LOG)
    return reading(LOG, r"flight\.parquet")


@kind("Parquet: metadata")
def metadata(folder: Path, random: Random) -> Case:
    table = pq.read_table(folder / LOG)
    known = dict(table.schema.metadata)
    key = random.choice([key for key in known if key.startswith(b"sym2real.")])
    values = (
        b"\xff\xfe",
        b"",
        b"{",
        b"[" * 3000,
        b"null",
        b"9" * 400,
        b'{"state": 3}',
        b'"' + b"x" * 9999 + b'"',
        b"NaN",
    )
    known[key] = random.choice(values)
    if random.random() < 0.3:
        known = {b"\xff": b"\xff", b"pandas": b"\x80"}
    pq.write_table(table.replace_schema_metadata(known), folder / LOG)
    # Without metadata of ours the columns have the groups of the vocabulary, as a CSV's.
    return reading(LOG, r"flight\.parquet", "metadata|layouts|name|notes", told=r"\w")
