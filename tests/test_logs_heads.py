"""What stands above the rows of a text file: rows are never names, whatever is missing in them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sym2real.errors import DataError
from sym2real.logs.csv_file import first_cells
from sym2real.logs.table import read_table

REST = "0.3,4.5,5.5,6.5\n0.4,4,5,6\n0.5,4,5,6\n0.6,4,5,6\n"
# Name, text, names of the columns, stamp of the first row, line of the first row.
READ = {
    "settings above": ("# log of mine\n# robot: car\nt,x,y,z\n" + REST, "t x y z", 0.3, 4),
    "blanks": ("# log of mine\n# t x y z\n" + REST.replace(",", " "), "t x y z", 0.3, 3),
    "units below": ("t,x,y,z\ns,m,m,m\n" + REST, "t.s x.m y.m z.m", 0.3, 3),
    "a first row of its stamp": ("t,x,y,z\n0.2,,,\n" + REST, "t x y z", 0.2, 2),
    "a first row of 1": ("t,x,y,z\n0,,,\n1,,,\n" + REST.replace("0.", "2."), "t x y z", 0.0, 2),
    "the same, settings above": ("# log\nt,x,y,z\n0.1,None,None,None\n0.2,,2.5,\n" + REST, "t x y z", 0.1, 3),
    "the same, units below": ("t,x,y,z\ns,m,m,m\n0.2,,,\n" + REST, "t.s x.m y.m z.m", 0.2, 3),
    "a name with a comma": ('log of,mine\nt,"pos, x",y,z\n' + REST, "t|pos, x|y|z", 0.3, 3),
    "mostly words": ("log\nt,x,mode,way\n" + "0.3,4,ARM|ANGLE,on\n" * 5, "t x mode way", 0.3, 3),
    "decimal commas, settings above": ("Log\nt;x\n0,1;1,5\n0,2;2,5\n0,3;3,5\n", "t x", 0.1, 3),
    "decimal commas, units below": ("t;x\ns;m\n0,1;1,5\n0,2;2,5\n0,3;3,5\n", "t.s x.m", 0.1, 3),
}


@pytest.mark.parametrize("case", READ)
def test_names_are_what_stands_above_the_rows(case: str, tmp_path: Path) -> None:
    text, names, first, line = READ[case]
    path = tmp_path / "log.csv"
    path.write_text(text)
    table = read_table(path)
    wanted = names.split("|") if "|" in names else names.split()
    assert first_cells(path) == wanted
    assert {*table.columns, *table.texts} == {*wanted}
    assert (table.columns[wanted[0]][0], int(table.lines[0])) == (first, line)
    assert len(table) == len(text.splitlines()) - line + 1


REFUSED = {
    "no names, a sparse row": (
        "0.0,1.5,2.5\n0.1,1.5,2.5\n0.2,None,None\n" + "0.3,1,2\n" * 4,
        "names in the first line",
    ),
    "more names than columns": (
        "Log 1\nt,dt,x,y\n" + "0.0,1.5,2.5\n" * 4,
        "row 2: expected 2 values, one per column, found 1",
    ),
    "an empty line below": (
        "t,x\n\n" + "0.0,1.5\n" * 4,
        "row 2: expected 2 values, one per column, found an empty line",
    ),
    "thousands": ("t\tpwm\n" + "0\t1,500\n1\t1,750\n2\t1,800\n", "a decimal comma"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_head_is_refused_as_it_stands(case: str, tmp_path: Path) -> None:
    text, words = REFUSED[case]
    path = tmp_path / "log.tsv"
    path.write_text(text)
    with pytest.raises(DataError, match=words):
        read_table(path)


def test_two_rigid_bodies_of_motive_go_by_their_numbers(tmp_path: Path) -> None:
    head = [
        "Format Version,1.23,Take Name,Take 1,Capture Frame Rate,50.0,Units,Meters",
        "",
        ",,Rigid Body,Rigid Body,Rigid Body,Rigid Body",
        ",,car,car,wall,wall",
        ',,"5FD8","5FD8","6FD9","6FD9"',
        ",,Position,Position,Position,Position",
        "Frame,Time (Seconds),X,Z,X,Z",
    ]
    path = tmp_path / "take.csv"
    path.write_text("\n".join([*head, *(f"{i},{0.02 * i},1,2,3,4" for i in range(5))]) + "\n")
    names = ["Frame", "Time (Seconds)", *(f"{body}.Position.{axis}" for body in ("5FD8", "6FD9") for axis in "XZ")]
    assert [*read_table(path).columns] == names


def test_of_positions_alone_the_marker_error_has_its_name(tmp_path: Path) -> None:
    path = tmp_path / "take.csv"
    rows = "".join(f"{i},{0.02 * i},1,2,1e-4\n" for i in range(5))
    path.write_text("Take,1\n,,Position,Position,Mean Marker Error\nFrame,Time (Seconds),X,Z,\n" + rows)
    assert [*read_table(path).columns][2:] == ["Position.X", "Position.Z", "Mean Marker Error"]


def test_days_without_times_and_weeks_are_words(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,day,week\n" + "".join(f"0.{i},2026-03-01,2026-W10\n" for i in range(5)))
    assert read_table(path).texts == ("day", "week")


def test_a_missing_date_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    moments = ["2026-03-01T10:00:00", "2026-03-01 10:00:01", "", "2026-03-01T10:00:03"]
    path.write_text("stamp,x\n" + "".join(f"{moment},{i}\n" for i, moment in enumerate(moments)))
    stamps = read_table(path).columns["stamp"]
    np.testing.assert_allclose(np.diff(stamps[[0, 1, 3]]), [1.0, 2.0])
    assert np.isnan(stamps[2])
