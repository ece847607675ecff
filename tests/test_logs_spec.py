"""Log specifications: TOML both ways, errors that name the nearest valid key, and what each key does to numbers."""

import re
from dataclasses import fields
from math import pi
from pathlib import Path

import numpy as np
import pytest
import torch
from log_files import saved

from sym2real import rotation
from sym2real.errors import DataError, UnknownNameError
from sym2real.layout import Layout, Layouts
from sym2real.logs import SPECS, LogSpec, load_spec, read_log
from sym2real.logs.parts import Attitude, Source, TimeBase
from sym2real.logs.standard import QUATERNION
from sym2real.logs.units import GRAVITY, UNITS, factor
from sym2real.robots import MUSHR

FULL = LogSpec(
    "drone",
    "a drone, \"quoted\" and 'odd'",
    TimeBase("stamp", "us", dt=0.01),
    {
        "x": Source("pose.x"),
        "wx": Source("gyro x", "deg/s"),
        "thrust": Source("pwm", scale=1e-5),
        "steer": Source("us", scale=1e-3, zero=1500.0),
        "θ1": Source("Ελευσίνα [°]"),
    },
    Attitude(("a", "b", "c", "d"), "xyzw", "world_to_body"),
    Attitude(euler=("r", "p", "y"), unit="deg"),
    drop_first=2,
    drop_last=1,
    flip=("gyro x",),
    derive=("velocity",),
    velocity_frame="body",
    frames="ned_frd",
    mass=1.3,
)


@pytest.mark.parametrize("spec", [FULL, LogSpec(), LogSpec(time=TimeBase("", rate=50.0)), *SPECS.values()])
def test_toml_both_ways(tmp_path: Path, spec: LogSpec) -> None:
    assert LogSpec.parse(spec.toml()) == spec
    spec.save(tmp_path / "spec.toml")
    assert LogSpec.load(tmp_path / "spec.toml") == spec
    assert [file.name for file in tmp_path.iterdir()] == ["spec.toml"]


def test_shipped_by_name_or_by_path(tmp_path: Path) -> None:
    assert set(SPECS) == {"crazyflie_battery_drag", "crazyflie_two_pennies", "mushr_steering_offset", "quadrotor_wind"}
    assert all(name == spec.name for name, spec in SPECS.items())
    assert load_spec("quadrotor_wind") is SPECS["quadrotor_wind"]
    (tmp_path / "mine.toml").write_text("drop_first = 3")
    assert load_spec(tmp_path / "mine.toml").name == "mine"
    with pytest.raises(UnknownNameError, match="did you mean 'quadrotor_wind'"):
        load_spec("quadrotor_winds")
    with pytest.raises(DataError, match=r"a specification that ends in .toml, found '.tml'; did you mean .*mine.toml"):
        load_spec(tmp_path / "mine.tml")
    with pytest.raises(DataError, match=r"none\.toml: expected a file, found nothing of that name"):
        load_spec(tmp_path / "none.toml")


BAD = {
    "x = [": "expected TOML",
    "colums = 3": "did you mean 'columns'",
    "[time]\ncolunm = 't'": "did you mean 'column'",
    "[time]\nunit = 'min'": "time.unit to be one of s, ms, us, ns",
    "[time]\ncolumn = 't'\nrate = 50": "either a column or a rate, found both",
    "[time]\nrate = 0": "time.rate to be a number > 0.0, found 0",
    "[time]\ndt = 'fast'": "time.dt to be a number, found 'fast'",
    "[columns]\n'the x' = 'a'": "names of letters, digits and _, found 'the x'",
    "[columns]\nx = 3": "column 'x': expected x = \"column\"",
    "[columns]\nx = {column = 'a', units = 'm'}": "did you mean 'unit'",
    "[columns]\nx = {column = 'a', unit = 'deg'}": "column 'x': expected a unit that fits.*known: cm, m, mm",
    "[columns]\nx = {column = 'a', scale = -1}": "columns.x.scale to be a number > 0.0, found -1",
    "[columns]\nx = {column = 'a', zero = 'mid'}": "columns.x.zero to be a number, found 'mid'",
    "[columns]\nx = {column = 'a', zero = nan}": "columns.x.zero to be a finite number, found nan",
    "[attitude]\nquaternion = ['a', 'b', 'c']": "a quaternion of 4 columns, or of 2",
    "[attitude]\nquaternion = ['a','b','c','d']\norder = 'zyxw'": "attitude.order to be one of wxyz, xyzw",
    "[attitude]\nquaternion = ['a','b','c','d']\ndirection = 'up'": "body_to_world, world_to_body",
    "[attitude]\neuler = ['a','b','c']\nunit = 'degrees'": "attitude.unit to be one of rad, mrad, deg",
    "flip = ['gyro']\n[columns]\nwx = 'gyro.x'": "in flip a column that exists.*did you mean 'gyro.x'",
    "derive = ['speed']": "derive to be one of velocity, rate",
    "velocity_frame = 'air'": "velocity_frame to be one of world, body",
    "frames = 'enu'": "frames to be one of z_up, ned_frd",
    "drop_first = -1": "drop_first to be a whole number >= 0, found -1",
    "drop_first = true": "found True",
    "mass = 'heavy'": "mass to be a number",
    "columns = 'x'": "columns to be a table",
    "name = 4": "name to be a text",
}


