"""Mistakes of a user in healthy logs: each is named and undone, whichever robot and size, and nothing else ever is."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import torch
from broken_logs import times
from noisy_flights import flights
from paper_robots import PAPER_ROBOTS
from scipy.signal import lfilter
from standard_set import Case, simulate_case

from sym2real.control.logged import Replayed
from sym2real.dataset import Dataset
from sym2real.diagnosis import add, data_report
from sym2real.diagnosis.faults import sanity
from sym2real.diagnosis.faults.fault import Breach
from sym2real.diagnosis.faults.misread_attitudes import FROM_WORLD, OfAttitude
from sym2real.diagnosis.faults.mistakes.balance import Balances
from sym2real.diagnosis.faults.mistakes.judge import mistakes
from sym2real.diagnosis.faults.mistakes.rows import bad_rows, joints_that_jump
from sym2real.diagnosis.faults.mistakes.transformation import Exchanged, Late, OtherAxes, Transformation, Turned, of_all
from sym2real.diagnosis.faults.sanity import check
from sym2real.diagnosis.faults.sensor_readings import readings
from sym2real.diagnosis.faults.units import Scaled
from sym2real.logs.differences import rates_on_time
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, car
from sym2real.robots.mushr import WHEELBASE
from sym2real.symbolic import compile_model, rollout
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import ATTITUDE

P, V, W = ("x", "y", "z"), ("vx", "vy", "vz"), ("wx", "wy", "wz")
QUATERNION, HEADING, RATE_COMMANDS = ATTITUDE.columns, ("sin_yaw", "cos_yaw"), tuple(f"{name}_cmd" for name in W)
SWAPPED, MIRRORED, DOWN = (("y", "x", "z"), (1, 1, 1)), (("x", "y", "z"), (1, -1, 1)), (("x", "y", "z"), (1, 1, -1))


@cache
def healthy(robot: str) -> Dataset:
    return simulate_case(Case(robot, (), seed=71, yaw=robot == "crazyflie"), trajectories=4, rows=260)


def exchanged(vectors: tuple[tuple[str, ...], ...], order: tuple[str, ...], signs: tuple[int, ...]) -> Exchanged:
    places = [P.index(axis) for axis in order[: len(vectors[0])]]
    columns = tuple(name for vector in vectors for name in vector)
    return Exchanged(columns, tuple(v[i] for v in vectors for i in places), signs[: len(places)] * len(vectors))


def listed(robot: str) -> Iterator[Transformation]:
    """One of every kind, angles and shifts drawn."""
    rng = np.random.default_rng(len(robot))
    angle = float(rng.choice([-1, 1]) * rng.uniform(0.6, 2.8))
    dt = ROBOTS[robot].dt
    if robot == "crazyflie":
        for vectors in ((P,), (V,), (P, V), (W,), (RATE_COMMANDS,)):
            yield exchanged(vectors, *SWAPPED)
        yield Scaled((*P, *V), 0.1)
        yield exchanged((P, V), *MIRRORED)
        yield exchanged((P, V), *DOWN)
        yield from (OtherAxes(V, "body"), OtherAxes(W, "world"), FROM_WORLD)
        yield OfAttitude(("roll", "pitch"), ("pitch", "roll"), (1, 1), QUATERNION)
        yield from (Turned(field, angle) for field in ("attitude", "position", "velocity"))
        yield Turned("attitude", np.pi)
        yield from (Late("rate", W, 4, dt), Late("attitude", QUATERNION, 5, dt), Late("position", P, 4, dt))
        yield from (Late("commands", ("thrust", *RATE_COMMANDS), rows, dt) for rows in (1, 4))
    else:
        yield from (exchanged(vectors, *SWAPPED) for vectors in ((P[:2],), (V[:2],), (P[:2], V[:2])))
        yield exchanged((P[:2], V[:2]), *MIRRORED)
        yield Exchanged(HEADING, HEADING[::-1], (1, 1))
        yield Scaled((*P[:2], *V[:2]), 10.0)
        yield OtherAxes(V[:2], "body")
        yield from (Turned("heading", angle), Turned("heading", np.pi))
        yield from (Late("position", P[:2], 3, dt), Late("commands", ("steer", "speed"), 1, dt))


def made(one: Transformation, log: Trajectory) -> Trajectory:
    """A right log with the mistake in it."""
    if isinstance(one, Exchanged) and not isinstance(one, OfAttitude):
        pairs = zip(one.columns, one.sources, one.signs, strict=True)
        return log.with_columns({own: sign * log.column(other) for own, other, sign in pairs})
    if isinstance(one, OtherAxes):
        return replace(one, logged="world" if one.logged == "body" else "body").undone(log)
    if isinstance(one, Turned):
        return replace(one, angle=-one.angle).undone(log)
    if isinstance(one, Late):
        return replace(one, rows=-one.rows).undone(log)
    if isinstance(one, Scaled):
        return replace(one, factor=1.0 / one.factor).undone(log)
    return one.undone(log)


@pytest.mark.parametrize("rows", [-6, -2, 2, 6])
@pytest.mark.parametrize("columns", [W, ("thrust", *RATE_COMMANDS)])
def test_shifts_are_compared_without_the_rows_that_they_make_up(columns: tuple[str, ...], rows: int) -> None:
    """A log that begins in a hard turn: what was sent before is unknown, and held ends cost a right shift its place."""
    late, inside = Late("", columns, rows, CRAZYFLIE.dt), slice(20, 221)
    balances = Balances.of(CRAZYFLIE.nominal(), healthy("crazyflie"))
    assert balances is not None
    cut_last = Dataset(late.undone(log).rows(inside.start, inside.stop) for log in healthy("crazyflie"))
    cut_first = Dataset(late.undone(log.rows(inside.start, inside.stop)) for log in healthy("crazyflie"))
    np.testing.assert_array_equal(balances.inside(cut_last).losses, balances.inside(cut_first).losses)
    assert (balances(cut_last).losses != balances(cut_first).losses).any()


CASES = [(robot, one) for robot in PAPER_ROBOTS for one in listed(robot)]


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "one"), CASES, ids=[f"{robot}: {one.name}" for robot, one in CASES])
def test_a_mistake_is_named_and_undone(robot: str, one: Transformation, monkeypatch: pytest.MonkeyPatch) -> None:
    data, model = healthy(robot), ROBOTS[robot].nominal()
    broken = Dataset(made(one, log).rows(10, len(log) - 10) for log in data)  # shifts hold the ends
    for log, whole in zip(of_all(one, broken), data, strict=True):
        original, inside = whole.rows(10, len(whole) - 10), slice(10, -10)
        np.testing.assert_allclose(log.state[inside], original.state[inside], atol=1e-9)
        np.testing.assert_allclose(log.action[inside], original.action[inside], atol=1e-12)
    asked = list[Breach]()

    def noted(*given: Any) -> list[Breach]:
        answer = mistakes(*given)
        asked.extend(answer)
        return answer

    monkeypatch.setattr(sanity, "mistakes", noted)
    checked = check(model, broken)
    if isinstance(one, Late) and not asked:  # against its rates
        (fault,) = checked.faults
        said = re.match(rf"{one.what} ([\d.]+) rows late \({' '.join(one.columns)} by", fault.evidence)
        assert said
        assert abs(float(said[1]) - one.rows) <= 0.5  # velocities by differences are half a row late
        return
    (found,) = asked
    named = found.transformation
    assert type(named) is type(one)
    if isinstance(one, Turned) and isinstance(named, Turned):
        assert named.field == one.field
        assert abs(np.angle(np.exp(1j * (named.angle - one.angle)))) < np.deg2rad(6.0)
    elif isinstance(one, Late) and isinstance(named, Late):
        # Velocities by differences are half a row late.
        assert (named.what, named.columns, abs(named.rows - one.rows) <= 1) == (one.what, one.columns, True)
    else:
        assert named == one
        for log, right in zip(checked.data, rates_on_time(of_all(one, broken)), strict=True):
            np.testing.assert_allclose(log.state, right.state, atol=1e-9)
            np.testing.assert_allclose(log.action, right.action, atol=1e-12)
    assert [fault.evidence for fault in checked.faults] == [found.evidence]
    if isinstance(one, OtherAxes):  # of each robot one or two: compare has the same list of looks
        assert data_report(broken, model).faults[0].evidence == found.evidence


@pytest.mark.parametrize(
    ("robot", "late", "rate"),
    [
        ("crazyflie", Late("attitude", QUATERNION, 2, 0.02), "wx"),
        ("crazyflie", Late("position", P, 2, 0.02), "vx"),
        ("mushr", Late("heading", HEADING, 2, 0.05), "wz"),
    ],
    ids=lambda given: getattr(given, "what", given),
)
def test_no_rate_is_early_what_it_is_of_is_late(robot: str, late: Late, rate: str) -> None:
    """Two rows, which noise hides from the balance: the sensors' own clocks tell."""
    broken = Dataset(made(late, log).rows(10, len(log) - 10) for log in healthy(robot))
    (fault,) = check(ROBOTS[robot].nominal(), broken).faults
    # Velocities by differences are half a row late themselves.
    rows = "1.5" if late.what == "position" else "2"
    assert re.match(rf"{late.what} {rows} rows late \({' '.join(late.columns)} by", fault.evidence)
    assert not any(reading.column == rate for reading in readings(of_all(late, broken)))


