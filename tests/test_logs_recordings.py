"""Recordings of several topics: what was measured is interpolated, what was commanded is held, formats agree."""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from recordings import DRIVE, POSE, Columns, write_bag, write_card, write_mcap, write_ulog

from sym2real.errors import DataError, MissingDependencyError
from sym2real.layout import Layout, Layouts
from sym2real.logs import LogSpec, inspect_logs, read_log, read_logs
from sym2real.logs.recordings.recording import Topic, put_together
from sym2real.trajectory import Trajectory

CAR = Layouts(Layout.of(["x", "y", "sin_yaw", "cos_yaw"]), Layout.of(["steer", "speed"]))
RADIUS, RATE = 1.5, 0.6  # m, rad/s: a car on a circle, whose yaw passes ±π
POSES_AT, COMMANDS_AT = np.arange(0.0, 12.0, 0.01), np.arange(0.013, 12.0, 0.05)
SPEC = """
[time]
dt = 0.05
[columns]
x = "{pose}.{x}"
y = "{pose}.{y}"
yaw = "{pose}.{yaw}"
steer = "{drive}.steering_angle"
speed = "{drive}.speed"
"""
BAG_SPEC = (
    SPEC.replace('yaw = "{pose}.{yaw}"\n', "")
    + '[attitude]\nquaternion = ["{pose}.{q}w", "{pose}.{q}x", "{pose}.{q}y", "{pose}.{q}z"]\n'
)


def poses(at: np.ndarray | None = None) -> Columns:
    at = POSES_AT if at is None else at
    angle = RATE * at
    yaw = (angle + np.pi / 2 + np.pi) % (2 * np.pi) - np.pi
    return {"t": at, "x": RADIUS * np.cos(angle), "y": RADIUS * np.sin(angle), "yaw": yaw}


def commands() -> Columns:
    steps = np.floor(COMMANDS_AT)  # one command a second, sent again and again
    return {"t": COMMANDS_AT, "steer": 0.1 * np.sin(steps), "speed": 0.5 + 0.1 * steps}


def bag(folder: Path, ros: int = 1, **settings: float) -> tuple[Path, LogSpec]:
    path = write_bag(folder / ("drive.bag" if ros == 1 else "drive"), ros, poses(), commands(), **settings)
    names = {"pose": POSE, "drive": DRIVE, "x": "pose.position.x", "y": "pose.position.y", "q": "pose.orientation."}
    return path, LogSpec.parse(BAG_SPEC.format(**names))


def flat(suffix: str, write: Callable[..., Path]) -> Callable[[Path], tuple[Path, LogSpec]]:
    """A writer of the same drive with plain topics."""

    def written(folder: Path) -> tuple[Path, LogSpec]:
        sent = commands()
        topics = {
            "pose": poses(),
            "drive": {"t": sent["t"], "steering_angle": sent["steer"], "speed": sent["speed"]},
        }
        path = write(folder / f"drive{suffix}", topics)
        return path, LogSpec.parse(SPEC.format(pose="pose", drive="drive", x="x", y="y", yaw="yaw"))

    return written


FORMATS: dict[str, Callable[[Path], tuple[Path, LogSpec]]] = {
    "ros1": bag,
    "ros2": lambda folder: bag(folder, 2),
    "mcap": flat(".mcap", write_mcap),
    "ulog": flat(".ulg", write_ulog),
    "card": flat(".usd", write_card),
    "card version 1": flat(".usd", lambda path, topics: write_card(path, topics, version=1)),
}


def drive(folder: Path, kind: str) -> Trajectory:
    path, spec = FORMATS[kind](folder)
    return read_log(path, spec, layouts=CAR)


