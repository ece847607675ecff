"""Files of logs: nothing is lost on the way out and in, and a bad file gives one error that says where."""

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays

from sym2real.errors import DataError, ShapeError
from sym2real.layout import Layout, Layouts
from sym2real.logs import LogSpec, inspect_logs, read_log, read_logs, write_log
from sym2real.logs.missing import specification
from sym2real.logs.table import LARGEST
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import VOCABULARY

CAR = Layouts(Layout.of(["x", "y", "sin_yaw", "cos_yaw", "vx", "vy", "wz"]), Layout.of(["steer", "speed"]))
PUSHED = Layouts(CAR.state, CAR.action, Layout.of(["fx", "fy", "tz", "vbat", "t"]))
# A model that measures the attitude: the vocabulary alone would call it a state.
MEASURED = Layouts(Layout.of(["x", "y", "z"]), Layout.of(["thrust"]), Layout.of(["qw", "qx", "qy", "qz", "t"]))
ANY = st.floats(-LARGEST, LARGEST)  # what is larger is refused as damage


@st.composite
def trajectories(draw: st.DrawFn, layouts: Layouts) -> Trajectory:
    rows = draw(st.integers(1, 6))
    steps = draw(arrays(np.float64, rows, elements=st.floats(1e-6, 1e3)))

    def block(layout: Layout) -> np.ndarray:
        values = draw(arrays(np.float64, (rows, layout.size), elements=ANY))
        for field in layout.fields:
            if field.kind == "quaternion":
                values[:, layout.slice(field.name)] = [0.6, 0.0, -0.8, 0.0]
        return values

    extra = {name: draw(arrays(np.float64, rows, elements=ANY)) for name in ("ref_x", "sonar, front")}
    return Trajectory(
        np.cumsum(steps) + draw(st.integers(-1000, 1_700_000_000)),
        block(layouts.state),
        block(layouts.action),
        block(layouts.inputs),
        layouts,
        extra=extra,
        name="run",
        notes=("made up",),
    )


def assert_same(read: Trajectory, written: Trajectory) -> None:
    for name in ("time", "state", "action", "inputs"):
        a, b = getattr(read, name), getattr(written, name)
        assert a.tobytes() == np.ascontiguousarray(b).tobytes(), name
    assert read.layouts == written.layouts
    assert read.extra.keys() == written.extra.keys()
    assert all(read.extra[name].tobytes() == values.tobytes() for name, values in written.extra.items())


@settings(max_examples=30, deadline=None)
@given(trajectories(PUSHED))
def test_csv_keeps_every_bit(tmp_path_factory: pytest.TempPathFactory, written: Trajectory) -> None:
    path = tmp_path_factory.mktemp("csv") / "run.csv"
    write_log(written, path)
    assert_same(read_log(path), written)
    assert [file.name for file in path.parent.iterdir()] == ["run.csv"]


@settings(max_examples=20, deadline=None)
@given(trajectories(MEASURED))
def test_every_bit_and_the_groups_are_kept(tmp_path_factory: pytest.TempPathFactory, written: Trajectory) -> None:
    path = tmp_path_factory.mktemp("parquet") / "other_name.parquet"
    write_log(written, path)
    read = read_log(path)
    assert_same(read, written)
    assert (read.name, read.notes) == ("run", ("made up",))


@settings(max_examples=10, deadline=None)
@given(trajectories(MEASURED))
def test_csv_lands_in_the_groups_of_a_model(tmp_path_factory: pytest.TempPathFactory, written: Trajectory) -> None:
    path = tmp_path_factory.mktemp("csv") / "run.csv"
    write_log(written, path)
    assert_same(read_log(path, layouts=MEASURED), written)


def test_layouts_survive_json() -> None:
    hidden = dataclasses.replace(VOCABULARY[0][1], hidden=True)
    layouts = Layouts(Layout((hidden, *CAR.state.fields[2:])), CAR.action, PUSHED.inputs)
    assert Layouts.from_dict(json.loads(json.dumps(layouts.to_dict()))) == layouts