@pytest.mark.parametrize("robot", PAPER_ROBOTS)
def test_a_velocity_behind_a_filter_is_late_by_what_it_is_and_no_position_early(robot: str) -> None:
    """Held against the position alone, both would be the same two rows."""

    def filtered(log: Trajectory) -> Trajectory:
        return log.with_columns({name: slow(log.column(name)) for name in V if name in log.layouts.state})

    def slow(values: Array) -> Array:
        found: Array = values[0] + lfilter([0.5], [1.0, -0.5], values - values[0])
        return found

    faults = check(ROBOTS[robot].nominal(), Dataset(map(filtered, healthy(robot)))).faults
    assert {fault.effect for fault in faults} == {"time_shift:vx", "time_shift:vy"}


def test_one_early_rate_among_others_makes_nothing_else_late() -> None:
    early = Late("velocity", ("vx",), -2, 0.02)
    broken = Dataset(made(early, log).rows(10, len(log) - 10) for log in healthy("crazyflie"))
    assert {fault.effect for fault in check(ROBOTS["crazyflie"].nominal(), broken).faults} == {"time_shift:vx"}


@pytest.mark.parametrize("factor", [np.rad2deg(1.0), 265.0], ids=["degrees", "percent"])
def test_a_steering_in_another_unit_mirrors_no_world(factor: float) -> None:
    (fault,) = check(ROBOTS["mushr"].nominal(), times(healthy("mushr"), {"steer": factor})).faults
    assert fault.evidence.startswith("steer in")