@pytest.mark.parametrize("kind", FORMATS)
def test_every_format_holds_the_drive_that_was_written(kind: str, tmp_path: Path) -> None:
    log = drive(tmp_path, kind)
    middle = POSES_AT + 0.005  # of a row: the command that is in force there counts
    first = POSES_AT[COMMANDS_AT[0] <= middle][0]  # no row before the first command
    at = first + log.time - log.time[0]
    exact = poses(at)
    # A chord of 10 ms lies ω² R (10 ms)² / 8 inside the circle; stamps of version 1 are in ms.
    np.testing.assert_allclose(log.column("x"), exact["x"], atol=1e-5)
    np.testing.assert_allclose(log.column("y"), exact["y"], atol=1e-5)
    heading = np.arctan2(log.column("sin_yaw"), log.column("cos_yaw"))
    np.testing.assert_allclose(np.exp(1j * heading), np.exp(1j * exact["yaw"]), atol=1e-5)
    before = np.searchsorted(COMMANDS_AT, at + 0.005, side="right") - 1
    np.testing.assert_allclose(log.column("speed"), commands()["speed"][before], atol=1e-6)
    np.testing.assert_allclose(log.column("steer"), commands()["steer"][before], atol=1e-6)


@pytest.mark.parametrize("after", [0.001, 0.004, 0.009])
def test_a_command_that_answers_a_row_stands_in_that_row(after: float) -> None:
    """A controller answers every row a little later; beside a gap the row's own answer counts, none from within it."""
    stamps = np.append(0.02 * np.arange(50), 0.02 * np.arange(70, 120))
    pose = Topic("pose", stamps, {"pose.x": np.arange(100.0)})
    drive = Topic("drive", np.append(stamps + after, 1.2), {"drive.steer_cmd": np.append(np.arange(100.0), -1.0)})
    table = put_together((pose, drive), ["pose.x", "drive.steer_cmd"])
    np.testing.assert_array_equal(table["drive.steer_cmd"], table["pose.x"])


def test_a_row_has_the_mean_of_commands_that_come_faster_but_of_angles_that_go_round() -> None:
    rng = np.random.default_rng(0)
    stamps, sent_at = 0.02 * np.arange(40), np.sort(rng.uniform(-0.01, 0.8, 200))
    sent, yaw = rng.standard_normal(200), rng.uniform(-3.0, 3.0, 200)
    pose = Topic("pose", stamps, {"pose.x": stamps})
    drive = Topic("drive", sent_at, {"drive.steer_cmd": sent, "drive.yaw_cmd": yaw})
    table = put_together((pose, drive), ["pose.x", "drive.steer_cmd", "drive.yaw_cmd"])
    fine = stamps[:, None] + 1e-6 * (np.arange(20_000) + 0.5)  # of a row every microsecond
    held = sent[np.searchsorted(sent_at, fine, side="right") - 1].mean(1)
    np.testing.assert_allclose(table["drive.steer_cmd"], held, atol=1e-3)
    assert np.isin(table["drive.yaw_cmd"], yaw).all()


def test_a_pose_counts_at_the_stamp_of_its_header(tmp_path: Path) -> None:
    path, spec = bag(tmp_path, late=0.08)
    late = read_log(path, spec)
    (tmp_path / "now").mkdir()
    prompt = read_log(*bag(tmp_path / "now"))
    np.testing.assert_allclose(late.state, prompt.state, atol=1e-9)
    np.testing.assert_allclose(late.action, prompt.action, atol=1e-9)


def test_a_sensor_whose_clock_is_another_counts_when_it_was_recorded(tmp_path: Path) -> None:
    """Its stamps lie an hour back: beside them the drive would have no command at all."""
    path = write_bag(tmp_path / "clock.bag", 1, {**poses(), "t": POSES_AT - 3600.0}, commands(), late=3600.0)
    _, spec = bag(tmp_path)
    log = read_log(path, spec)
    np.testing.assert_allclose(log.state, read_log(tmp_path / "drive.bag", spec).state, atol=1e-6)


