"""What is wrong with a log is said in its own columns and axes: applied to the specification, the advice mends it."""

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from broken_logs import times
from noisy_flights import flights
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis.errors.floor import Floor
from sym2real.diagnosis.errors.rungs import Rung, RungError
from sym2real.diagnosis.faults.fault import Fault
from sym2real.diagnosis.faults.misread_attitudes import ORDERS, OfAttitude
from sym2real.diagnosis.faults.mistakes.transformation import Late, of_all
from sym2real.diagnosis.faults.sanity import check
from sym2real.diagnosis.unexplained.explaining import find_astray
from sym2real.logs import LogSpec, read_logs
from sym2real.logs.differences import rates_on_time
from sym2real.logs.parts import Attitude, Source, TimeBase
from sym2real.logs.standard import TURNED_ABOUT_X
from sym2real.report.leftover import statement
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.robots.nominal_quadrotor import quadrotor
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import ATTITUDE

AUTOPILOT = {
    **{name: f"pose.{name}" for name in ("x", "y", "z")},
    **{name: f"pose.{name}" for name in ("vx", "vy", "vz")},
    **dict(zip(("wx", "wy", "wz"), ("rollspeed", "pitchspeed", "yawspeed"), strict=True)),
    **dict(zip(("wx_cmd", "wy_cmd", "wz_cmd"), ("roll_sp", "pitch_sp", "yaw_sp"), strict=True)),
    "thrust": "thrust_sp",
}
NED = LogSpec(
    "autopilot",
    time=TimeBase("stamp"),
    columns={name: Source(column) for name, column in AUTOPILOT.items()},
    attitude=Attitude(tuple(f"q[{place}]" for place in range(4))),
    frames="ned_frd",
)
CAR = LogSpec(
    "car",
    time=TimeBase("stamp"),
    columns={"yaw": Source("theta"), **{name: Source(f"log_{name}") for name in ("x", "y", "wheel_speed", "steer")}}
    | {"speed": Source("log_speed")},
    derive=("rate",),
)
Columns = dict[str, Array]


def in_ned(log: Trajectory) -> Columns:
    """The file of an autopilot: north-east-down, and forward-right-down of the body."""
    names = {**AUTOPILOT, **dict(zip(ATTITUDE.columns, NED.attitude.quaternion, strict=True))}
    return {"stamp": log.time} | {
        column: (-1.0 if name in TURNED_ABOUT_X else 1.0) * log.column(name) for name, column in names.items()
    }


def of_car(log: Trajectory) -> Columns:
    """The file of a car: its pose, and how fast its wheels go."""
    yaw = np.unwrap(np.arctan2(log.column("sin_yaw"), log.column("cos_yaw")))
    vx, vy = (np.gradient(log.column(name), log.time) for name in ("x", "y"))
    wheel = np.cos(yaw) * vx + np.sin(yaw) * vy
    noise = 0.02 * np.random.default_rng(len(log)).standard_normal(len(log))
    return {"stamp": log.time, "theta": yaw, "log_wheel_speed": wheel + noise} | {
        f"log_{name}": log.column(name) for name in ("x", "y", "steer", "speed")
    }


@cache
def drives() -> Dataset:
    return simulate_case(Case("mushr", (), seed=71), trajectories=4, rows=260)