def test_heights_above_the_origin_count_up() -> None:
    """The ground lifts what comes near it, so that less thrust goes with more lift."""
    down = of_all(exchanged((P, V), *DOWN), healthy("crazyflie"))
    raised = Dataset(log.with_columns({"z": log.column("z") + 5.0}) for log in down)
    (breach,) = mistakes(CRAZYFLIE.nominal(), down)
    assert "z down" in breach.transformation.name
    assert not any("z" in getattr(other.transformation, "name", "") for other in mistakes(CRAZYFLIE.nominal(), raised))


def test_one_reversed_rate_turns_no_heading_about() -> None:
    (fault,) = check(ROBOTS["mushr"].nominal(), times(healthy("mushr"), {"wz": -1.0})).faults
    assert fault.effect == "sensor_sign:wz"


def test_a_command_that_is_cut_off_for_nearly_all_of_a_log_is_at_its_limit() -> None:
    cut = float(np.quantile(np.concatenate([log.column("speed") for log in healthy("mushr")]), 0.02))
    logs = (log.with_columns({"speed": np.minimum(log.column("speed"), cut)}) for log in healthy("mushr"))
    assert any(note.startswith(f"speed stays at its end {cut:.3g} m/s") for note in check(None, Dataset(logs)).notes)


EFFECTS = (
    *(("crazyflie", key, values) for key, values in (
        ("", {}), ("linear_drag", {"cx": 0.03, "cy": 0.03, "cz": 0.03}), ("delay", {"value": 0.06}),
        ("motor_lag", {"value": 0.07}), ("mounting_tilt", {"roll": 0.15, "pitch": -0.1}),
        ("periodic_force", {"fx": 0.03, "fy": 0.02, "fz": 0.0, "omega": 9.0}), ("wind", {"fx": 0.03, "fy": -0.02}),
    )),
    *(("mushr", key, values) for key, values in (
        ("", {}), ("lever_arm", {"rx": 0.2, "ry": 0.0}), ("yaw_bias", {"value": 0.15}), ("delay", {"value": 0.2}),
        ("lag:steer", {"value": 0.15}), ("tyre_friction", {"value": 0.3}), ("gain:steer", {"value": 0.6}),
    )),
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "key", "values"), EFFECTS, ids=[f"{robot} {key}" for robot, key, _ in EFFECTS])
def test_no_effect_is_taken_for_a_mistake(robot: str, key: str, values: dict[str, float]) -> None:
    data = simulate_case(Case(robot, ((key, values),) if key else (), seed=72), trajectories=3, rows=260)
    assert mistakes(ROBOTS[robot].nominal(), data) == []
    assert bad_rows(data) == []