def test_a_topic_that_falls_silent_cuts_the_log(tmp_path: Path) -> None:
    there = (POSES_AT < 4.0) | (POSES_AT >= 5.0)
    imu = {"t": POSES_AT, "z": np.sin(POSES_AT)}
    slow = {"t": POSES_AT[there][::2], **{k: v[there][::2] for k, v in poses().items() if k != "t"}}
    path = write_mcap(tmp_path / "drive.mcap", {"imu": imu, "pose": slow})
    spec = LogSpec.parse('[time]\ndt = 0.02\n[columns]\nx = "pose.x"\ny = "pose.y"\nwz = "imu.z"\n')
    pieces = read_logs(path, spec)
    assert [piece.name for piece in pieces] == ["drive#1", "drive#2"]
    assert pieces[0].time[-1] - pieces[0].time[0] == pytest.approx(4.0, abs=0.05)


def test_topics_that_nobody_asks_for_change_nothing(tmp_path: Path) -> None:
    path, spec = FORMATS["mcap"](tmp_path)
    plain = read_log(path, spec)
    sent = commands()
    noise = {"t": np.arange(0.0, 12.0, 0.001), "current": np.random.default_rng(0).normal(size=12000)}
    drive_topic = {"t": sent["t"], "steering_angle": sent["steer"], "speed": sent["speed"]}
    write_mcap(path, {"noise": noise, "drive": drive_topic, "pose": poses()})
    again = read_log(path, spec)
    assert again.state.tobytes() == plain.state.tobytes()
    assert again.action.tobytes() == plain.action.tobytes()


def test_between_messages_an_angle_turns_the_short_way_and_a_quaternion_has_one_sign() -> None:
    slow, fast = np.array([0.0, 0.1, 0.2]), np.arange(0.0, 0.2, 0.02)
    yaw = np.array([3.1, -3.1, -3.0])
    half = np.array([0.1, 0.12, 0.14])
    quaternion = {"w": np.cos(half) * [1, -1, 1], "z": np.sin(half) * [1, -1, 1], "x": 0 * half, "y": 0 * half}
    pose = {"pose.yaw": yaw, **{f"pose.orientation.{axis}": values for axis, values in quaternion.items()}}
    imu = Topic("imu", fast, {"imu.gyro.z": fast, "imu.gyro.x": fast})
    table = put_together((Topic("pose", slow, pose), imu), ["pose.yaw", "imu.gyro.z", "pose.orientation.w"])
    assert len(table["t"]) == len(fast)
    turned = np.unwrap(yaw)
    np.testing.assert_allclose(table["pose.yaw"], np.interp(fast, slow, turned), atol=1e-12)
    assert np.all(table["pose.orientation.w"] > 0.98)


@pytest.mark.parametrize("attitude", ["heading", "quaternion"])
def test_what_a_specification_says_of_an_attitude_counts_whatever_its_columns_are_called(
    attitude: str, tmp_path: Path
) -> None:
    slow, fast = 0.1 * np.arange(120), 0.02 * np.arange(590)
    turned = RATE * slow
    course = (turned + np.pi) % (2 * np.pi) - np.pi
    half = np.stack([np.cos(turned / 2), 0 * turned, 0 * turned, np.sin(turned / 2)])
    half[:, ::3] *= -1.0  # the same attitude
    place = [RADIUS * np.sin(turned), RADIUS * (1 - np.cos(turned))]
    header, values = ("course", [course]) if attitude == "heading" else ("r1,r2,r3,r4", [*half])
    pose = np.stack([slow, *place, *values], axis=1)
    board = np.stack([fast, *np.outer([0.2, 0.9, RATE], 1 + 0 * fast)], axis=1)
    np.savetxt(tmp_path / "pose.csv", pose, delimiter=",", header=f"t,e1,e2,{header}", comments="")
    np.savetxt(tmp_path / "board.csv", board, delimiter=",", header="t,steering,speed,gyro_z", comments="")
    told = '[attitude]\nquaternion = ["r1", "r2", "r3", "r4"]' if attitude == "quaternion" else 'yaw = "course"'
    spec = LogSpec.parse(f'[columns]\nx = "e1"\ny = "e2"\nsteer = "steering"\nspeed = "speed"\nwz = "gyro_z"\n{told}\n')
    log = read_log([tmp_path / "pose.csv", tmp_path / "board.csv"], spec, CAR, dt=0.02)
    read = np.unwrap(np.arctan2(log.column("sin_yaw"), log.column("cos_yaw")))
    np.testing.assert_allclose(read, RATE * log.time, atol=1e-3)


