"""Damaged logs: one error that names file, row and column, what was expected and what stands there."""

import os
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sym2real.errors import DataError
from sym2real.logs import LogSpec, read_log
from sym2real.logs.csv_file import LONGEST_NAME
from sym2real.logs.table import LARGEST, read_table

ROWS = 30


def log_of(folder: Path, row: int = 5, **cells: str) -> Path:
    """A log of 30 rows with other cells in one line of the file, which is counted from 1."""
    lines = ["t,x,y"] + [f"{0.02 * i:.2f},{i}.5,{-i}.25" for i in range(ROWS)]
    values = dict(zip(("t", "x", "y"), lines[row - 1].split(","), strict=True)) | cells
    lines[row - 1] = ",".join(values.values())
    path = folder / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("cell", "error"),
    [
        ('"1.5', r"log\.csv, row 5: expected quotes that are closed in the same line.*found unexpected end of data"),
        ('"1.5"x', r"log\.csv, row 5: expected quotes that are closed"),
        ('"' + "1" * 140000 + '"', r"log\.csv, row 5: expected .*short cells, found field larger than field limit"),
        ("1" * 140000, r"log\.csv, row 5, column 'x': expected a finite number, found inf"),
        ("z" * 140000, r"log\.csv, row 5, column 'x': expected a number, found 'zzz[^ ]*' … \(140000 letters\)"),
        ("1e300", r"log\.csv, row 5, column 'x': expected a number of at most 1e\+30, found 1e\+300"),
        ("-1e300", r"log\.csv, row 5, column 'x': expected a number of at most 1e\+30, found -1e\+300"),
        ('"1,5"', r"log\.csv, row 5, column 'x': expected a number with a decimal point, found '1,5', a decimal comma"),
        ("1_0", r"log\.csv, row 5, column 'x': expected a number, found '1_0'"),
        ("1,5", r"log\.csv, row 5: expected 3 values, one per column, found 4 values"),
    ],
)
def test_a_damaged_cell_is_named_by_its_place(cell: str, error: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=error) as raised:
        read_log(log_of(tmp_path, x=cell))
    assert len(str(raised.value)) < 500


def test_a_file_of_text_alone_is_refused(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("a,b\n" * 100)
    with pytest.raises(DataError, match=r"log\.csv, row 2: expected a column of numbers, found text in all of them"):
        read_table(tmp_path / "log.csv")


def test_quoted_decimal_commas_in_a_whole_column_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,x,y\n" + "".join(f'{0.02 * i:.2f},"{i},5",{i}\n' for i in range(ROWS)))
    with pytest.raises(DataError, match=r"row 2, column 'x': expected a number with a decimal point, found '0,5'"):
        read_table(path)


def test_quotes_that_are_closed_are_read(tmp_path: Path) -> None:
    assert read_log(log_of(tmp_path, x='"7.5"')).column("x")[3] == 7.5
    path = tmp_path / "names.csv"
    path.write_text('"t", "x", "y"\n0,1,2\n0.1,1,2\n')
    assert list(read_table(path).columns) == ["t", "x", "y"]


def test_the_largest_number_that_is_read(tmp_path: Path) -> None:
    assert read_log(log_of(tmp_path, x=f"{LARGEST:g}")).column("x")[3] == LARGEST


def test_a_header_that_never_ends_is_cut_short_in_the_error(tmp_path: Path) -> None:
    for name, expected in (("x" * 300, f"at most {LONGEST_NAME} letters"), ('"x', "quotes that are closed")):
        with pytest.raises(DataError, match=rf"log\.csv, row 1: expected .*{expected}") as raised:
            read_table(log_of(tmp_path, row=1, x=name))
        assert len(str(raised.value)) < 300


@pytest.fixture
def parquet(tmp_path: Path) -> Path:
    columns = {name: np.arange(ROWS) * 0.02 for name in ("t", "x", "y")}
    path = tmp_path / "log.parquet"
    pq.write_table(pa.table(columns), path)
    return path


def test_foreign_metadata_may_be_anything_and_ours_is_utf_8(parquet: Path) -> None:
    table = pq.read_table(parquet)
    pq.write_table(table.replace_schema_metadata({b"\xff\xfe": b"\xff", b"pandas": b"\x80"}), parquet)
    assert read_table(parquet).metadata == {}
    pq.write_table(table.replace_schema_metadata({b"sym2real.name": b"\xff"}), parquet)
    with pytest.raises(
        DataError, match=r"log\.parquet: expected metadata under 'sym2real\.name' in UTF-8, found bytes.*ff"
    ):
        read_table(parquet)


def test_a_parquet_of_ours_whose_pages_changed_is_refused(tmp_path: Path) -> None:
    from sym2real.logs import write_log

    path = tmp_path / "log.parquet"
    write_log(read_log(log_of(tmp_path)), path)
    whole = bytearray(path.read_bytes())
    for position in range(40, 200, 20):
        changed = bytearray(whole)
        changed[position] ^= 0x10
        path.write_bytes(changed)
        with pytest.raises(DataError, match=r"log\.parquet: expected"):
            read_log(path)


@pytest.mark.skipif(sys.platform == "win32", reason="there are no named pipes in folders")
@pytest.mark.parametrize("name", ["log.csv", "log.parquet"])
def test_a_pipe_is_refused_and_not_waited_for(name: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / name)
    with pytest.raises(DataError, match=rf"{name}: expected a file, found a pipe"):
        read_table(tmp_path / name)
    os.mkfifo(tmp_path / "spec.toml")
    with pytest.raises(DataError, match=r"spec\.toml: expected a file, found a pipe"):
        LogSpec.load(tmp_path / "spec.toml")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('[columns]\nx = "a"\ny = "a"\n', "'a' for columns.x and columns.y"),
        ('[time]\ncolumn = "a"\n[columns]\nx = "a"\n', "'a' for columns.x and time.column"),
        ('[columns]\nx = "q1"\n[attitude]\nquaternion = ["q0", "q1", "q2", "q3"]\n', "'q1' for columns.x and attitude"),
        ('[attitude]\neuler = ["r", "p", "p"]\n', "'p' for attitude and attitude"),
    ],
)
def test_a_column_that_is_used_twice_is_refused(text: str, found: str) -> None:
    with pytest.raises(DataError, match=rf"expected every column of the log once, found {found}"):
        LogSpec.parse(text, "spec.toml")