def read(folder: Path, files: list[Columns], spec: LogSpec, robot: object) -> Dataset:
    folder.mkdir(exist_ok=True)
    for number, columns in enumerate(files):
        table = np.stack([*columns.values()], axis=1)
        np.savetxt(folder / f"{number}.csv", table, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
    return read_logs(folder, spec, robot.layouts)  # type: ignore[attr-defined]


def as_advised(spec: LogSpec, fault: Fault) -> LogSpec:
    """The specification as the fix says."""
    columns, flip = dict(spec.columns), {*spec.flip}
    for name, column in re.findall(r"([\w]+) read ([\w.\[\]]+)", fault.fix):
        columns[name] = replace(spec.columns[name], column=column)
    for listed in re.findall(r"flip ([\w.\[\]]+(?:, [\w.\[\]]+)*)", fault.fix):
        flip ^= {*listed.split(", ")}
    for column, scale in re.findall(r"give ([\w.]+) scale = ([\d.e-]+)", fault.fix):
        columns |= {n: replace(s, scale=s.scale * float(scale)) for n, s in columns.items() if s.column == column}
    for zero in re.findall(r"a zero of ([\d.-]+) rad", fault.fix):
        columns["yaw"] = replace(columns["yaw"], zero=float(zero))
    return replace(spec, columns=columns, flip=tuple(flip))


def exchanged(one: str, other: str, sign: float = 1.0) -> Callable[[Columns], Columns]:
    return lambda columns: {**columns, one: columns[other], other: sign * columns[one]}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "said"),
    [
        (exchanged("rollspeed", "pitchspeed"), ["wy read rollspeed", "wx read pitchspeed", "leave the signs"]),
        (exchanged("rollspeed", "pitchspeed", -1.0), ["wy read rollspeed", "flip pitchspeed"]),
        (exchanged("roll_sp", "pitch_sp"), ["wy_cmd read roll_sp", "wx_cmd read pitch_sp"]),
        (lambda columns: {**columns, "pitch_sp": -columns["pitch_sp"]}, ["flip pitch_sp"]),
    ],
    ids=["rates", "rates, one reversed", "commands", "a reversed command"],
)
def test_columns_are_named_as_the_user_wrote_them(
    tmp_path: Path, change: Callable[[Columns], Columns], said: list[str]
) -> None:
    model, files = CRAZYFLIE.nominal(), [change(in_ned(log)) for log in flights()]
    (fault,) = check(model, read(tmp_path, files, NED, CRAZYFLIE)).faults
    assert all(part in fault.fix for part in said), fault.fix
    assert check(model, read(tmp_path, files, as_advised(NED, fault), CRAZYFLIE)).faults == ()


def test_signs_of_nobody_knows_which_axes_are_those_of_the_standard_frame() -> None:
    (fault,) = check(CRAZYFLIE.nominal(), times(flights(), {"wy_cmd": -1.0})).faults
    assert fault.fix.startswith("flip wy_cmd")
    assert "z up" in fault.fix


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1.15, 0.8])
def test_a_wheel_is_named_with_the_scale_that_mends_it(tmp_path: Path, scale: float) -> None:
    files = [of_car(log) for log in drives()]
    wrong = [{**columns, "log_wheel_speed": scale * columns["log_wheel_speed"]} for columns in files]
    assert check(MUSHR.nominal(), read(tmp_path, files, CAR, MUSHR)).faults == ()
    (fault,) = check(MUSHR.nominal(), read(tmp_path, wrong, CAR, MUSHR)).faults
    assert fault.value == pytest.approx(scale, rel=0.03)
    assert "log_wheel_speed" in fault.evidence
    mended = as_advised(CAR, fault)
    assert mended.columns["wheel_speed"].scale == pytest.approx(1.0 / scale, rel=0.03)
    assert check(MUSHR.nominal(), read(tmp_path, wrong, mended, MUSHR)).faults == ()


def test_a_gyros_scale_is_mended_by_its_inverse(tmp_path: Path) -> None:
    files = [{**columns, "yawspeed": 1.3 * columns["yawspeed"]} for columns in map(in_ned, flights())]
    (fault,) = check(CRAZYFLIE.nominal(), read(tmp_path, files, NED, CRAZYFLIE)).faults
    assert (fault.effect, fault.sensor) == ("sensor_scale:wz", True)
    assert check(CRAZYFLIE.nominal(), read(tmp_path, files, as_advised(NED, fault), CRAZYFLIE)).faults == ()


@pytest.mark.slow
@pytest.mark.parametrize(("sense", "zero"), [(-1.0, 0.0), (-1.0, np.pi / 2), (1.0, np.pi / 2), (-1.0, 0.6)], ids=str)
@pytest.mark.parametrize("directed", [True, False], ids=["wheel", "its size"])
def test_a_compass_is_the_only_fault_of_what_is_made_with_it(
    tmp_path: Path, sense: float, zero: float, directed: bool
) -> None:
    """Rates and the wheels' velocity are read with the heading: once that is right, so are they."""
    right = [of_car(log) for log in drives()]
    if not directed:
        right = [{**columns, "log_wheel_speed": np.abs(columns["log_wheel_speed"])} for columns in right]
    wrong = [{**columns, "theta": zero + sense * columns["theta"]} for columns in right]
    checked = check(MUSHR.nominal(), read(tmp_path, wrong, CAR, MUSHR))
    (fault,) = checked.faults
    assert fault.evidence.startswith(("sin_yaw", "a heading", "heading"))
    for log, meant in zip(checked.data, read(tmp_path / "right", right, CAR, MUSHR), strict=True):
        np.testing.assert_allclose(log.state, meant.state, atol=0.05)
    if sense < 0.0:
        assert check(MUSHR.nominal(), read(tmp_path, wrong, as_advised(CAR, fault), MUSHR)).faults == ()
    else:
        assert "turn it by 90° to the right" in fault.fix