def test_small_angles_in_degrees_stay_what_they_are() -> None:
    """A hover's roll of a few degrees looks like radians, and changes by more than π of them between messages."""
    slow, fast = 0.1 * np.arange(40), 0.02 * np.arange(190)
    roll = np.where(np.arange(40) % 4 < 2, 2.6, -1.4)
    topics = (Topic("fast", fast, {"fast.x": fast}), Topic("board", slow, {"board.roll": roll}))
    table = put_together(topics, ["fast.x", "board.roll"])
    np.testing.assert_allclose(table["board.roll"], np.interp(fast, slow, roll), atol=1e-12)


def test_an_angle_that_is_missing_once_is_there_again_afterwards() -> None:
    slow, fast = 0.1 * np.arange(10), 0.02 * np.arange(45)
    yaw = np.linspace(0.0, 0.9, 10)
    yaw[3] = np.nan
    table = put_together((Topic("fast", fast, {"fast.x": fast}), Topic("pose", slow, {"pose.yaw": yaw})))
    known = (fast <= 0.2) | (fast >= 0.4)
    np.testing.assert_allclose(table["pose.yaw"][known], fast[known], atol=1e-12)


def test_messages_out_of_order_and_twice_are_put_in_order() -> None:
    topic = Topic("a", np.array([0.2, 0.0, 0.1, 0.1]), {"a.x": np.array([2.0, 0.0, 1.0, 1.5])})
    np.testing.assert_array_equal(topic.in_order().stamps, [0.0, 0.1, 0.2])
    np.testing.assert_array_equal(topic.in_order().columns["a.x"], [0.0, 1.5, 2.0])


@pytest.mark.parametrize("ros", [1, 2])
def test_inspect_proposes_topics_and_fields(ros: int, tmp_path: Path) -> None:
    path, spec = bag(tmp_path, ros)
    proposed = inspect_logs(path).spec
    assert proposed.columns["x"].column == f"{POSE}.pose.position.x"
    assert proposed.columns["steer"].column == f"{DRIVE}.steering_angle"
    assert proposed.columns["speed"].column == f"{DRIVE}.speed"
    assert proposed.attitude.quaternion == spec.attitude.quaternion


def test_a_card_as_the_firmware_names_it_opens(tmp_path: Path) -> None:
    path, spec = FORMATS["card"](tmp_path)
    named = path.rename(tmp_path / "log07")
    assert len(read_logs(tmp_path, spec)) == 1
    assert len(read_log(named, spec)) > 200


def test_a_card_that_was_pulled_out_opens_as_far_as_it_goes(tmp_path: Path) -> None:
    path, spec = FORMATS["card"](tmp_path)
    whole = read_log(path, spec)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    half = read_log(path, spec)
    assert 0.4 < len(half) / len(whole) < 0.6
    np.testing.assert_array_equal(half.state[:-1], whole.state[: len(half) - 1])


@pytest.mark.parametrize("kind", FORMATS)
def test_a_damaged_file_gives_one_error_or_what_is_left_of_it(kind: str, tmp_path: Path) -> None:
    path, spec = FORMATS[kind](tmp_path)
    file = max(path.iterdir(), key=lambda inside: inside.stat().st_size) if path.is_dir() else path
    content = file.read_bytes()
    rng = np.random.default_rng(7)
    refused = 0
    for _ in range(12):
        damaged = bytearray(content[: int(rng.integers(1, len(content)))] if rng.random() < 0.5 else content)
        for place in rng.integers(0, len(damaged), 20):
            damaged[place] = int(rng.integers(256))
        file.write_bytes(damaged)
        try:
            log = read_logs(path, spec)
        except DataError as error:
            refused += 1
            assert str(path) in str(error)
        else:
            assert all(np.isfinite(piece.state).all() for piece in log)
    file.write_bytes(b"nonsense")
    with pytest.raises(DataError, match=path.name):
        read_log(path, spec)
    assert refused > 0


