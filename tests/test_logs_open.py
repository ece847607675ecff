"""Logs as other tools write them open: without a header, in several files, with the speed of a wheel."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from cli_results import Refused

from sym2real.cli import main
from sym2real.errors import DataError
from sym2real.experiments.measured import step_of_logs
from sym2real.field import Field
from sym2real.layout import Layout, Layouts
from sym2real.logs import LogSpec, inspect_logs, read_log, read_logs
from sym2real.logs.parts import Source
from sym2real.symbolic import load_model
from sym2real.trajectory import Array

STATES, INPUTS = ["t", "x", "y", "yaw", "wheel_speed"], ["steer", "speed"]
ROWS, STEP = 120, 0.025


def drive(seed: int = 0) -> tuple[Array, Array]:
    """A car that goes where it points ``# (rows, 5)``, and what it was told: one row fewer."""
    time, start = STEP * np.arange(ROWS), np.random.default_rng(seed).uniform(0.0, 6.0)
    yaw, speed = 0.8 * np.sin(0.9 * time + start), 1.2 + 0.5 * np.sin(2.1 * time)
    x, y = (np.cumsum(speed * part(yaw)) * STEP for part in (np.cos, np.sin))
    return np.column_stack([time, x, y, yaw, speed]), np.column_stack([0.3 * np.cos(time), speed])[:-1]


def written(path: Path, values: Array, names: list[str]) -> Path:
    pd.DataFrame(values, columns=names).to_csv(path, index=False)
    return path


def savetxt(path: Path, values: Array, names: list[str]) -> None:
    np.savetxt(path, values, header=" ".join(names))


def savetxt_with_commas(path: Path, values: Array, names: list[str]) -> None:
    np.savetxt(path, values, delimiter=",", header=",".join(names), comments="")


def pandas_with_its_index(path: Path, values: Array, names: list[str]) -> None:
    pd.DataFrame(values, columns=names).to_csv(path)


def pandas_with_tabs(path: Path, values: Array, names: list[str]) -> None:
    pd.DataFrame(values, columns=names).to_csv(path, sep="\t", index=False)


def semicolons(path: Path, values: Array, names: list[str]) -> None:
    with path.open("w", newline="") as file:
        csv.writer(file, delimiter=";").writerows([names, *values.tolist()])


def commas_at_the_ends(path: Path, values: Array, names: list[str]) -> None:
    path.write_text("".join(",".join(map(str, [*row, "\n"])) for row in [names, *values.tolist()]))


WRITERS = [savetxt, savetxt_with_commas, pandas_with_its_index, pandas_with_tabs, semicolons, commas_at_the_ends]


@pytest.mark.parametrize("write", WRITERS)
def test_files_of_other_writers_hold_what_was_written(
    write: Callable[[Path, Array, list[str]], None], tmp_path: Path
) -> None:
    states, inputs = drive()
    whole = np.column_stack([states[:-1], inputs])
    write(tmp_path / "log.txt", whole, [*STATES, *INPUTS])
    log = read_log(tmp_path / "log.txt")
    np.testing.assert_allclose(log.time, whole[:, 0], rtol=1e-15)
    np.testing.assert_allclose(np.column_stack([log.column(name) for name in ("x", "y")]), whole[:, 1:3], rtol=1e-15)
    np.testing.assert_allclose(log.action, inputs, rtol=1e-15)


