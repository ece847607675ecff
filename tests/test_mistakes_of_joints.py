"""Mistakes of a user in healthy logs of his own arm: each is named, and the logs are as they were once it is undone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import two_links

from sym2real.dataset import Dataset
from sym2real.diagnosis import data_report
from sym2real.diagnosis.faults.foreign_units import Steps
from sym2real.diagnosis.faults.mistakes.transformation import Late, of_all
from sym2real.diagnosis.faults.sanity import check
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.logs import read_logs
from sym2real.logs.derive import unwrapped
from sym2real.robots import ROBOTS, Robot
from sym2real.tasks import make_task
from sym2real.trajectory import Array, Trajectory

LINKS = Robot.from_mjcf(two_links.MJCF, name="links", dt=two_links.STEP)
BASE = LINKS.nominal()
COLUMNS = two_links.COLUMNS
DEGREES = 180.0 / np.pi
Spoil = Callable[[Array], Array]


@cache
def swings() -> tuple[Array, ...]:
    return tuple(two_links.swings(seed=seed, seconds=8.0) for seed in (1, 2))


def read(spoil: Spoil) -> Dataset:
    """Logs as they come from a file, ten rows at both ends left out: shifts hold the ends."""
    return Dataset(read_rows(spoil(rows.copy())[10:-10]) for rows in swings())


def read_rows(rows: Array) -> Trajectory:
    return Trajectory.from_arrays(rows[:, 1:5], rows[:, 5:7], LINKS.layouts, time=rows[:, 0] - rows[0, 0])


def times(factor: float, *names: str) -> Spoil:
    def spoil(rows: Array) -> Array:
        rows[:, [COLUMNS.index(name) for name in names]] *= factor
        return rows

    return spoil


def swapped(*names: str) -> Spoil:
    """The first with the second, the third with the fourth."""

    def spoil(rows: Array) -> Array:
        places = [COLUMNS.index(name) for name in names]
        others = [place for pair in zip(places[1::2], places[::2], strict=True) for place in pair]
        rows[:, places] = rows[:, others]
        return rows

    return spoil


def both(first: Spoil, second: Spoil) -> Spoil:
    return lambda rows: second(first(rows))


def late(by: int) -> Spoil:
    def spoil(rows: Array) -> Array:
        rows[by:, 5:7] = rows[:-by, 5:7]
        return rows

    return spoil


CASES: Sequence[tuple[Spoil, Sequence[str]]] = (
    (times(1.0), []),
    (times(-1.0, "q1", "q1_rate"), ["q1 q1_rate mirrored"]),
    (times(-1.0, "q2", "q2_rate"), ["q2 q2_rate mirrored"]),
    (times(-1.0, "q1_rate"), ["sensor_sign:q1_rate"]),
    (times(-1.0, "q2"), ["sensor_sign:q2_rate", "q2 q2_rate mirrored"]),
    (times(-1.0, "tau1"), ["tau1 with the wrong sign"]),
    (times(DEGREES, "q1", "q2", "q1_rate", "q2_rate"), ["q1 q2 q1_rate q2_rate in deg instead of rad"]),
    (times(DEGREES, "q1", "q1_rate"), ["q1 q1_rate in deg instead of rad"]),
    (times(DEGREES, "q1", "q2"), ["q1 q2 in deg instead of rad"]),
    (times(DEGREES, "q2_rate"), ["sensor_scale:q2_rate"]),
    (times(30.0, "q2", "q2_rate"), ["q2 q2_rate in no unit of that size, or before a gear, 30"]),
    (times(1.0 / DEGREES, "q2", "q2_rate"), ["q2 q2_rate in rad that are read as deg"]),
    (times(1e3, "tau1", "tau2"), ["tau1 tau2 in mN m instead of N m"]),
    (
        both(times(1e3, "tau1", "tau2"), times(-1.0, "tau2")),
        ["tau1 tau2 in mN m instead of N m", "tau2 with the wrong sign"],
    ),
    (swapped("q1", "q2", "q1_rate", "q2_rate"), ["q1 q2 q1_rate q2_rate swapped"]),
    (swapped("q1", "q2"), ["q1 q2 swapped"]),
    (swapped("tau1", "tau2"), ["tau1 tau2 swapped"]),
    (late(1), ["commands 1 row late"]),
    (late(2), ["commands 2 rows late"]),
)


@pytest.mark.parametrize(("spoil", "said"), CASES, ids=[", ".join(said) or "healthy" for _, said in CASES])
def test_a_mistake_is_named_and_undone(spoil: Spoil, said: Sequence[str]) -> None:
    data, right = read(spoil), read(times(1.0))
    checked = check(BASE, data)
    assert len(checked.faults) == len(said)
    assert all(fault.name.startswith(words) for fault, words in zip(checked.faults, said, strict=True))
    for log, healthy in zip(checked.data, right, strict=True):
        for found, meant in ((log.state, healthy.state), (log.action, healthy.action)):
            np.testing.assert_allclose(found[5:-5], meant[5 : len(found) - 5], rtol=0.02, atol=1e-3)
    if said and "read as deg" in said[0]:
        assert 'q2 unit = "rad", q2_rate unit = "rad/s"' in checked.faults[0].fix
    if [*said] == ["q1 q1_rate mirrored"]:
        assert any(line.startswith(said[0]) for line in data_report(data, BASE).lines())


def test_commands_in_each_others_place_are_no_unit_of_one_of_them() -> None:
    """Of a base joint whose motor gives many times what the next one needs: divided by that, the latter fits better."""
    steps, right = Steps.of(BASE, read(swapped("tau1", "tau2"))), Steps.of(BASE, read(times(1.0)))
    assert steps is not None
    assert right is not None
    assert steps.exchanged() == pytest.approx(right.missed((), 1.0))
    assert steps.exchanged() < 0.01 * steps.missed((), 1.0)
    assert right.exchanged() > 100 * right.missed((), 1.0)


def test_a_joint_that_counts_the_other_way_with_its_motor_is_named() -> None:
    """Of two links that swing in one plane nothing tells which of both: mirrored in the plane, they are the same."""
    (fault,) = check(BASE, read(times(-1.0, "q2", "q2_rate", "tau2"))).faults
    for joint in ("1", "2"):
        assert f"q{joint} q{joint}_rate tau{joint} mirrored" in fault.name


CRANE = """
<mujoco model="crane">
  <compiler angle="radian"/>
  <option timestep="0.001" integrator="RK4"/>
  <worldbody>
    <body name="carriage" pos="0 0 1">
      <joint name="q1" type="slide" axis="1 0 0" range="-9 9" limited="true"/>
      <geom type="box" size="0.1 0.08 0.04" mass="1" contype="0" conaffinity="0"/>
      <body name="hook">
        <joint name="q2" axis="0 1 0" range="-2.5 2.5" limited="true" frictionloss="0"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.03" mass="0.9" contype="0" conaffinity="0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="tau1" joint="q1" ctrlrange="-15 15" ctrllimited="true"/>
    <motor name="tau2" joint="q2" ctrlrange="-8 8" ctrllimited="true"/>
  </actuator>