def small(rows: int = 5) -> Trajectory:
    values = np.arange(rows * 7, dtype=float).reshape(rows, 7)
    action = np.ones((rows, 2))
    return Trajectory(0.05 * np.arange(rows), values, action, np.zeros((rows, 0)), CAR, extra={"ref_x": values[:, 0]})


def test_missing_inputs_are_filled(tmp_path: Path) -> None:
    write_log(small(), tmp_path / "run.csv")
    wanted = Layouts(CAR.state, CAR.action, Layout.of(["fx", "fy", "tz", "t"]))
    read = read_log(tmp_path / "run.csv", layouts=wanted)
    assert np.array_equal(read.inputs[:, :3], np.zeros((5, 3)))
    assert np.array_equal(read.inputs[:, 3], read.time)


def test_hidden_states_are_not_asked_of_a_log(tmp_path: Path) -> None:
    write_log(small(), tmp_path / "run.csv")
    lag = dataclasses.replace(Layout.of(["lagged"]).fields[0], hidden=True)
    layouts = dataclasses.replace(CAR, state=Layout((*CAR.state.fields, lag)))
    assert read_log(tmp_path / "run.csv", layouts=layouts).layouts == CAR


def test_missing_columns_are_named_together_with_what_is_there(tmp_path: Path) -> None:
    write_log(small(), tmp_path / "run.csv")
    wanted = Layouts(Layout.of([*CAR.state, "z", "qw", "qx", "qy", "qz"]), Layout.of(["steer", "thrust"]))
    with pytest.raises(DataError) as refused:
        read_log(tmp_path / "run.csv", layouts=wanted)
    assert refused.value.expected == "columns of the model: z (m), qw, qx, qy, qz, thrust (N)"
    assert refused.value.found.startswith("only x, y, sin_yaw, cos_yaw, vx, vy, wz")
    assert "did you mean" not in str(refused.value)


def test_a_name_of_the_same_letters_is_proposed_before_others(tmp_path: Path) -> None:
    names = [f"q_cmd_{part}" for part in "wxyz"]
    (tmp_path / "run.csv").write_text("t," + ",".join(names) + "\n0,1,0,0,0\n1,1,0,0,0\n")
    wanted = Layouts(Layout.of(["qw_cmd", "qx_cmd", "qy_cmd", "qz_cmd"]), Layout.of(["thrust"]))
    with pytest.raises(DataError) as refused:
        read_log(tmp_path / "run.csv", layouts=wanted)
    asked = [f"is {name!r} its {own}?" for name, own in zip(names, wanted.state.columns, strict=True)]
    assert refused.value.found.split("; ")[1:5] == asked


