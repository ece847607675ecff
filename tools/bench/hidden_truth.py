"""The best that anybody could predict: the simulator with the true effect, from the starts that the logs allow."""

import mujoco
import numpy as np
from standard_set import Case

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.windows import HORIZONS
from sym2real.diagnosis.errors.rungs import windows_of
from sym2real.effects import effect
from sym2real.effects.composing import compose
from sym2real.effects.sensors import Sensors
from sym2real.plants import MujocoPlant
from sym2real.robots import ROBOTS
from sym2real.trajectory import Array

MOST_WINDOWS = 60


def error_of_the_truth(case: Case, data: Dataset, horizon: float) -> float:
    """Root mean square position error in m after ``horizon`` s, over windows spread evenly over the logs.

    The simulator has the case's effects, but none of what differs from run to run; commands before a window fill its
    delays and lags, then it is put at the window's start.

    Args:
        case: gives the effects.
        data: measured logs.
        horizon: in s.
    """
    robot = ROBOTS[case.robot]
    found = [(effect(key, robot), values) for key, values in case.effects]
    sensors = Sensors(compose(robot.nominal(), [one for one in found if one[0].stage == "measurement"]))
    windows = windows_of(data, round(max(HORIZONS) / robot.dt))
    assert windows is not None
    windows = windows.some(MOST_WINDOWS)
    plant = MujocoPlant(robot, tuple(one.inject(**values) for one, values in found))
    steps, place = round(horizon / robot.dt), robot.layouts.state.slice("position")
    errors = []
    for number in range(len(windows)):
        starts = [sensors.state(states[number]).numpy() for states in (windows.before, windows.start)]
        log, row, warm_up = (int(values[number]) for values in (windows.log, windows.row, windows.warm_up))
        predicted = _predicted(plant, starts, data[log].action[row - warm_up : row + steps], row, warm_up)
        errors.append(predicted[place] - windows.measured[number, steps, place].numpy())
    return float(np.sqrt(np.mean(np.sum(np.square(errors), axis=1))))


def _predicted(plant: MujocoPlant, starts: list[Array], actions: Array, row: int, warm_up: int) -> Array:
    """State measured after the last action, from a start at ``row`` and one so many rows before it."""
    plant.reset(starts[0])
    plant.mj_data.time = (row - warm_up) * plant.dt
    for action in actions[:warm_up]:
        plant.step(action)
    coordinates, velocities = plant.robot.description.to_coordinates(starts[1])
    plant.mj_data.qpos[:7], plant.mj_data.qvel[:6] = coordinates[:7], velocities[:6]
    mujoco.mj_forward(plant.mj_model, plant.mj_data)
    for action in actions[warm_up:]:
        state = plant.step(action)
    return state