</mujoco>
"""


def test_a_joint_that_counts_the_other_way_is_named_where_friction_hides_its_own_motion() -> None:
    """Of a joint that friction brakes much more than the model says little can be predicted; what it moves tells."""
    model = Robot.from_mjcf(CRANE, name="crane", dt=two_links.STEP).nominal()
    rusty = CRANE.replace('frictionloss="0"', 'frictionloss="0.2"')
    rows = [two_links.swings(seed=seed, seconds=8.0, mjcf=rusty)[10:-10] for seed in (1, 2)]
    mirrored = [times(-1.0, "q2", "q2_rate")(log) for log in rows]
    data = Dataset(
        Trajectory.from_arrays(log[:, 1:5], log[:, 5:7], model.layouts, time=log[:, 0], inputs=np.zeros((len(log), 2)))
        for log in mirrored
    )
    assert [fault.name for fault in check(model, data).faults] == ["q2 q2_rate mirrored (with the other sign)"]


@pytest.mark.parametrize(("rows", "said"), [(1, ["commands 1 row late (drive by 20 ms)"]), (0, []), (-1, [])])
def test_a_row_is_told_where_a_controller_answers_noise(rows: int, said: list[str]) -> None:
    """A pole is held upright, and moves less than its rate's noise says; what acts a row later is no mistake."""
    robot = ROBOTS["cart_pole"]
    tasks = [make_task("regulate", robot, goal={"slider": place}) for place in (0.3, -0.3)]
    logs = noisy_runs(robot, tasks, count=4, rows=300, dither=2.5, seed=3)
    written = of_all(Late("commands", ("drive",), -rows, robot.dt), logs)
    assert [fault.name for fault in check(robot.nominal(), written).faults] == said