@pytest.mark.parametrize("time_constant", [0.04, 0.08])
def test_a_speed_that_is_told_in_another_unit_mirrors_no_velocity(time_constant: float) -> None:
    """Four times the speed is too far ahead: with a velocity of the other sign a fast loop would go just right."""
    model = car(WHEELBASE, time_constant=time_constant, dt=ROBOTS["mushr"].dt)
    assert mistakes(model, times(healthy("mushr"), {"speed": 3.6})) == []


@pytest.mark.slow
def test_a_mirrored_command_is_seen_by_a_model_with_hidden_states() -> None:
    """A lag that began anew with every row would let a command show in none."""
    lag = ("motor_lag", {"value": 0.06})
    data, model = simulate_case(Case("crazyflie", (lag,), seed=73), 3, 260), add(CRAZYFLIE.nominal(), *lag)
    assert check(model, data).faults == ()
    (fault,) = check(model, times(data, {"wy_cmd": -1.0})).faults
    assert fault.evidence.startswith("wy_cmd with the wrong sign")


@pytest.mark.parametrize("rows", [2, 3, 4])
def test_late_commands_make_no_late_sensor(rows: int) -> None:
    """Attitude and rates answer late together, which no sensor is; a row is named by another rule."""
    data = flights()
    late = Dataset(Late("commands", log.layouts.action.columns, rows, log.dt).undone(log) for log in data)
    assert mistakes(ROBOTS["crazyflie"].nominal(), late) == []


def with_state(data: Dataset, columns: tuple[str, ...], rng: np.random.Generator, change: str) -> Dataset:
    def broken(log: Trajectory) -> Trajectory:
        state, places = log.state.copy(), log.layouts.state.indices(columns)
        rows = np.arange(len(log))
        if change == "repeat":
            held = rng.random(len(log)) < 1 / 3
            held[0] = False
            state = state[np.maximum.accumulate(np.where(held, 0, rows))]
        elif change == "freeze":
            state[80:120, places] = state[80, places]
        elif change == "excursion":
            state[60:67, places[0]] += 0.5
        else:
            state[130:, places[0]] -= 0.5
        return replace(log, state=state)

    return Dataset(broken(log) for log in data)


@pytest.mark.parametrize("robot", PAPER_ROBOTS)
@pytest.mark.parametrize("change", ["repeat", "freeze", "excursion", "jump"])
def test_rows_that_repeat_or_jump_are_named_and_mended(robot: str, change: str) -> None:
    data, model = healthy(robot), ROBOTS[robot].nominal()
    position = P[: 3 if robot == "crazyflie" else 2]
    broken = with_state(data, position, np.random.default_rng(9), change)
    found = check(model, broken)
    (fault,) = found.faults
    assert ("repeat" if change in {"repeat", "freeze"} else "jumps") in fault.evidence
    assert bad_rows(found.data) == []
    assert len(found.data) >= len(data) * (1 if change == "repeat" else 2)
    for log in found.data:
        step = np.abs(np.diff(log.state[:, log.layouts.state.indices(position)], axis=0))
        assert step.max() < 0.2
    assert found.data.rows >= data.rows - (0 if change == "jump" else 50) * len(data)
    assert data_report(broken, model).faults[0].evidence == fault.evidence


