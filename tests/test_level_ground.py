"""Worlds turned about the vertical: what turns, what stays, and equations that do not know where north is.

That MuJoCo turns with them is in ``test_plants_physics.py``.
"""

import tempfile
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from paper_robots import PAPER_ROBOTS
from quick_engines import Linear
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset, Transitions
from sym2real.diagnosis import compare, diagnose
from sym2real.experiments.flights import car_drives, quadrotor_flights
from sym2real.experiments.learning import learn_from_logs
from sym2real.experiments.measured import measured
from sym2real.field import Field
from sym2real.layout import Layout, Layouts
from sym2real.level_ground import HEADINGS, Turn, any_heading_alike, at_many_headings
from sym2real.logs import write_log
from sym2real.regression import ENGINES, BeamSearch
from sym2real.robots import ROBOTS
from sym2real.robots.mushr import SPEED_TIME_CONSTANT
from sym2real.robots.robot import GRAVITY
from sym2real.symbolic import Equations, symbol
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import ATTITUDE_COMMAND


@pytest.fixture(scope="module")
def logs() -> dict[str, Trajectory]:
    return {"crazyflie": quadrotor_flights(1, 3, steps=120)[0], "mushr": car_drives(1, 3, steps=120)[0]}


@pytest.mark.parametrize("robot", PAPER_ROBOTS)
def test_a_turn_is_undone_by_its_inverse(robot: str, logs: dict[str, Trajectory]) -> None:
    log, turn = logs[robot], Turn(1.1, 0.5, -2.0)
    turned = turn.of_log(log)
    assert np.abs(turned.state - log.state).max() > 0.5
    ((x, y),) = Turn(-turn.angle).of_rows(np.array([[-turn.x, -turn.y]]), Layout.of("xy"))
    np.testing.assert_allclose(Turn(-turn.angle, x, y).of_log(turned).state, log.state, atol=1e-12)


def test_columns_in_another_order_are_turned_alike() -> None:
    turn = Turn(np.pi / 2, 1.0, 2.0)
    np.testing.assert_allclose(turn.of_rows(np.array([[3.0, 4.0]]), Layout.of("xy")), [[-3.0, 5.0]])
    np.testing.assert_allclose(turn.of_rows(np.array([[4.0, 3.0]]), Layout.of("yx")), [[5.0, -3.0]])


def test_references_turn_with_the_world(logs: dict[str, Trajectory]) -> None:
    log = logs["mushr"]
    columns = log.layouts.state.columns
    references = {f"ref_{name}": values for name, values in zip(columns, log.state.T, strict=True)}
    turned = Turn(0.7, 1.0, 2.0).of_log(replace(log, extra=references))
    for name in columns:
        np.testing.assert_array_equal(turned.extra[f"ref_{name}"], turned.column(name))


def test_forces_of_the_world_and_commanded_attitudes_turn_and_body_axes_stay() -> None:
    layout = Layout.of(["fx", "fy", "fz", "tx", "ty", "tz", *ATTITUDE_COMMAND.columns, "thrust"])
    row = np.array([[1.0, 0.0, 3.0, 4.0, 5.0, 6.0, 1.0, 0.0, 0.0, 0.0, 0.3]])
    half = np.sqrt(0.5)
    expected = [[0.0, 1.0, 3.0, 4.0, 5.0, 6.0, half, 0.0, 0.0, half, 0.3]]
    np.testing.assert_allclose(Turn(np.pi / 2, 7.0, 8.0).of_rows(row, layout), expected, atol=1e-15)


@pytest.mark.parametrize("count", [1, 3, 20])
def test_no_step_is_lost_and_there_are_many_headings(count: int, logs: dict[str, Trajectory]) -> None:
    data = Dataset([replace(logs["mushr"], name=str(number)) for number in range(count)])
    steps, own = at_many_headings(data), data.transitions()
    assert len(np.unique(steps.trajectory)) >= HEADINGS
    copies = steps.trajectory.reshape(-1, len(own)) - own.trajectory
    assert (copies % 2 == 0).all()  # as validation takes every other one, a row and its copies are on one side
    assert len(steps) % len(own) == 0
    still = [data.layouts.state.index(name) for name in ("wz",)]
    np.testing.assert_array_equal(steps.state[: len(own), still], own.state[:, still])
    speeds = (np.hypot(rows.state[:, 4], rows.state[:, 5]) for rows in (steps, own))
    np.testing.assert_allclose(next(speeds)[: len(own)], next(speeds), atol=1e-12)


@pytest.mark.slow
def test_long_logs_are_turned_piece_by_piece_and_no_longer_than_they_were() -> None:
    data = simulate_case(Case("mushr", seed=3), trajectories=8)
    steps = at_many_headings(data)
    assert len(np.unique(steps.trajectory)) == 16
    assert len(steps) == len(data.transitions())


@pytest.mark.parametrize("robot", ROBOTS)
def test_what_faces_somewhere_can_be_turned(robot: str) -> None:
    assert any_heading_alike(ROBOTS[robot].layouts) == (robot not in ("arm", "cart_pole"))


HEADING = Layout.of(["sin_yaw", "cos_yaw"]).fields
WIND = Field("wind", ("wind_x", "wind_y"), "m/s", "world")