def test_an_encoder_that_begins_anew_after_a_turn_is_unwrapped(tmp_path: Path) -> None:
    """Jumps by whole turns are no motion; a jump by anything else stays, and is named."""
    plain = swings()[0]
    wrapped = plain.copy()
    wrapped[:, 1] = plain[:, 1].mean() + (plain[:, 1] - plain[:, 1].mean()) % (2 * np.pi)
    wrapped[300:305, 2] += 1.0
    log = read_logs([two_links.write(tmp_path / "wrapped.csv", wrapped)], layouts=LINKS.layouts)
    shift = log[0].column("q1") - plain[:, 1]
    np.testing.assert_allclose(shift, shift[0], atol=1e-8)
    checked = check(BASE, log)
    assert any("q1 is unwrapped" in note for note in checked.notes)
    (fault,) = checked.faults
    assert fault.name == "q2 jumps"


def test_an_angle_in_degrees_is_no_encoder_that_begins_anew(tmp_path: Path) -> None:
    """A few of its steps are more than half a turn of radians, and nothing tells such motion from a jump by a turn."""
    written = [times(DEGREES, "q2")(two_links.swings(seed=seed, seconds=8.0)) for seed in (6, 9)]
    assert all(np.abs(np.diff(log[:, 2])).max() > np.pi for log in written)
    files = [two_links.write(tmp_path / f"{i}.csv", log) for i, log in enumerate(written)]
    data = read_logs(files, layouts=LINKS.layouts)
    np.testing.assert_allclose(data[0].column("q2"), written[0][:, 2], atol=1e-6)
    checked = check(BASE, data)
    assert not any("unwrapped" in note for note in checked.notes)
    (fault,) = checked.faults
    assert fault.name == "sensor_scale:q2 (57.3)"


def test_a_fast_wheel_that_begins_anew_after_a_turn_is_unwrapped() -> None:
    """It turns by more than a quarter turn from row to row, and stays within a turn."""
    angle = 1.9 * np.arange(200.0)
    np.testing.assert_allclose(unwrapped(angle % (2 * np.pi)), angle, atol=1e-9)


def test_one_joint_of_which_every_second_row_repeats_is_named_and_the_other_is_not() -> None:
    def spoil(rows: Array) -> Array:
        places = [COLUMNS.index(name) for name in ("q2", "q2_rate")]
        rows[1::2, places] = rows[:-1:2, places]
        return rows

    checked = check(BASE, read(spoil))
    (fault,) = checked.faults
    assert fault.evidence.startswith("rows that repeat in q2 q2_rate:")
    for log, healthy, spoilt in zip(checked.data, read(times(1.0)), read(spoil), strict=True):
        known = healthy.state[: len(log)]  # the last row repeats the one before, and nothing comes after it
        np.testing.assert_array_equal(log.state[:, 0], known[:, 0])
        missed, before = (np.square(own - known)[:, [1, 3]].mean(0) for own in (log.state, spoilt.state[: len(log)]))
        assert (missed < (0.1, 0.6) * before).all()  # a rate takes another turn in every row, with its torque


def test_a_command_beyond_its_range_is_said_to_be_logged_before_it_is_cut_off() -> None:
    high = float(LINKS.high[0])

    def beyond(rows: Array) -> Array:
        rows[50:60, COLUMNS.index("tau1")] = 2.0 * high
        return rows

    (note,) = (note for note in check(BASE, read(beyond)).notes if "beyond its range" in note)
    assert note.startswith(f"tau1 goes beyond its range by the description, {-high:g} to {high:g}, in ")
    assert not any("beyond its range" in note for note in check(BASE, read(times(1.0))).notes)