def test_a_pose_behind_the_wheels_is_late_and_the_commands_are_not_delayed(tmp_path: Path) -> None:
    rows, files = 3, [of_car(log) for log in drives()]
    pose = ("log_x", "log_y", "theta")

    def behind(columns: Columns) -> Columns:
        return {n: v[: len(v) - rows] if n in pose or n == "stamp" else v[rows:] for n, v in columns.items()}

    checked = check(MUSHR.nominal(), read(tmp_path, [behind(columns) for columns in files], CAR, MUSHR))
    (fault,) = checked.faults
    assert fault.evidence.startswith("pose 3 rows late (x y sin_yaw cos_yaw by 150 ms)")
    assert "move log_x log_y theta 150 ms earlier" in fault.fix
    right = read(tmp_path / "right", [{n: v[rows:] for n, v in columns.items()} for columns in files], CAR, MUSHR)
    for log, meant in zip(checked.data, right, strict=True):
        np.testing.assert_allclose(log.state[1:-9], meant.state[1 : len(log) - 9], atol=1e-9)


BY_GYRO = LogSpec(
    "car with a gyro",
    time=TimeBase("stamp"),
    columns={"yaw": Source("theta"), **{name: Source(f"log_{name}") for name in ("x", "y", "wz", "steer", "speed")}},
    derive=("velocity",),
)


@pytest.mark.parametrize("late", [("theta", "log_x", "log_y"), ("theta",)])
def test_a_place_is_late_with_its_heading_where_nothing_else_tells_its_clock(
    late: tuple[str, ...], tmp_path: Path
) -> None:
    """A gyro tells that the heading is late; that the car goes where it points tells whether the place is."""
    rows, files = 3, [of_car(log) | {"log_wz": log.column("wz")} for log in drives()]

    def behind(columns: Columns) -> Columns:
        return {n: v[: len(v) - rows] if n in late else v[rows:] for n, v in columns.items()}

    (fault,) = check(MUSHR.nominal(), read(tmp_path, [behind(file) for file in files], BY_GYRO, MUSHR)).faults
    what = "pose 3 rows late" if len(late) > 1 else "heading 3 rows late"
    assert fault.evidence.startswith(what)
    right = check(MUSHR.nominal(), read(tmp_path, files, BY_GYRO, MUSHR))
    assert right.faults == ()


@cache
def by_attitude() -> Dataset:
    """The flights with the attitude that is reached 60 ms later as the command, and the gyro beside the states."""
    layouts, logs = quadrotor(interface="thrust_attitude", dt=CRAZYFLIE.dt).layouts, []
    for log in flights():
        attitude, rows = np.stack([log.column(name) for name in ATTITUDE.columns], axis=1), len(log) - 3
        rates = {name: log.column(name)[:rows] for name in ("wx", "wy", "wz")}
        plain = Trajectory.from_arrays(
            np.stack([log.column(name)[:rows] for name in layouts.state], axis=1),
            np.concatenate([log.column("thrust")[:rows, None], attitude[3:]], axis=1),
            layouts, time=log.time[:rows], name=log.name,
        )  # fmt: skip
        logs.append(replace(plain, extra=rates, sources={name: name for name in rates}))
    return Dataset(logs)


BY_ATTITUDE = quadrotor(interface="thrust_attitude", dt=CRAZYFLIE.dt, mass=CRAZYFLIE.mass, attitude_time_constant=0.06)


def test_an_attitude_that_is_followed_is_no_fault() -> None:
    assert check(BY_ATTITUDE, by_attitude()).faults == ()


