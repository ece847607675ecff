"""What benches do to logs: changes that a diagnosis must not notice, and mistakes that it must."""

import log_changes
import mistakes
import numpy as np
import pytest
from mistakes_list import JOINTS, MISTAKES

from sym2real.dataset import Dataset
from sym2real.experiments.flights import car_drives, quadrotor_flights
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS as OTHERS
from sym2real.tasks import make_task

ROBOTS = {"crazyflie": CRAZYFLIE, "mushr": MUSHR}


@pytest.fixture(scope="module")
def logs() -> dict[str, Dataset]:
    joints = {name: OTHERS[name] for name in JOINTS}
    still = {name: [make_task("regulate", robot)] for name, robot in joints.items()}
    moving = {name: noisy_runs(robot, still[name], count=1, rows=120) for name, robot in joints.items()}
    return {"crazyflie": quadrotor_flights(2, 3, steps=120), "mushr": car_drives(3, 3, steps=120), **moving}


def test_cut_and_shuffled_logs_hold_every_row(logs: dict[str, Dataset]) -> None:
    data = logs["mushr"]
    for change in (log_changes.split, log_changes.shuffled):
        changed = change(data, np.random.default_rng(0))
        rows = np.concatenate([log.state for log in changed])
        assert np.array_equal(np.unique(rows, axis=0), np.unique(np.concatenate([log.state for log in data]), axis=0))
    assert len(log_changes.split(data, np.random.default_rng(0))) == 2 * len(data)


def test_half_the_rate_has_twice_the_step(logs: dict[str, Dataset]) -> None:
    halved = log_changes.half_rate(logs["crazyflie"], np.random.default_rng(0))
    assert halved.dt == pytest.approx(2 * CRAZYFLIE.dt)
    assert halved[0].action[1] == pytest.approx(logs["crazyflie"][0].action[2])


def test_there_are_forty_mistakes_or_more_of_the_papers_robots_and_none_stands_twice() -> None:
    for robot, listed in MISTAKES.items():
        assert len({one.name for one in listed}) == len(listed)
        assert len(listed) >= 40 or robot in JOINTS


@pytest.mark.parametrize(("robot", "name"), [(robot, one.name) for robot, listed in MISTAKES.items() for one in listed])
def test_a_mistake_changes_the_log_by_a_size_that_the_seed_draws(
    robot: str, name: str, logs: dict[str, Dataset]
) -> None:
    mistake = next(one for one in MISTAKES[robot] if one.name == name)
    data = logs[robot]
    made, again = mistake.made(data, 7), mistake.made(data, 7)
    differences = []
    for log, changed, same in zip(data, made, again, strict=True):
        np.testing.assert_array_equal(changed.state, same.state)
        np.testing.assert_array_equal(changed.action, same.action)
        np.testing.assert_array_equal(changed.time, log.time)
        differences.append(np.abs(changed.state - log.state).max() + np.abs(changed.action - log.action).max())
    assert max(differences) > 1e-3


def test_mistakes_that_are_their_own_inverse_undo_themselves(logs: dict[str, Dataset]) -> None:
    data = logs["crazyflie"]
    for name in ("wx reversed", "wx and wy swapped", "z down", "quaternion from world to body"):
        mistake = next(one for one in MISTAKES["crazyflie"] if one.name == name)
        np.testing.assert_allclose(mistake.made(mistake.made(data, 1), 1)[0].state, data[0].state, atol=1e-12)
    there, back = mistakes.to_body(("vx", "vy", "vz")), mistakes.to_world(("vx", "vy", "vz"))
    log, rng = data[0], np.random.default_rng(0)
    columns = {column: log.column(column) for column in log.layouts.state}
    along_body = {**columns, **there(columns, rng)}
    for column, values in back(along_body, rng).items():
        np.testing.assert_allclose(values, columns[column], atol=1e-12)


def test_a_late_column_is_behind_the_others(logs: dict[str, Dataset]) -> None:
    log = logs["mushr"][0]
    shifted = mistakes.late(["wz"], 3, 3)({"x": log.column("x"), "wz": log.column("wz")}, np.random.default_rng(0))
    np.testing.assert_array_equal(shifted["wz"][3:], log.column("wz")[:-3])


def test_a_mistake_is_named_by_its_effect_or_its_words_and_by_no_other() -> None:
    mistake = next(one for one in MISTAKES["mushr"] if one.name == "wz late")
    assert mistake.named_in(["time_shift:wz"], [])
    assert mistake.named_in([], ["the logged wz is 120 ms behind the attitude"])
    assert not mistake.named_in(["time_shift:vx", "lag:steer"], ["the logged vx is 120 ms behind the position"])