def test_a_column_that_no_topic_has_is_named(tmp_path: Path) -> None:
    path, spec = FORMATS["mcap"](tmp_path)
    wrong = LogSpec.parse(spec.toml().replace("pose.x", "pose.xx"))
    with pytest.raises(DataError, match=r"drive\.mcap.*'pose\.xx'.*did you mean 'pose\.x'"):
        read_log(path, wrong)


@pytest.mark.parametrize(
    ("kind", "library"), [("ros1", "rosbags.highlevel"), ("mcap", "mcap.reader"), ("ulog", "pyulog")]
)
def test_without_the_extra_the_command_that_installs_it_is_told(
    kind: str, library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, spec = FORMATS[kind](tmp_path)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'sym2real\[recordings\]'"):
        read_log(path, spec)


def test_messages_in_another_encoding_are_refused_by_its_name(tmp_path: Path) -> None:
    from mcap.writer import Writer

    path = tmp_path / "drive.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("Pose", "protobuf", b"")
        writer.add_message(writer.register_channel("pose", "protobuf", schema), 0, b"\x08\x01", 0)
        writer.finish()
    with pytest.raises(DataError, match="expected messages in json or cdr, found messages in protobuf"):
        read_log(path)


BLACKBOX = (
    "loopIteration,time (us),rcCommand[0],rcCommand[3],setpoint[0],vbatLatest (V),gyroADC[0],gyroADC[1],gyroADC[2],"
    "motor[0],motor[1],motor[2],motor[3],flightModeFlags (flags)"
)


@pytest.mark.parametrize("explorer", [False, True], ids=["blackbox_decode", "Blackbox Explorer"])
def test_betaflights_blackbox_opens_with_the_settings_ahead_or_without(explorer: bool, tmp_path: Path) -> None:
    """blackbox_decode puts units behind the names and spaces into the cells; the Explorer puts its settings ahead."""
    at = np.arange(400) * 2000
    rates = np.round(200.0 * np.sin(at * 1e-6 * np.array([[3.0], [5.0], [7.0]])))
    rows = [
        f"{i}, {t}, 0, 1500, 0, 15.8, {x:g}, {y:g}, {z:g}, 900, 910, 920, 930, ANGLE_MODE"
        for i, (t, (x, y, z)) in enumerate(zip(at, rates.T, strict=True))
    ]
    header, ahead = BLACKBOX, []
    if explorer:
        header = ",".join(f'"{name.split(" (")[0]}"' for name in BLACKBOX.split(","))
        ahead = [
            '"Product","Blackbox flight data recorder by Nicholas Sherlock"',
            '"firmwareType","Cleanflight"',
            '"looptime","125"',
        ]
    path = tmp_path / "LOG00001.01.csv"
    path.write_text("\n".join([*ahead, header, *rows]) + "\n")
    proposed = inspect_logs(path).spec
    assert (proposed.columns["wx"].column, proposed.columns["motor4"].column) == ("gyroADC[0]", "motor[3]")
    time = "time" if explorer else "time (us)"
    text = f'[time]\ncolumn = "{time}"\nunit = "us"\n[columns]\nwx = {{ column = "gyroADC[0]", unit = "deg/s" }}\n'
    log = read_log(path, LogSpec.parse(text + 'motor1 = "motor[0]"\n'))
    np.testing.assert_allclose(np.diff(log.time), 0.002, atol=1e-9)
    np.testing.assert_allclose(log.column("wx"), np.deg2rad(rates[0]), atol=1e-12)
    path.write_text(path.read_text() + "1, 2\n")
    with pytest.raises(DataError, match=f"row {len(ahead) + 402}: expected 14 values"):
        read_log(path, LogSpec.parse(text))