def test_files_without_a_header_take_names_from_python_and_from_the_command_line(tmp_path: Path) -> None:
    states, inputs = drive()
    whole = np.column_stack([states[:-1], inputs])
    bare, named = tmp_path / "bare.csv", written(tmp_path / "named.csv", whole, [*STATES, *INPUTS])
    np.savetxt(bare, whole, delimiter=",")
    log = read_log(bare, columns=[*STATES, *INPUTS])
    np.testing.assert_array_equal(log.state, read_log(named).state)
    answers = []
    for number, options in enumerate(([str(bare), "--columns", *STATES, *INPUTS], [str(named)])):
        spec, answer = tmp_path / f"{number}.toml", tmp_path / f"{number}.json"
        main(["inspect", *options, "--out", str(spec)])
        main(["nominal", "car", "--wheelbase", "0.3", "--log", *options, "--out", str(tmp_path / f"model{number}")])
        log = options[:1] + (options[1:] if number == 0 else [])
        assert LogSpec.load(spec).header == tuple([*STATES, *INPUTS] if number == 0 else ())
        main(["compare", str(tmp_path / "model0"), options[0], "--spec", str(spec), "--json", str(answer)])
        answers.append(json.loads(answer.read_text())["one_step"])
    assert answers[0] == answers[1]


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        (("t", "x"), "names of its 7 columns"),
        ((), "--columns names those"),
        (("t", "x", "x", "y", "a", "b", "c"), "once"),
    ],
)
def test_names_that_do_not_fit_a_file_without_a_header_are_refused(
    columns: tuple[str, ...], expected: str, tmp_path: Path
) -> None:
    states, inputs = drive()
    np.savetxt(tmp_path / "bare.csv", np.column_stack([states[:-1], inputs]), delimiter=",")
    with pytest.raises(DataError, match=expected):
        read_log(tmp_path / "bare.csv", columns=columns)


def test_names_for_a_file_that_has_its_own_are_refused(tmp_path: Path) -> None:
    states, _ = drive()
    with pytest.raises(DataError, match="numbers in the first line"):
        read_log(written(tmp_path / "named.csv", states, STATES), columns=STATES)


def in_two(folder: Path, seed: int = 0) -> tuple[Path, Path]:
    folder.mkdir(exist_ok=True)
    states, inputs = drive(seed)
    return written(folder / f"states{seed}.csv", states, STATES), written(folder / f"inputs{seed}.csv", inputs, INPUTS)


def test_states_and_one_command_fewer_are_one_log(tmp_path: Path) -> None:
    states, inputs = drive()
    log = read_log(in_two(tmp_path))
    assert len(log) == ROWS
    np.testing.assert_array_equal(log.column("x"), states[:, 1])
    np.testing.assert_array_equal(log.action[:-1], inputs)
    np.testing.assert_array_equal(log.action[-1], inputs[-1])
    assert log.name == "states0+inputs0"
    assert any("row by row (the last row keeps what was sent)" in note for note in log.notes)


def test_parts_pair_up_in_any_order_and_from_a_folder(tmp_path: Path) -> None:
    pairs = [in_two(tmp_path / "logs", seed) for seed in range(3)]
    expected = [drive(seed)[0][:, 1] for seed in range(3)]
    listed = [[file for pair in pairs for file in pair], [pair[i] for i in (1, 0) for pair in pairs], tmp_path / "logs"]
    for files in listed:
        logs = read_logs(files)
        assert len(logs) == 3
        for log, x in zip(logs, expected, strict=True):
            np.testing.assert_array_equal(log.column("x"), x)


def test_parts_without_a_header_share_the_names(tmp_path: Path) -> None:
    states, inputs = drive()
    for name, values in (("states.txt", states), ("inputs.txt", inputs)):
        np.savetxt(tmp_path / name, values)
    files = [tmp_path / "states.txt", tmp_path / "inputs.txt"]
    found = inspect_logs(files, columns=[*STATES, *INPUTS])
    (log,) = read_logs(files, found.spec)
    np.testing.assert_allclose(log.action[:-1], inputs, rtol=1e-15)
    with pytest.raises(DataError, match="as many as are named"):
        read_logs(files, columns=STATES[:-1])


def test_parts_with_stamps_of_their_own_meet_at_the_faster(tmp_path: Path) -> None:
    states, _ = drive()
    late = np.column_stack([states[::4, 0], 0.01 * np.arange(30), np.ones(30)])
    files = (
        written(tmp_path / "states.csv", states, STATES),
        written(tmp_path / "cmd.csv", late, ["t", "steer_cmd", "speed_cmd"]),
    )
    found = inspect_logs(files)
    (log,) = read_logs(files, found.spec)
    np.testing.assert_allclose(log.time, states[:, 0], atol=1e-12)
    np.testing.assert_allclose(log.column("steer"), np.repeat(0.01 * np.arange(30), 4))