@pytest.mark.parametrize("robot", PAPER_ROBOTS)
def test_a_component_that_stands_while_the_others_go_on_is_named_and_cut(robot: str) -> None:
    def broken(log: Trajectory) -> Trajectory:
        return log.with_columns({"vy": np.where(np.arange(len(log)) < 120, log.column("vy"), log.column("vy")[120])})

    data = healthy(robot)
    found = check(ROBOTS[robot].nominal(), Dataset(map(broken, data)))
    (fault,) = found.faults
    assert fault.name == "vy stands"
    assert all(len(log) <= 121 for log in found.data)


def test_a_component_that_is_zero_stands_nowhere() -> None:
    """Straight along an axis, then a turn: exact logs hold zeros for as long as there is no motion."""
    (log, *_) = healthy("mushr")
    straight = log.with_columns({"vy": np.where(np.arange(len(log)) < 80, 0.0, log.column("vy"))})
    assert bad_rows(Dataset([straight])) == []


@pytest.mark.parametrize("row", [3, 5, 20])
def test_a_component_that_stands_nearly_throughout_is_no_error(row: int) -> None:
    (log, *_) = healthy("mushr")
    rows = np.arange(len(log))
    standing = log.with_columns({"vy": np.where(rows < row, log.column("vy"), log.column("vy")[row])})
    assert len(check(ROBOTS["mushr"].nominal(), Dataset([standing])).data) == 1


def test_a_velocity_in_coarse_steps_stands_nowhere() -> None:
    """In steps of a tenth a component often keeps its value for long while the others change."""
    coarse = (log.with_columns({n: np.round(log.column(n), 1) for n in ("vx", "vy", "vz")}) for log in flights())
    assert [bad for bad in bad_rows(Dataset(coarse)) if bad.kind == "stand"] == []


def test_a_car_at_rest_repeats_nothing() -> None:
    (log, *_) = healthy("mushr")
    state: Array = np.repeat(log.state[:1], len(log), axis=0)
    assert bad_rows(Dataset([replace(log, state=state)])) == []
    state = log.state.copy()
    state[100:] = state[100]
    assert bad_rows(Dataset([replace(log, state=state)])) == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4, 5])
def test_a_strong_drag_under_precise_velocities_turns_no_heading(seed: int) -> None:
    """What misses hardly anything misses three times less by chance of its form: that is no turn by thirty degrees."""
    logs = simulate_case(Case("crazyflie", (("quadratic_drag", {"value": 0.05}),), seed=seed), trajectories=6, rows=220)
    assert check(CRAZYFLIE.nominal(), rates_on_time(logs)).faults == ()


def test_what_is_let_go_under_full_force_does_not_jump() -> None:
    """A light joint that has 30 rad/s within a row and comes to rest by its damping, then stands but for noise."""
    robot, rows = ROBOTS["cart_pole"], 400
    joint, rate = (robot.layouts.state.index(name) for name in ("pole", "pole_rate"))
    state = np.random.default_rng(0).normal(0.0, 1e-3, (rows, len(robot.layouts.state)))
    speed = 30.0 * np.exp(-np.arange(rows) / 3.0) * (np.arange(rows) > 0)
    state[:, rate] += speed
    state[1:, joint] += np.cumsum(0.5 * (speed[1:] + speed[:-1])) * robot.dt
    quiet = np.zeros((rows, len(robot.layouts.action))), np.zeros((rows, len(robot.layouts.inputs)))
    log = Trajectory(np.arange(rows) * robot.dt, state, *quiet, robot.layouts)
    assert not joints_that_jump(Dataset([log]))
    state[200:, joint] += 0.3
    (jump,) = joints_that_jump(Dataset([replace(log, state=state)]))
    assert (jump.columns, jump.cuts) == (("pole",), ((200,),))


