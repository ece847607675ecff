"""The report on the data: planted faults of timing, sign, frame and excitation are named; sound data give none."""

import json
from dataclasses import replace

import numpy as np
import pytest
from broken_logs import times
from standard_set import Case, simulate_case

from sym2real.control import RandomCommands, geometric_controller
from sym2real.data import example_flight
from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.mistakes.transformation import OtherAxes
from sym2real.diagnosis.faults.report import data_report
from sym2real.diagnosis.faults.sanity import check
from sym2real.experiments.standard_conditions import sensors
from sym2real.logs import read_log
from sym2real.logs.agreement import rate_agreement, velocity_agreement
from sym2real.logs.extremes import at_extremes, reversal
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.tasks import make_task
from sym2real.trajectory import Array, Trajectory


@pytest.fixture(scope="module")
def flights() -> Dataset:
    """A circle with swinging height, and a figure of eight."""
    return Dataset(list(simulate_case(Case("crazyflie", seed=3, yaw=True), 6, 150))[3:6:2])


def with_time(data: Dataset, time: Array) -> Dataset:
    return Dataset(replace(log, time=time) for log in data)


def test_sound_data_give_no_remark_on_signs_and_timing(flights: Dataset) -> None:
    report = data_report(flights)
    assert report.dt == pytest.approx(0.02)
    assert (report.gaps, report.longest_gap) == (0, 0.0)
    assert report.jitter < 1e-9
    assert {one.verdict for one in report.agreements.values()} == {"agrees"}
    assert not any("sign" in line or "axes" in line or "gap" in line for line in report.lines())


@pytest.mark.parametrize("column", ["wx", "wy", "wz"])
def test_a_reversed_rate_is_named_and_no_other(flights: Dataset, column: str) -> None:
    found = rate_agreement(list(times(flights, {column: -1.0})))
    assert {name for name, one in found.items() if one.verdict == "reversed"} == {column}
    (line,) = (line for line in data_report(times(flights, {column: -1.0})).lines() if "wrong sign" in line)
    assert f"the logged {column} and" in line


def test_a_reversed_velocity_is_named(flights: Dataset) -> None:
    found = velocity_agreement(list(times(flights, {"vy": -1.0})))
    assert found["vy"].verdict == "reversed"
    assert found["vx"].verdict == found["vz"].verdict == "agrees"


def test_velocity_in_body_axes_is_recognised() -> None:
    """A car on a circle: in body axes the velocity does not turn, in world axes it does."""
    drive = simulate_case(Case("mushr", seed=4), 1, 300)[0]
    assert {one.verdict for one in velocity_agreement([drive]).values()} == {"agrees"}
    turned = velocity_agreement([OtherAxes(("vx", "vy"), "world").undone(drive)])
    assert "agrees" not in {one.verdict for one in turned.values()}
    assert turned["vx"].in_other_frame == pytest.approx(1.0, abs=0.05)


def test_a_quadrotors_velocity_in_body_axes_is_recognised(flights: Dataset) -> None:
    turning = [OtherAxes(("vx", "vy", "vz"), "world").undone(log) for log in flights]
    assert all(
        one.in_other_frame is not None and one.in_other_frame > 0.9 for one in velocity_agreement(turning).values()
    )


def test_gaps_and_jitter_are_counted(flights: Dataset) -> None:
    rows = len(flights[0])
    gap = 0.02 * np.arange(rows) + 0.3 * (np.arange(rows) >= 50)
    report = data_report(with_time(flights, gap))
    assert report.gaps == len(flights)
    assert report.longest_gap == pytest.approx(0.32)
    assert report.jitter < 1e-6
    shaken = np.cumsum(0.02 * (1.0 + 0.2 * np.random.default_rng(0).uniform(-1, 1, rows)))
    assert data_report(with_time(flights, shaken)).jitter == pytest.approx(0.2 / np.sqrt(3), rel=0.2)


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR], ids=lambda robot: robot.name)
def test_logs_without_sensor_noise_are_named(robot: Robot) -> None:
    """Smooth paths alone look like noise of some µm to third differences, and of less than 0.1 µm to sixth."""
    task, controller = make_task("circle", robot), geometric_controller(robot, make_task("circle", robot).reference)
    noise = sensors(robot, np.random.default_rng(1))
    noisy, plain = (run_episode(MujocoPlant(robot, changes), controller, task, steps=150) for changes in ([noise], []))
    said = {name: data_report(Dataset(logs)) for name, logs in (("both", [noisy, plain]), ("noisy", [noisy]))}
    assert (said["both"].exact, said["noisy"].exact) == (1, 0)
    (line,) = (line for line in said["both"].lines() if line.startswith("no sensor noise in 1 of 2 logs"))
    assert "low-pass" in line  # a real log that was filtered has none either, and nobody can simulate it anew
    assert not any("sensor noise" in line for line in said["noisy"].lines())
    assert any(note.startswith("no sensor noise") for note in check(robot.nominal(), Dataset([plain])).notes)
    assert not any(note.startswith("no sensor noise") for note in check(robot.nominal(), Dataset([noisy])).notes)