@pytest.mark.parametrize("text", BAD)
def test_a_bad_specification_names_file_key_and_nearest(text: str) -> None:
    with pytest.raises(DataError, match=BAD[text]) as caught:
        LogSpec.parse(text, "drone.toml")
    assert str(caught.value).startswith("drone.toml")


def read(folder: Path, columns: dict[str, object], toml: str, layouts: Layouts | None = None) -> dict[str, np.ndarray]:
    log = read_log(saved(folder, columns), LogSpec.parse(toml), layouts)
    names = [*log.layouts.state.columns, *log.layouts.action.columns, *log.layouts.inputs.columns]
    return {"time": log.time, **{name: log.column(name) for name in (*names, *log.extra)}}


STAMPS = {"t": [0.0, 0.1]}


@pytest.mark.parametrize(
    ("unit", "column", "one"),
    [
        ("mm", "x", 1e-3), ("deg", "yaw", pi / 180), ("deg/s", "wx", pi / 180), ("rpm", "wz", 2 * pi / 60),
        ("mV", "vbat", 1e-3), ("km/h", "speed", 1 / 3.6), ("gf", "thrust", GRAVITY / 1e3), ("g", "thrust", GRAVITY),
        ("uint16", "motor1", 1 / 65535), ("%", "motor1", 0.01), ("rpm", "motor1", 2 * pi / 60), ("mm", "ref_x", 1e-3),
    ],
)  # fmt: skip
def test_units(unit: str, column: str, one: float) -> None:
    assert factor(unit, column) == pytest.approx(one, rel=1e-15)


def test_units_flips_scale_and_mass(tmp_path: Path) -> None:
    toml = """
        flip = ["g"]
        mass = 2.0
        [columns]
        x = { column = "p", unit = "mm" }
        wx = { column = "g", unit = "deg/s" }
        thrust = { column = "a", unit = "m/s^2" }
        motor1 = { column = "pwm", scale = 0.5 }
    """
    found = read(
        tmp_path, {**STAMPS, "p": [1500, 2], "g": [180, 0], "a": [9, 10], "pwm": [1500, 2], "note": [7, 8]}, toml
    )
    assert np.allclose(found["x"], [1.5, 0.002])
    assert np.allclose(found["wx"], [-pi, 0])
    assert np.allclose(found["thrust"], [18, 20])
    assert np.allclose(found["motor1"], [750, 1])
    assert np.allclose(found["note"], [7, 8])


def test_pulses_of_a_servo_count_from_their_middle(tmp_path: Path) -> None:
    toml = 'flip = ["servo"]\n[columns]\nx = "x"\nsteer = { column = "servo", zero = 1520, scale = 0.001 }'
    found = read(tmp_path, {**STAMPS, "x": [0, 0], "servo": [1520, 1120]}, toml)
    assert np.allclose(found["steer"], [0.0, 0.4])


def test_the_page_on_specifications_holds() -> None:
    page = (Path(__file__).parents[1] / "docs" / "specification.md").read_text(encoding="utf-8")
    quad, vehicle, arm, bag = (LogSpec.parse(text) for text in re.findall(r"```toml\n(.*?)```", page, re.DOTALL))
    assert (quad.frames, quad.columns["motor2"].column, vehicle.columns["steer"].zero) == ("ned_frd", "m4", 1500.0)
    assert (arm.columns["shoulder"], arm.derive) == (Source("shoulder_deg", "deg", zero=90.0), ("rate",))
    assert (bag.time, bag.columns["steer"].column) == (TimeBase("t"), "/car/command.steering_angle")
    assert bag.attitude is not None
    assert [name.rpartition(".")[2] for name in bag.attitude.quaternion] == ["w", "x", "y", "z"]
    first_cells = re.findall(r"^\| (`.*?) \|", page, re.MULTILINE)
    keys = {key.strip("[]") for cell in first_cells for key in re.findall("`(.*?)`", cell)}
    assert keys == {field.name for field in fields(LogSpec)}
    units = re.search(r"^Units: (.*?)\.", page, re.DOTALL | re.MULTILINE)
    assert units is not None
    assert set(re.findall(r"`(.*?)`", units[1])) == set(UNITS)


QUARTER = np.array([np.cos(0.3), 0.1, -0.2, 0.0])
UNIT = QUARTER / np.linalg.norm(QUARTER)