def test_what_a_torque_throws_within_a_row_does_not_jump() -> None:
    """A cart that stands but for one row of full force each way; MuJoCo throws it, a sensor's spike stays one."""
    robot = ROBOTS["cart_pole"]
    pushes = np.zeros((90, 1))
    pushes[20], pushes[21] = 10.0, -10.0
    log = run_episode(MujocoPlant(robot), Replayed(pushes), start=np.zeros(4), steps=90)
    state = log.state + np.random.default_rng(0).normal(0.0, 1e-4, log.state.shape)
    rate = robot.layouts.state.index("slider_rate")
    thrown = Dataset([replace(log, state=state)])
    assert [bad.columns for bad in joints_that_jump(thrown)] == [("slider_rate",), ("pole_rate",)]
    assert joints_that_jump(thrown, robot.nominal()) == []
    state = state.copy()
    state[50, rate] += 1.0
    (spike,) = joints_that_jump(Dataset([replace(log, state=state)]), robot.nominal())
    assert (spike.columns, np.flatnonzero(spike.rows[0]).tolist()) == (("slider_rate",), [50])


def test_spikes_of_a_yaw_rate_are_told_though_the_model_forgets_them_within_a_row() -> None:
    """A bicycle turns as it steers: from a spike it predicts the way back, and the way to it from nowhere."""

    def spiked(log: Trajectory) -> Trajectory:
        return log.with_columns({"wz": log.column("wz") + np.where(np.arange(len(log)) % 90 == 60, 5.0, 0.0)})

    data = healthy("mushr")
    found = check(ROBOTS["mushr"].nominal(), Dataset(map(spiked, data)))
    (fault,) = found.faults
    count = sum(len(range(60, len(log), 90)) for log in data)
    assert fault.evidence == f"wz jumps: {count} of {data.rows} rows are off by far more than any step"
    assert max(float(np.abs(log.column("wz")).max()) for log in found.data) < 4.0


def test_a_yaw_rate_that_overshoots_as_the_steering_goes_over_is_no_spike() -> None:
    """Tyres that build up a turn, ζ = 0.25 and 30 rad/s in rows of 50 ms, as it goes from the right to the left."""
    robot, rows = ROBOTS["mushr"], 400
    time = np.arange(rows) * robot.dt
    state = np.random.default_rng(0).normal(0.0, 0.01, (rows, len(robot.layouts.state)))
    damping, natural = 0.25, 30.0
    free = natural * np.sqrt(1.0 - damping**2)
    since = np.maximum(time - time[200], 0.0)
    left = np.exp(-damping * natural * since) * (np.cos(free * since) + damping * natural / free * np.sin(free * since))
    rate = robot.layouts.state.index("wz")
    state[:, rate] += 1.5 - 3.5 * left
    quiet = np.zeros((rows, len(robot.layouts.action))), np.zeros((rows, len(robot.layouts.inputs)))
    log = Trajectory(time, state, *quiet, robot.layouts)
    assert not bad_rows(Dataset([log]))
    state[100:102, rate] += (4.0, 2.5)
    (jump,) = bad_rows(Dataset([replace(log, state=state)]))
    assert jump.columns == ("wz",)
    assert np.flatnonzero(jump.rows[0]).tolist() == [100, 101]


def test_of_commands_those_alone_are_late_that_are() -> None:
    written_late = of_all(Late("commands", ("steer",), -2, ROBOTS["mushr"].dt), healthy("mushr"))
    (breach,) = mistakes(ROBOTS["mushr"].nominal(), written_late)
    assert isinstance(breach.transformation, Late)
    assert (breach.transformation.columns, breach.transformation.rows) == (("steer",), 2)