def test_what_a_specification_makes_a_command_holds_whatever_its_name(tmp_path: Path) -> None:
    """A slower part's columns say nothing here of commands: the specification does."""
    states, _ = drive()
    late = np.column_stack([states[::4, 0], 0.01 * np.arange(30), np.ones(30)])
    files = (
        written(tmp_path / "states.csv", states, STATES),
        written(tmp_path / "wheels.csv", late, ["t", "left_rpm", "right_rpm"]),
    )
    listed = [row.column for row in inspect_logs(files).rows]
    assert {"left_rpm", "right_rpm"} <= {*listed}
    layouts = Layouts(Layout.of(["x", "y"]), Layout((Field("rate target", ("left", "right"), "rad/s", "body"),)))
    columns = {"x": Source("x"), "y": Source("y"), "left": Source("left_rpm"), "right": Source("right_rpm")}
    (log,) = read_logs(files, LogSpec(columns=columns), layouts)
    np.testing.assert_allclose(log.column("left"), np.repeat(0.01 * np.arange(30), 4))


def test_parts_that_do_not_belong_together_are_refused(tmp_path: Path) -> None:
    states, inputs = drive()
    short = written(tmp_path / "inputs.csv", inputs[:50], INPUTS)
    with pytest.raises(DataError, match=r"inputs\.csv: expected as many rows as states\.csv \(120\), or one fewer"):
        read_logs([written(tmp_path / "states.csv", states, STATES), short])
    with pytest.raises(DataError, match="as many files of each part"):
        read_logs([*in_two(tmp_path / "a"), in_two(tmp_path / "b", 1)[0]])


def test_a_wheels_speed_makes_the_velocity_along_the_heading(tmp_path: Path) -> None:
    states, _ = drive()
    files = in_two(tmp_path)
    log = read_log(files)
    yaw = states[:, 3]
    ahead = np.cos(yaw) * log.column("vx") + np.sin(yaw) * log.column("vy")
    across = np.cos(yaw) * log.column("vy") - np.sin(yaw) * log.column("vx")
    np.testing.assert_allclose(ahead, states[:, 4], rtol=1e-12)
    assert np.abs(across).max() < 0.05
    np.testing.assert_array_equal(log.extra["wheel_speed"], states[:, 4])


def test_a_wheel_that_counts_no_direction_turns_backwards_with_the_path(tmp_path: Path) -> None:
    time = STEP * np.arange(ROWS)
    speed = np.where(time < 1.5, 1.0, -1.0)
    x = np.cumsum(speed) * STEP
    values = np.column_stack([time, x, 0 * x, 0 * x, np.abs(speed)])
    log = read_log(written(tmp_path / "log.csv", values, STATES))
    away = np.abs(time - 1.5) > 0.1
    np.testing.assert_allclose(log.column("vx")[away], speed[away], atol=1e-9)


def test_a_velocity_that_was_measured_stays(tmp_path: Path) -> None:
    states, _ = drive()
    values = np.column_stack([states, np.full((ROWS, 2), 7.0)])
    log = read_log(written(tmp_path / "log.csv", values, [*STATES, "vx", "vy"]))
    np.testing.assert_array_equal(log.column("vx"), 7.0)


@pytest.mark.parametrize(("per_metre", "unit"), [(1.0, ""), (3.6, "km/h"), (100.0, "cm/s"), (1000.0, "mm/s")])
def test_the_unit_of_a_wheels_speed_is_that_of_the_path(per_metre: float, unit: str, tmp_path: Path) -> None:
    states, inputs = drive()
    states[:, 4] *= per_metre
    names = ["t", "x", "y", "yaw", "tacho", "steer_cmd", "speed_cmd"]
    path = written(tmp_path / "log.csv", np.column_stack([states[:-1], inputs]), names)
    assert inspect_logs(path).spec.columns["wheel_speed"].unit == unit
    np.testing.assert_allclose(read_log(path, inspect_logs(path).spec).column("wheel_speed"), drive()[0][:-1, 4])


def test_counts_of_a_wheel_get_the_scale_that_the_path_says(tmp_path: Path) -> None:
    states, inputs = drive()
    states[:, 4] *= 4614.0
    names = ["t", "x", "y", "yaw", "wheel_rpm", "steer_cmd", "speed_cmd"]
    found = inspect_logs(written(tmp_path / "log.csv", np.column_stack([states[:-1], inputs]), names))
    assert "wheel_speed" not in found.spec.columns
    (line,) = [line for line in found.toml().splitlines() if "# wheel_speed" in line]
    spec = LogSpec.parse(found.toml().replace(line, line.removeprefix("# ")))
    assert spec.columns["wheel_speed"].scale == pytest.approx(1.0 / 4614.0, rel=0.01)