@pytest.mark.parametrize(
    ("recorded", "keys"),
    [
        (UNIT, ""),
        (np.roll(UNIT, -1), 'order = "xyzw"'),
        (UNIT * [1, -1, -1, -1], 'direction = "world_to_body"'),
        (-1.02 * UNIT, ""),
    ],
)
def test_quaternions(tmp_path: Path, recorded: np.ndarray, keys: str) -> None:
    columns = {**STAMPS, **{f"q{i}": [value, -value] for i, value in enumerate(recorded)}}
    found = read(tmp_path, columns, f'[attitude]\nquaternion = ["q0", "q1", "q2", "q3"]\n{keys}')
    for row in range(2):
        assert np.allclose([found[name][row] for name in ("qw", "qx", "qy", "qz")], UNIT, atol=1e-12)


def test_four_columns_that_are_no_quaternion(tmp_path: Path) -> None:
    columns = {**STAMPS, **{f"q{i}": [0.5, 0.7] for i in range(4)}}
    with pytest.raises(DataError, match=r"row 3: expected a unit quaternion.*norm of 1\.4"):
        read(tmp_path, columns, '[attitude]\nquaternion = ["q0", "q1", "q2", "q3"]')


def test_angles_become_a_quaternion_and_a_heading(tmp_path: Path) -> None:
    columns = {**STAMPS, "r": [10, 20], "p": [-30, 5], "h": [170, -170]}
    layouts = Layouts(Layout.of(["qw", "qx", "qy", "qz", "sin_yaw", "cos_yaw"]), Layout())
    found = read(tmp_path, columns, '[attitude]\neuler = ["r", "p", "h"]\nunit = "deg"', layouts)
    quaternion = torch.tensor(np.stack([found[name] for name in ("qw", "qx", "qy", "qz")], axis=1))
    matrix = rotation.to_matrix(quaternion).numpy()
    assert np.allclose(np.degrees(np.arcsin(-matrix[:, 2, 0])), columns["p"])
    assert np.allclose(np.degrees(np.arctan2(matrix[:, 2, 1], matrix[:, 2, 2])), columns["r"])
    assert np.allclose(np.degrees(np.arctan2(found["sin_yaw"], found["cos_yaw"])), columns["h"])


def test_yaw_becomes_a_circle(tmp_path: Path) -> None:
    found = read(tmp_path, {**STAMPS, "a": [90, 180]}, '[columns]\nyaw = {column = "a", unit = "deg"}')
    assert np.allclose(found["sin_yaw"], [1, 0])
    assert np.allclose(found["cos_yaw"], [0, -1])


def test_body_velocities_turn_into_the_world(tmp_path: Path) -> None:
    columns = {**STAMPS, "yaw": [pi / 2, pi], "u": [1, 1], "v": [0, 2]}
    found = read(tmp_path, columns, 'velocity_frame = "body"\n[columns]\nyaw = "yaw"\nvx = "u"\nvy = "v"')
    assert np.allclose(found["vx"], [0, -1])
    assert np.allclose(found["vy"], [1, -2])
    unlisted = read(tmp_path, columns, 'velocity_frame = "body"\n[columns]\nvx = "u"\nvy = "v"')
    assert np.allclose(unlisted["vy"], found["vy"])
    with pytest.raises(DataError, match="an attitude or a yaw"):
        read(
            tmp_path,
            {"h" if name == "yaw" else name: values for name, values in columns.items()},
            'velocity_frame = "body"\n[columns]\nvx = "u"\nvy = "v"',
        )


def test_a_specification_need_not_name_columns_of_standard_names(tmp_path: Path) -> None:
    state = {"x": [1, 2], "y": [3, 4], "yaw": [0.2, 0.3], "vx": [1, 1], "vy": [2, 2], "wz": [1, 1]}
    columns = {"time": [0.0, 0.1], **state, "steer": [0.1, 0.2], "v": [1, 2], "vbat": [4, 4]}
    differs = 'flip = ["steer"]\n[columns]\nspeed = "v"'
    listed = "\n".join(f'{name} = "{name}"' for name in (*state, "steer"))
    for layouts in (None, MUSHR.layouts):
        found = read(tmp_path, columns, differs, layouts)
        whole = read(tmp_path, columns, f"{differs}\n{listed}\n[time]\ncolumn = 'time'", layouts)
        assert found.keys() == whole.keys()
        assert all(np.array_equal(found[name], whole[name]) for name in whole)
        assert found["steer"].tolist() == [-0.1, -0.2]