def steered(pose: float = 1e-3) -> Dataset:
    """Noisy drives of a car without a servo, with so much noise on place and heading."""
    model, rng = car(WHEELBASE, dt=0.05), np.random.default_rng(5)
    noise, start = [*[pose] * 4, 0.02, 0.02, 0.01], np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    logs = []
    for steer in lfilter([0.1], [1.0, -0.9], rng.standard_normal((4, 400))):
        action = np.column_stack([np.clip(0.3 * steer, -0.3, 0.3), np.full(400, 1.0)])
        state = rollout(compile_model(model, dtype=torch.float64), torch.as_tensor(start), torch.as_tensor(action))
        state = np.vstack([start, state.numpy()[:-1]]) + rng.normal(0.0, noise, (400, 7))
        logs.append(Trajectory(np.arange(400) * 0.05, state, action, np.zeros((400, 3)), model.layouts))
    return Dataset(logs)


@pytest.mark.parametrize("pose", [1e-3, 6e-3])
def test_a_gyro_that_is_read_when_the_next_command_is_out_makes_no_command_late(pose: float) -> None:
    """It alone says so: the heading turns with the commands as they stand, if noise hides half of that."""
    model, plain = car(WHEELBASE, dt=0.05), steered(pose)
    assert mistakes(model, plain) == []
    (breach,) = mistakes(model, of_all(Late("commands", ("steer",), -1, model.dt), plain))
    assert breach.transformation.rows == 1
    early = Dataset(Late("rate", ("wz",), 1, model.dt).undone(log) for log in plain)
    assert mistakes(model, early) == []


@pytest.mark.parametrize("robot", ["crazyflie", "mushr"])
def test_a_mistake_in_one_log_alone_is_named_there_and_undone(robot: str) -> None:
    """A command with the other sign in one of six was an error where the robot then was."""
    data, model = simulate_case(Case(robot, seed=72), trajectories=6, rows=520), ROBOTS[robot].nominal()
    command = {"crazyflie": "wy_cmd", "mushr": "steer"}[robot]
    odd = Exchanged((command,), (command,), (-1,)).undone(data[3])
    checked = check(model, Dataset([*data[:3], odd, *data[4:]]))
    assert [fault.name for fault in checked.faults] == [
        f"{command} with the wrong sign in {odd.name}, other than in other logs"
    ]
    np.testing.assert_array_equal(checked.data[3].action, check(model, data).data[3].action)
    assert not check(model, data).faults


def test_what_most_logs_have_is_undone_once_in_one_that_is_unlike_them_too() -> None:
    """Commands two rows late in all logs, and mirrored in one: that was moved by two rows twice."""
    data, model = simulate_case(Case("mushr", seed=72), trajectories=6, rows=520), ROBOTS["mushr"].nominal()
    written = Dataset(Late("commands", data.layouts.action.columns, -2, data.dt).undone(log) for log in data)
    odd = Exchanged(("steer",), ("steer",), (-1,)).undone(written[3])
    checked = check(model, Dataset([*written[:3], odd, *written[4:]]))
    assert {fault.name for fault in checked.faults} == {
        f"commands 2 rows late (steer speed by {2000 * data.dt:.0f} ms)",
        f"steer with the wrong sign in {odd.name}, other than in other logs",
    }
    assert len(checked.faults) == 2
    sent = checked.data[3].action
    np.testing.assert_array_equal(sent[:-4], data[3].action[: len(sent) - 4])


def test_pieces_of_a_few_rows_are_unlike_nothing() -> None:
    """Lost rows cut a log into pieces, of which some are shorter than what is judged by."""
    data = simulate_case(Case("crazyflie", seed=72), trajectories=6, rows=260)
    assert not check(CRAZYFLIE.nominal(), Dataset([*data, data[0].rows(0, 12)])).faults


def test_a_heading_in_degrees_in_one_log_is_named_there() -> None:
    data = simulate_case(Case("mushr", seed=72), trajectories=6, rows=260)
    yaw = np.degrees(np.unwrap(np.arctan2(data[2].column("sin_yaw"), data[2].column("cos_yaw"))))
    odd = data[2].with_columns({"sin_yaw": np.sin(yaw), "cos_yaw": np.cos(yaw)})
    (fault,) = check(MUSHR.nominal(), Dataset([*data[:2], odd, *data[3:]])).faults
    assert fault.name == f"an attitude in degrees that is read as radians in {odd.name}, other than in other logs"