@pytest.mark.parametrize("order", ["xyzw", "wxyz"])
def test_the_scalar_elsewhere_in_a_commanded_attitude(order: str) -> None:
    meant, mistaken = ORDERS[order][1], by_attitude()
    held = {f"{own}_cmd": f"{other}_cmd" for own, other in zip(ATTITUDE.columns, meant, strict=True)}
    mistaken = Dataset(log.with_columns({own: log.column(other) for own, other in held.items()}) for log in mistaken)
    checked = check(BY_ATTITUDE, mistaken)
    assert [fault.name for fault in checked.faults] == [f"commanded {ORDERS[order][0]}"]
    for log, right in zip(checked.data, by_attitude(), strict=True):
        np.testing.assert_array_equal(log.action, right.action)


@pytest.mark.slow
@pytest.mark.parametrize("signs", [(1, 1), (1, -1)], ids=["exchanged", "one reversed"])
@pytest.mark.parametrize("ending", ["", "_cmd"], ids=["measured", "commanded"])
def test_roll_and_pitch_in_each_others_place(ending: str, signs: tuple[int, int]) -> None:
    angles, quaternion = (f"roll{ending}", f"pitch{ending}"), tuple(f"{name}{ending}" for name in ATTITUDE.columns)
    inverse = OfAttitude(angles, angles[::-1], (signs[1], signs[0]), quaternion)
    meant = OfAttitude(angles, angles[::-1], signs, quaternion)
    data = by_attitude()
    checked = check(BY_ATTITUDE, of_all(inverse, data))
    (fault,) = checked.faults
    assert fault.evidence.startswith(meant.name)
    for log, right in zip(checked.data, data, strict=True):
        np.testing.assert_allclose(log.state, rates_on_time(Dataset([right]))[0].state, atol=1e-6)
        np.testing.assert_allclose(log.action, right.action, atol=1e-6)


def stage(low: float, worse: Mapping[float, tuple[str, ...]]) -> Rung:
    error = {"attitude": RungError(1.1 * low, low, low, 1.2 * low, "rad")}
    return Rung("base", {0.1: error, 0.8: error}, worse=dict(worse))


def test_a_model_that_predicts_a_step_worse_than_nothing_misses_something() -> None:
    noise = Floor(0.1, {"attitude": (0.01, "rad")})
    (left,) = find_astray(stage(0.1, {0.1: ("attitude",), 0.8: ()}), noise)
    assert left.matters
    assert statement(left) == "an error of attitude 11.00 times that of noise alone"
    assert find_astray(stage(0.012, {0.1: ("attitude",)}), noise) == ()  # noise makes it, within a third
    assert find_astray(stage(0.1, {0.1: (), 0.8: ("attitude",)}), noise) == ()


def test_a_late_heading_alone_is_no_late_pose() -> None:
    late = Late("heading", ("sin_yaw", "cos_yaw"), 3, MUSHR.dt)
    broken = Dataset(replace(late, rows=-3).undone(log).rows(10, len(log) - 10) for log in drives())
    assert not any("pose" in fault.evidence for fault in check(MUSHR.nominal(), broken).faults)


def test_a_late_pose_has_turned_velocities_along_the_body_too_late() -> None:
    """Motion capture late beside odometry: with a heading that has been mended velocities turn, and tell the rest."""
    rows, dt = 3, MUSHR.dt
    names = ("x", "y", "yaw", "vx", "vy", "wz", "steer", "speed")
    spec = LogSpec("odometry", columns={name: Source(name) for name in names}, velocity_frame="body")

    def written(log: Trajectory) -> Trajectory:
        frame = log.to_pandas().rename(columns={"time": "t"})
        sine, cosine = log.column("sin_yaw"), log.column("cos_yaw")
        ahead, left = cosine * frame["vx"] + sine * frame["vy"], cosine * frame["vy"] - sine * frame["vx"]
        frame = frame.assign(yaw=np.unwrap(np.arctan2(sine, cosine)), vx=ahead, vy=left)
        frame[["x", "y", "yaw"]] = frame[["x", "y", "yaw"]].shift(rows)
        return Trajectory.from_pandas(frame[["t", *names]].iloc[rows:], spec, MUSHR.layouts, dt)

    data = simulate_case(Case("mushr", (), seed=71), trajectories=4, rows=260)
    found = check(MUSHR.nominal(), Dataset(map(written, data)))
    (pose,) = (fault.evidence for fault in found.faults)
    assert re.match(r"pose (2\.5|3) rows late \(sin_yaw cos_yaw x y by", pose)  # velocities by differences are late