def test_what_a_specification_makes_is_not_what_the_log_calls_so(tmp_path: Path) -> None:
    columns = {
        "x": [0.0, 0.1],
        "vx": [9, 9],
        "r": [10, 10],
        "p": [5, 5],
        "h": [90, 90],
        **{name: [7, 7] for name in QUATERNION},
    }
    toml = 'derive = ["velocity"]\n[attitude]\neuler = ["r", "p", "h"]\nunit = "deg"'
    found = read(tmp_path, {**STAMPS, **columns}, toml)
    assert np.allclose(found["vx"], 1.0)
    assert np.allclose(sum(found[name] ** 2 for name in QUATERNION), 1.0)


def test_north_east_down_turns_about_x(tmp_path: Path) -> None:
    toml = 'frames = "ned_frd"\n[columns]\nx = "n"\ny = "e"\nz = "d"\nwz = "r"\nref_z = "k"\nyaw = "h"'
    columns = {"n": [1, 1], "e": [2, 2], "d": [-3, -3], "r": [0.5, 0.5], "k": [-3, -3], "h": [0.2, 0.3]}
    found = read(tmp_path, {**STAMPS, **columns}, toml)
    assert [found[name][0] for name in ("x", "y", "z", "wz", "ref_z")] == [1, -2, 3, -0.5, 3]
    assert np.allclose(np.arctan2(found["sin_yaw"], found["cos_yaw"]), [-0.2, -0.3])


def test_derived_velocities_and_rates_are_exact_for_constant_acceleration(tmp_path: Path) -> None:
    time = np.cumsum(np.random.default_rng(0).uniform(0.01, 0.05, 40))
    columns = {"t": time, "x": 1 + 2 * time + 3 * time**2, "y": -time, "yaw": 3.0 + 0.5 * time + time**2}
    toml = 'derive = ["velocity", "rate"]\n[columns]\nx = "x"\ny = "y"\nyaw = "yaw"'
    found = read(tmp_path, columns, toml)
    assert np.allclose(found["vx"], 2 + 6 * time, atol=1e-9)
    assert np.allclose(found["vy"], -1, atol=1e-9)
    assert np.allclose(found["wz"], 0.5 + 2 * time, atol=1e-9)


def test_derived_rate_is_a_body_rate(tmp_path: Path) -> None:
    time, rate = np.arange(30) * 0.01, np.array([0.4, -0.7, 1.1])
    start = rotation.normalise(torch.tensor([0.7, 0.3, -0.5, 0.4], dtype=torch.float64))
    turned = rotation.multiply(start, rotation.exponential(torch.tensor(np.outer(time, rate)))).numpy()
    columns = {"t": time, **{f"q{i}": turned[:, i] for i in range(4)}}
    found = read(tmp_path, columns, 'derive = ["rate"]\n[attitude]\nquaternion = ["q0", "q1", "q2", "q3"]')
    assert np.allclose(np.stack([found[name] for name in ("wx", "wy", "wz")], axis=1), rate, atol=1e-9)


def test_time_base(tmp_path: Path) -> None:
    found = read(
        tmp_path, {"us": [5e8, 5e8 + 20000], "x": [1, 2]}, '[time]\ncolumn = "us"\nunit = "us"\n[columns]\nx = "x"'
    )
    assert np.allclose(found["time"], [0, 0.02])
    found = read(tmp_path, {"a": [1, 1, 1], "x": [1, 2, 3]}, 'drop_first = 1\n[time]\nrate = 50\n[columns]\nx = "x"')
    assert np.allclose(found["time"], [0.02, 0.04])


def test_dropped_rows_are_not_judged_and_lines_keep_their_numbers(tmp_path: Path) -> None:
    columns = {"t": [0, 0, 1, 2, 3], "x": [np.nan, 1, 2, 3, 4]}
    toml = 'drop_first = 1\ndrop_last = 1\n[columns]\nx = "x"'
    assert np.array_equal(read(tmp_path, columns, toml)["x"], [1, 2, 3])
    with pytest.raises(DataError, match="row 5, column 'x'"):
        read(tmp_path, {**columns, "x": [1, 1, 1, np.inf, 1]}, toml)
    with pytest.raises(DataError, match="more than the 5 rows to drop"):
        read(tmp_path, columns, toml.replace("drop_first = 1", "drop_first = 4"))


def test_a_column_that_nobody_knows(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"specification 'unnamed' standard columns, found .*did you mean .*'wx'"):
        read(tmp_path, {**STAMPS, "a": [1, 2]}, "[columns]\nwxx = 'a'")


def test_a_column_that_the_log_has_not(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"log\.csv: expected a column 'pos.x' for 'x'.*did you mean 'pos_x'"):
        read(tmp_path, {**STAMPS, "pos_x": [1, 2]}, '[columns]\nx = "pos.x"')
    with pytest.raises(DataError, match=r"expected a column 'gyro_p' for 'wx'.*did you mean 'gyro_p_dps'"):
        read(tmp_path, {**STAMPS, "gyro_r_dps": [1, 2], "gyro_p_dps": [1, 2]}, '[columns]\nwx = "gyro_p"')