@pytest.mark.parametrize(("command", "reference"), [("v_ref", None), ("speed_cmd", "v_ref")])
def test_a_speed_that_was_asked_for_is_the_command_where_there_is_no_other(
    command: str, reference: str | None, tmp_path: Path
) -> None:
    states, inputs = drive()
    names = ["t", "x", "y", "yaw", "speed_meas", "delta_ref", command, *([reference] if reference else [])]
    values = np.column_stack([states[:-1], inputs, *([0.0 * inputs[:, 1]] if reference else [])])
    columns = inspect_logs(written(tmp_path / "log.csv", values, names)).spec.columns
    assert (columns["speed"].column, columns["wheel_speed"].column) == (command, "speed_meas")


def test_a_car_that_starts_on_a_circle_is_not_said_to_steer_the_wrong_way(tmp_path: Path) -> None:
    """It turns faster and faster while pure pursuit steers less and less, always to the left."""
    time = STEP * np.arange(ROWS)
    speed, steer = 1.0 - np.exp(-time / 0.4), 0.3 - 0.02 * (1.0 - np.exp(-time / 0.8))
    yaw = np.cumsum(speed * np.tan(steer) / 0.3) * STEP
    x, y = (np.cumsum(speed * part(yaw)) * STEP for part in (np.cos, np.sin))
    values = np.column_stack([time, x, y, yaw, np.ones(ROWS), steer])
    proposed = inspect_logs(written(tmp_path / "log.csv", values, ["t", "x", "y", "yaw", "speed_cmd", "steer_cmd"]))
    assert "turns right" not in proposed.toml()


def test_a_model_gets_the_step_of_its_logs_and_no_row_is_lost(tmp_path: Path) -> None:
    files = [str(file) for file in in_two(tmp_path)]
    spec = LogSpec.load(_inspected(files, tmp_path))
    main(["nominal", "car", "--wheelbase", "0.3", "--log", *files, "--out", str(tmp_path / "model")])
    model = load_model(tmp_path / "model")
    assert model.dt == STEP
    assert len(read_log(files, spec, dt=model.dt)) == ROWS
    (thinned,) = read_logs(files, spec, dt=2 * STEP)
    assert len(thinned) == ROWS / 2
    assert any("a model with a step of 25 ms uses them all" in note for note in thinned.notes)


def test_a_model_takes_the_usual_step_of_logs_with_different_ones(tmp_path: Path) -> None:
    files = [tmp_path / "slow.csv", tmp_path / "fast.csv"]
    for file, hertz in zip(files, (10, 50), strict=True):
        time = np.arange(0.0, 4.0, 1.0 / hertz)
        zeros = np.zeros_like(time)
        written(file, np.column_stack([time, time, zeros, zeros + 1.0]), ["t", "x", "y", "speed"])
    assert step_of_logs(files, None) == 0.02


def test_half_a_step_of_one_log_is_no_part_of_the_usual_one(tmp_path: Path) -> None:
    files = [tmp_path / f"{number}.csv" for number in range(3)]
    for file, hertz in zip(files, (50, 50, 100), strict=True):
        time = np.arange(0.0, 4.0, 1.0 / hertz)
        zeros = np.zeros_like(time)
        written(file, np.column_stack([time, time, zeros, zeros + 1.0]), ["t", "x", "y", "speed"])
    assert step_of_logs(files[:2], None) == 0.02
    assert step_of_logs(files, None) == 0.01  # 399 intervals beside 398
    assert step_of_logs([*files, files[0]], None) == 0.02


def _inspected(files: list[str], folder: Path) -> Path:
    main(["inspect", *files, "--out", str(folder / "drive.toml")])
    return folder / "drive.toml"


def test_a_specification_of_no_log_is_refused(refused: Refused, tmp_path: Path) -> None:
    assert "found no --log" in refused(f"nominal car --wheelbase 0.3 --columns t x --out {tmp_path}/model")