@pytest.mark.parametrize(
    ("state", "can"),
    [
        (Layout((*HEADING, *Layout.of(["vx", "vy"]).fields)), True),
        (Layout((*HEADING, *Layout.of(["z"]).fields)), True),
        (Layout((*HEADING, *Layout.of(["vx"]).fields)), False),
        (Layout((*HEADING, WIND)), False),
        (Layout.of(["x", "y", "vx", "vy"]), False),
    ],
    ids=["a velocity", "a height", "half a velocity", "a vector of another name", "no heading"],
)
def test_half_a_vector_and_unknown_ones_are_not_turned(state: Layout, can: bool) -> None:
    assert any_heading_alike(Layouts(state, ROBOTS["mushr"].layouts.action)) == can


@cache
def learned(robot: str) -> Equations:
    """Equations of four noisy runs, as ``learn --data`` finds them, but that it begins with products of two."""
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setitem(ENGINES._entries, "beam", partial(BeamSearch, degree=2))
        paths = [Path(folder) / f"{number}.csv" for number in range(4)]
        for log, path in zip(simulate_case(Case(robot, seed=6_900_100), trajectories=4), paths, strict=True):
            write_log(log, path)
        return learn_from_logs(measured(robot), paths, None, "beam").equations


@pytest.mark.slow
@pytest.mark.parametrize("robot", PAPER_ROBOTS)
def test_equations_of_logs_predict_turned_worlds_as_well(robot: str) -> None:
    """Nobody flew to all sides: without turns a quadrotor is a hundred times as far off, a car four times."""
    equations = learned(robot)
    assert not any(equations.depends(column, place) for column in ("vx", "vy") for place in ("x", "y"))
    other = simulate_case(Case(robot, seed=6), trajectories=4)
    plain, turned = (
        compare(equations, Dataset(Turn(angle, 3.0, -2.0).of_log(log) for log in other))
        .at(0.8)
        .errors["position"]
        .value
        for angle in (0.0, 2.0)
    )
    assert turned < 1.2 * plain


def slope(robot: str, column: str, by: str, **values: float) -> float:
    """Derivative of what follows in a column by a name, at rest on level ground but for some values."""
    rest = dict.fromkeys(learned(robot).names, 0.0) | {"qw": 1.0, "cos_yaw": 1.0} | values
    derivative = learned(robot).next[column].diff(symbol(by))
    return float(derivative.subs({symbol(name): value for name, value in rest.items()}))


@pytest.mark.slow
def test_velocities_by_differences_do_not_make_a_car_slower() -> None:
    """Half a row late they are; an equation that takes them for the present has a time constant of 140 ms for 117."""
    assert any("vx of the logs is 25 ms late" in note for note in learned("mushr").notes)
    kept = slope("mushr", "vx", "vx", vx=1.0, speed=1.0)
    assert kept == pytest.approx(np.exp(-ROBOTS["mushr"].dt / SPEED_TIME_CONSTANT), abs=0.015)


@pytest.mark.slow
@pytest.mark.parametrize(("arm", "about"), [("rx", "offset:wy_cmd"), ("ry", "offset:wx_cmd")])
def test_of_offsets_that_compete_as_one_only_those_that_are_there_are_named(arm: str, about: str) -> None:
    """A centre of mass that is off along one axis, and a base without inertia: it is an offset about the other axis."""
    moved = ("com_offset", {"rx": 0.0, "ry": 0.0} | {arm: 0.002})
    logs = simulate_case(Case("crazyflie", (moved,), seed=12), trajectories=6, rows=220)
    found = diagnose(replace(learned("crazyflie"), numbers={}), logs)
    assert [finding.effect for finding in found.findings] == [about]
    assert found.findings[0].share > 0.9


@pytest.mark.slow
def test_velocities_that_a_filter_made_late_are_moved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two rows; nothing in the file says so but the positions. What is learned from is what was true."""
    seen: list[Array] = []

    class Seeing(Linear):
        def fit(self, transitions: Transitions, start: Equations | None = None) -> Equations:
            velocity = transitions.layouts.state.indices(["vx", "vy"])
            seen.append(np.linalg.norm(transitions.state[:, velocity], axis=1))
            return super().fit(transitions, start)

    monkeypatch.setitem(ENGINES._entries, "beam", Seeing)
    paths = [tmp_path / f"{number}.csv" for number in range(4)]
    drives = [*simulate_case(Case("mushr", seed=6_900_100), trajectories=4)]
    for late in (0, 1, 2):
        for log, path in zip(drives, paths, strict=True):
            state, places = log.state.copy(), log.layouts.state.indices(["vx", "vy"])
            state[late:, places] = state[: len(state) - late, places]
            write_log(replace(log, state=state), path)
        notes = learn_from_logs(measured("mushr"), paths, None, "beam").equations.notes
        moved = f"vx of the logs is {25 + 50 * late} ms late, and was moved"
        assert any(moved in note for note in notes), notes
    apart = np.abs(np.diff(seen[0])).mean()
    assert max(np.abs(seen[late] - seen[0]).mean() for late in (1, 2)) < 0.2 * apart


@pytest.mark.slow
def test_the_thrust_of_a_hover_is_found() -> None:
    """A height that is kept hardly shows it: what noise leaves of a velocity is as large as what thrust does to it."""
    robot = ROBOTS["crazyflie"]
    assert slope("crazyflie", "vz", "thrust", thrust=GRAVITY * robot.mass) == pytest.approx(
        robot.dt / robot.mass, rel=0.1
    )