def test_a_real_flight_has_sensor_noise() -> None:
    assert data_report(read_log(example_flight(), spec="crazyflie_battery_drag")).exact == 0


def test_saturation_and_a_command_that_never_moves_are_named(flights: Dataset) -> None:
    def limited(log: Trajectory) -> Trajectory:
        action = log.action.copy()
        action[:, 1] = np.clip(action[:, 1], -0.1, 0.1)
        action[:, 3] = 0.2
        return replace(log, action=action)

    report = data_report(Dataset(limited(log) for log in flights))
    assert report.commands["wx_cmd"].limit_notes("wx_cmd")
    assert report.commands["wz_cmd"].weak
    assert not report.commands["thrust"].limit_notes("thrust")
    said = " ".join(report.lines())
    assert "wx_cmd stays at its end" in said
    assert "wz_cmd hardly varies" in said


def test_a_short_log_is_not_at_its_limit_because_some_row_is_the_largest(flights: Dataset) -> None:
    """One row of eleven is 9 % of them; three rows in a row at one value are a command that is cut off."""
    short = flights[0].rows(0, 11)
    assert not any("limit" in line for line in data_report(short).lines())
    action = short.action.copy()
    action[4:7, 0] = action[:, 0].max() + 0.01
    cut = data_report(replace(short, action=action))
    assert cut.commands["thrust"].at_high == pytest.approx(3 / 11)
    assert any(line.startswith("thrust stays at its end") for line in cut.lines())


def test_a_command_that_alternates_from_row_to_row_is_told(flights: Dataset) -> None:
    """Noise that is drawn anew for every row is none: its changes are half undone."""
    rng = np.random.default_rng(0)
    for sway, told in ((0.02 * rng.normal(size=400), False), (0.02 * (-1.0) ** np.arange(400), True)):
        action = flights[0].action.copy()
        action[:, 0] += sway[: len(action)] + 1e-4 * rng.normal(size=len(action))
        report = data_report(replace(flights[0], action=action))
        assert (report.commands["thrust"].reversal < -0.9) is told
        assert any(line.startswith("thrust goes up and down") for line in report.lines()) is told
    assert reversal([rng.normal(size=20_000)]) == pytest.approx(-0.5, abs=0.02)
    assert reversal([(-1.0) ** np.arange(1000)]) == pytest.approx(-1.0, abs=0.01)
    assert reversal([np.arange(1000.0)]) == pytest.approx(1.0, abs=0.01)
    assert reversal([np.ones(10)]) == 0.0


def test_a_car_that_stands_is_at_no_limit(flights: Dataset) -> None:
    log = run_episode(MujocoPlant(MUSHR), RandomCommands(MUSHR, seed=1), steps=200)
    action = log.action.copy()
    action[:60, log.layouts.action.index("speed")] = 0.0
    action[:, log.layouts.action.index("speed")] = np.abs(action[:, log.layouts.action.index("speed")])
    standing = data_report(replace(log, action=action))
    assert standing.commands["speed"].at_low > 0.05
    assert not any("speed stays at its end" in line for line in standing.lines())


def test_a_command_that_is_sent_every_fifth_row_or_in_steps_is_not_at_its_limit(flights: Dataset) -> None:
    every_fifth = Dataset(replace(log, action=np.repeat(log.action[::5], 5, axis=0)[: len(log)]) for log in flights)
    assert not any(one.limit_notes("") for one in data_report(every_fifth).commands.values())
    steps = np.repeat([0.0, 0.8, 0.4, 0.8, 0.0, 0.4], 20)
    assert at_extremes([steps]) == (0.0, 0.0)
    assert at_extremes([0.3 * np.sin(0.1 * np.arange(1000)), steps]) == (0.0, 0.0)
    swing = np.clip(np.sin(0.1 * np.arange(1000)), -np.inf, 0.5)
    low, high = at_extremes([swing[:400], swing[400:]])
    assert low == 0.0
    assert high == pytest.approx(1.0 / 3.0, abs=0.02)  # arcsin 0.5 is a sixth of half a turn, twice


def test_feedback_is_told_from_commands_drawn_beforehand(flights: Dataset) -> None:
    assert data_report(flights).following
    assert not any("state" in line for line in data_report(flights).lines())  # nobody need do anything about it
    drawn = run_episode(MujocoPlant(MUSHR), RandomCommands(MUSHR, seed=1), steps=200)
    assert not data_report(drawn).following


def test_the_object_is_json(flights: Dataset) -> None:
    found = json.loads(json.dumps(data_report(flights).to_dict()))
    assert found["commands"]["thrust"]["unit"] == "N"
    assert found["agreements"]["wy"]["correlation"] > 0.9
    assert found["feedback"] is True
