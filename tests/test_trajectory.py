"""Trajectories hold together: shapes, rows that belong to each other, transitions within one trajectory."""

import numpy as np
import pytest

from sym2real.dataset import Dataset
from sym2real.errors import ShapeError, UnknownNameError
from sym2real.layout import Layout, Layouts
from sym2real.trajectory import Trajectory

LAYOUTS = Layouts(Layout.of(["x", "vx"]), Layout.of(["speed"]), Layout.of(["fx"]))


def counting(rows: int, offset: float, name: str = "", dt: float = 0.1) -> Trajectory:
    steps = np.arange(rows, dtype=float)
    return Trajectory(
        time=dt * steps,
        state=np.stack([offset + steps, np.ones(rows)], axis=1),
        action=steps[:, None],
        inputs=np.zeros((rows, 1)),
        layouts=LAYOUTS,
        extra={"ref_x": steps},
        name=name,
    )


def test_transitions_never_cross_trajectories() -> None:
    transitions = Dataset([counting(5, 0.0), counting(4, 100.0)]).transitions()
    assert len(transitions) == 4 + 3
    np.testing.assert_array_equal(transitions.next_state[:, 0] - transitions.state[:, 0], 1.0)
    np.testing.assert_array_equal(transitions.trajectory, [0, 0, 0, 0, 1, 1, 1])
    np.testing.assert_array_equal(transitions.action[:, 0], transitions.step)
    second = transitions.where(transitions.trajectory == 1)
    assert second.state[0, 0] == 100.0


def test_the_past_repeats_the_first_row_of_a_trajectory() -> None:
    transitions = Dataset([counting(5, 0.0), counting(4, 100.0)]).transitions()
    past = transitions.past(commands=2, states=1)
    np.testing.assert_array_equal(past[:, :2], [[0, 0], [0, 0], [1, 0], [2, 1], [0, 0], [0, 0], [1, 0]])
    size = LAYOUTS.state.size
    np.testing.assert_array_equal(past[:, 2:], transitions.state[[0, 0, 1, 2, 4, 4, 5]].reshape(7, size))
    assert transitions.past(0, 0).shape == (7, 0)
    without = transitions.where(transitions.step != 1)  # what was left out is not invented
    np.testing.assert_array_equal(without.past(1, 0)[:, 0], [0, 2, 2, 0, 2])


def test_rows_and_columns() -> None:
    part = counting(6, 0.0).rows(2, 5)
    np.testing.assert_array_equal(part.column("x"), [2, 3, 4])
    np.testing.assert_array_equal(part.column("ref_x"), [2, 3, 4])
    assert part.dt == pytest.approx(0.1)
    with pytest.raises(UnknownNameError, match="vx"):
        part.column("v")


def test_misfits_are_refused() -> None:
    good = counting(5, 0.0)
    with pytest.raises(ShapeError, match=r"action must have shape \(5, 1\)"):
        Trajectory(good.time, good.state, good.state, good.inputs, LAYOUTS)
    with pytest.raises(ShapeError, match="increase strictly"):
        Trajectory(good.time * 0, good.state, good.action, good.inputs, LAYOUTS)
    other = Trajectory(good.time, good.state, good.action, good.inputs[:, :0], Layouts(LAYOUTS.state, LAYOUTS.action))
    with pytest.raises(ShapeError, match="different columns"):
        Dataset([good, other])


def test_logs_of_different_rates_are_refused_by_name() -> None:
    """The fast rows would be taken for steps of the slow ones."""
    slow, fast = counting(20, 0.0, "slow"), counting(20, 0.0, "fast", dt=0.05)
    with pytest.raises(ShapeError, match=r"'slow' has a time step of 0\.1 s, trajectory 'fast' one of 0\.05 s"):
        Dataset([slow, fast])
    with pytest.raises(ShapeError, match=r"number 1 .* number 3"):
        Dataset([counting(20, 0.0), counting(20, 0.0), counting(20, 0.0, dt=0.05)])
    assert len(Dataset([slow, counting(20, 0.0, dt=0.101)])) == 2  # clocks differ
    assert len(Dataset([slow, fast.rows(0, 3)])) == 2  # of three rows nobody knows