def test_only_a_name_that_is_close_is_proposed_for_a_missing_column(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("t,x,y,z,Motor_1,wx\n0,0,0,0,0,0\n1,0,0,0,0,0\n")
    wanted = Layouts(Layout.of(["x", "y", "z", "vx", "vy", "vz"]), Layout.of(["motor1", "wx_cmd"]))
    with pytest.raises(DataError) as refused:
        read_log(tmp_path / "run.csv", layouts=wanted)
    assert refused.value.found.split("; ")[1:] == [
        "is 'Motor_1' its motor1?",
        'derive = ["velocity"] in a log specification computes vx, vy, vz',
        '`vx = "…"` under [columns] of the specification names it',
        specification(tmp_path / "run.csv"),
    ]


@pytest.mark.parametrize(
    ("has", "takes", "interface"),
    [
        (["motor1", "motor2", "motor3", "motor4"], ["thrust", "wx_cmd", "wy_cmd", "wz_cmd"], "motors"),
        (["thrust", "wx_cmd", "wy_cmd", "wz_cmd"], ["motor1", "motor2", "motor3", "motor4"], "thrust_rates"),
    ],
)
def test_a_log_of_the_other_interface_is_recognised(
    has: list[str], takes: list[str], interface: str, tmp_path: Path
) -> None:
    state = np.arange(12, dtype=float).reshape(4, 3)
    layouts = Layouts(Layout.of(["x", "y", "z"]), Layout.of(has))
    flight = Trajectory(0.02 * np.arange(4), state, np.ones((4, 4)), np.zeros((4, 0)), layouts)
    write_log(flight, tmp_path / "run.csv")
    with pytest.raises(DataError, match=f"--interface {interface}` makes a model for it"):
        read_log(tmp_path / "run.csv", layouts=dataclasses.replace(layouts, action=Layout.of(takes)))


def test_missing_columns_of_a_specification_are_named_together(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("t,a\n0,0\n1,0\n")
    spec = LogSpec.parse('[columns]\nx = "pose.x"\ny = "pose.y"\nz = "a"\n')
    with pytest.raises(DataError, match=r"expected columns pose\.x, pose\.y \(.*found only t, a$"):
        read_log(tmp_path / "run.csv", spec=spec)


def test_a_folder_is_its_logs(tmp_path: Path) -> None:
    for name in ("b.csv", "a.parquet"):
        write_log(dataclasses.replace(small(), name=name), tmp_path / name)
    (tmp_path / "c.tsv").write_text((tmp_path / "b.csv").read_text().replace(",", "\t"))
    (tmp_path / "README.md").write_text("no log")
    (tmp_path / "notes.txt").write_text("no log")
    found = read_logs(tmp_path)
    assert len(found) == 3
    for log in found:
        np.testing.assert_array_equal(log.state, small().state)
    (tmp_path / "empty").mkdir()
    with pytest.raises(DataError, match="expected files that end in"):
        read_logs(tmp_path / "empty")


def test_two_columns_of_one_name_are_not_written(tmp_path: Path) -> None:
    twice = dataclasses.replace(small(), extra={"x": np.zeros(5)})
    with pytest.raises(ShapeError, match="'x' stands twice"):
        write_log(twice, tmp_path / "run.csv")
    assert list(tmp_path.iterdir()) == []


def test_unwritable_targets(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"ends in \.csv"):
        write_log(small(), tmp_path / "run.xlsx")
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(DataError, match="can be written"):
        write_log(small(), tmp_path / "taken" / "run.csv")


HEADER = "t,x,y,vx"
GOOD = f"{HEADER}\n0.0,1,2,3\n0.1,1,2,3\n0.2,1,2,3\n"
BAD: dict[str, tuple[str | bytes, int | None, str | None, str]] = {
    "empty": ("", None, None, "an empty file"),
    "blank": ("\n\n", None, None, "an empty file"),
    "header only": (f"{HEADER}\n", None, None, "column names only"),
    "no header": ("0.0,1,2,3\n0.1,1,2,3\n", 1, None, "numbers"),
    "cut off": (GOOD + "0.3,1,2", 5, None, "3 values.*cut off"),
    "too long": (GOOD.replace("0.1,1,2,3", "0.1,1,2,3,4"), 3, None, "5 values"),
    "empty line": (GOOD.replace("0.1,1,2,3", ""), 3, None, "an empty line"),
    "text": (GOOD.replace("0.1,1,2,3", "0.1,1,two,3"), 3, "y", "'two'"),
    "NaN throughout": (GOOD.replace("1,2,3", "nan,2,3"), None, None, "none"),
    "every other cell empty": (GOOD.replace("0.1,1,2,3", "0.1,1,2,"), 3, "vx", "an empty cell.*33 % of the rows"),
    "infinite": (GOOD.replace("0.2,1,2,3", "0.2,1,2,inf"), 4, "vx", "inf"),
    "time goes back": (GOOD.replace("0.2,", "0.05,"), 4, "t", r"an earlier stamp \(0\.1 then 0\.05\)"),
    "a clock begins anew": (
        f"{HEADER}\n" + "".join(f"{t},1,2,3\n" for t in (5, 6, 7, 8, 9, 99, 0, 1)),
        8,
        "t",
        "split the file",
    ),
    "time stands": (GOOD.replace("0.2,1", "0.1,4"), 4, "t", "the same stamp again.*keep one of each"),
    "stamps of too few digits": (
        f"{HEADER}\n" + "".join(f"1.70000000{t // 4}e+09,{t},2,3\n" for t in range(9)),
        3,
        "t",
        "most rows repeat a stamp.*write the stamps with more",
    ),
    "time not a number": (GOOD.replace("0.1,", "later,"), 3, "t", "'later'"),
    "no time": (
        GOOD.replace("t,", "s,"),
        None,
        None,
        "only s, x, y, vx; .*`sym2real inspect .*--spec",
    ),
    "duplicate": (GOOD.replace("vx", "x"), 1, "x", "the name twice"),
    "unnamed": (GOOD.replace("y", ""), 1, None, "none for column 3"),
    "commas and points": (GOOD.replace(",", ";").replace("0.1", "0,1"), 3, "t", "a decimal comma"),
    "a date among numbers": (GOOD.replace("0.1,", "2026-03-01,"), 3, "t", "'2026-03-01'"),
    "a word among dates": (
        f"{HEADER}\n" + "".join(f"2026-03-01T10:00:0{i},1,2,3\n" for i in range(5)) + "noon,1,2,3\n",
        2,
        "t",
        "text",
    ),
    "binary": (b"\x89PNG\r\n\x1a\n\x00\x00\x00", 1, None, "no UTF-8"),
    "zero byte": (GOOD.encode() + b"0.3,\x00,2,3\n", 5, None, "a zero byte"),
    "one column": ("t\n0\n1\n", 1, None, "'t'"),
    "nothing known": ("t,a,b\n0,1,2\n1,2,3\n", None, None, "only t, a, b; .*`sym2real inspect"),
}


def test_decimal_commas_are_points_where_no_number_has_one(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(GOOD.replace(",", ";").replace(".", ","))
    np.testing.assert_array_equal(read_log(path).time, [0.0, 0.1, 0.2])


@pytest.mark.parametrize("zone", ["", "Z", "+02:00"])
@pytest.mark.parametrize("between", ["T", " "])
def test_stamps_may_be_dates(zone: str, between: str, tmp_path: Path) -> None:
    """Across midnight; of a log's times their differences count."""
    path = tmp_path / "log.csv"
    days = [("2026-02-28", "23:59:59.950"), ("2026-03-01", "00:00:00"), ("2026-03-01", "00:00:00.05")]
    rows = [f"{between.join(day)}{zone},{i},2,3" for i, day in enumerate(days)]
    path.write_text("\n".join([HEADER, *rows]) + "\n")
    np.testing.assert_allclose(np.diff(read_log(path).time), 0.05, atol=1e-6)


@pytest.mark.parametrize("case", BAD)
def test_a_bad_csv_gives_one_error_with_its_place(tmp_path: Path, case: str) -> None:
    content, row, column, found = BAD[case]
    path = tmp_path / "bad.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(DataError, match=found) as caught:
        read_log(path)
    assert (caught.value.row, caught.value.column) == (row, column)
    assert "bad.csv" in str(caught.value)


def table(**changes: object) -> pa.Table:
    columns: dict[str, object] = {"t": [0.0, 0.1, 0.2], "x": [1.0, 2.0, 3.0], "y": [1.0, 2.0, 3.0]}
    return pa.table(columns | changes)


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-20])


BAD_TABLES: dict[str, tuple[pa.Table, int | None, str | None, str]] = {
    "no rows": (table().slice(0, 0), None, None, "column names only"),
    "no columns": (pa.table({}), None, None, "none"),
    "null": (table(vx=[1.0, None, 3.0]), 2, "vx", "an empty cell"),
    "nulls throughout": (table(y=pa.array([None] * 3, pa.float64())), None, None, "none"),
    "infinite": (table(x=[1.0, 2.0, float("-inf")]), 3, "x", "-inf"),
    "text among numbers": (table(y=["1", "b", "3"]), 2, "y", "'b'"),
    "text": (table(y=["a", "b", "c"]), 1, "y", "text"),
    "time stands": (table(t=[0.0, 0.1, 0.1]), 3, "t", "the same stamp again"),
    "duplicate": (pa.Table.from_arrays([pa.array([0.0]), pa.array([1.0])], ["x", "x"]), 1, "x", "the name twice"),
}


@pytest.mark.parametrize("case", BAD_TABLES)
def test_a_bad_parquet_gives_one_error_with_its_place(tmp_path: Path, case: str) -> None:
    content, row, column, found = BAD_TABLES[case]
    path = tmp_path / "bad.parquet"
    pq.write_table(content, path)
    with pytest.raises(DataError, match=found) as caught:
        read_log(path)
    assert (caught.value.row, caught.value.column) == (row, column)


@pytest.mark.parametrize("damage", [cut, lambda path: path.write_bytes(b""), lambda path: path.write_text(GOOD)])
def test_a_damaged_parquet(tmp_path: Path, damage: Callable[[Path], object]) -> None:
    path = tmp_path / "bad.parquet"
    pq.write_table(table(), path)
    damage(path)
    with pytest.raises(DataError, match="expected a whole Parquet file"):
        read_log(path)


def test_paths_that_are_no_logs(tmp_path: Path) -> None:
    (tmp_path / "misssing.csv").touch()
    with pytest.raises(DataError, match=r"missing\.csv.*nothing of that name; did you mean .*misssing\.csv"):
        read_log(tmp_path / "missing.csv")
    with pytest.raises(DataError, match=r"ends in \.csv, \.txt, .*\.parquet"):
        read_log(tmp_path / "log.xlsx")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(DataError, match="a folder"):
        read_log(tmp_path / "folder.csv")


@pytest.mark.parametrize(
    ("seconds", "nanoseconds", "whole"),
    [
        ("header.stamp.sec", "header.stamp.nanosec", "header.stamp"),
        ("header.stamp.secs", "header.stamp.nsecs", "header.stamp"),
        ("/odom/header/stamp/sec", "/odom/header/stamp/nanosec", "/odom/header/stamp"),
        ("sec", "nanosec", "stamp"),
    ],
)
def test_stamps_in_two_columns_are_one(tmp_path: Path, seconds: str, nanoseconds: str, whole: str) -> None:
    """Rows 20 ms apart across the turn of a second; whole seconds alone would be fifty rows at one stamp."""
    (path := tmp_path / "run.csv").write_text(
        f"{seconds},{nanoseconds},x\n"
        + "".join(f"{1764130000 + k // 50},{k % 50 * 20_000_000},{0.1 * k}\n" for k in range(40, 120))
    )
    log = read_log(path, spec=LogSpec.parse(f'[time]\ncolumn = "{whole}"\n[columns]\nx = "x"\n'))
    np.testing.assert_allclose(np.diff(log.time), 0.02, atol=1e-6)  # doubles of such a size are 0.24 µs apart
    np.testing.assert_array_equal(log.column("x"), 0.1 * np.arange(40, 120))
    assert inspect_logs(path).spec.time.column == whole


def test_unused_columns_may_hold_anything(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,x,mode,sonar\n0,1,HOVER,\n0.1,2,LAND,0.5\n0.2,3,LAND,nan\n")
    log = read_log(path)
    assert list(log.extra) == ["sonar"]
    assert np.array_equal(log.extra["sonar"], [np.nan, 0.5, np.nan], equal_nan=True)
    assert list(log.raw) == ["t", "x", "sonar"]
