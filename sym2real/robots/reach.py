"""Whether logs lie where a robot's joints can be, and its commands where its actuators go."""

from dataclasses import replace

import numpy as np

from sym2real.dataset import Dataset
from sym2real.errors import DataError
from sym2real.robots.robot import Robot
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import LARGEST_PLACE, WHOLE_TURNS, roughly

ENDS = (0.05, 0.95)  # quantiles of a log: single rows may be wrong
BEYOND = 0.02  # of a range, by which a command may be rounded beyond its end


def notes_on_commands(robot: Robot | None, logs: Dataset) -> list[str]:
    """Commands that go beyond the ranges that a robot's description gives its actuators, where it has them."""
    if robot is None or robot.layouts.action != logs.layouts.action:
        return []
    names, sent = logs.layouts.action.columns, np.concatenate([log.action for log in logs])
    off = BEYOND * (robot.high - robot.low)
    shares = ((sent < robot.low - off) | (sent > robot.high + off)).mean(0)
    return [
        f"{name} goes beyond its range by the description, {low:g} to {high:g}, in {100 * share:.2g} % of the rows: it "
        f"was logged before it is cut off, and limit:{name} is that range"
        for name, low, high, share in zip(names, robot.low, robot.high, shares, strict=True)
        if share > 0.0
    ]


def in_reach(robot: Robot | None, logs: Dataset) -> Dataset:
    """Logs whose joints lie where they can be: those that lie whole turns beside their stops are put back.

    An encoder that begins anew after a turn does not say which turn it is in. The stops of many files are rough, so
    their range counts three times as wide for what is refused.

    Args:
        robot: of the logs; None where nobody knows.
        logs: in SI units.

    Raises:
        DataError: for a joint with stops far beyond them, and beyond a turn or some metres; naming log and joint.
    """
    ranges = robot.ranges if robot is not None and logs.layouts.state.joints else {}
    for column in (name for name in logs.layouts.state.joints if name in ranges):
        logs = Dataset(_with_joint_in_reach(log, column, ranges[column]) for log in logs)
    return logs


def _with_joint_in_reach(log: Trajectory, column: str, ends: tuple[float, float]) -> Trajectory:
    (low, high), unit = ends, log.layouts.state.units[column]
    least, most = np.quantile(log.column(column), ENDS).tolist()
    turns = 2.0 * np.pi * round(((least + most) - (low + high)) / (4.0 * np.pi)) if unit == "rad" else 0.0
    if turns and low <= least - turns and most - turns <= high:
        state = log.state - turns * (np.array(log.layouts.state.columns) == column)
        return replace(log, state=state, notes=(*log.notes, f"{column} is put into its range {WHOLE_TURNS}"))
    lowest, highest = roughly((low, high))
    if max(-least, most) > LARGEST_PLACE[unit] and (least < lowest or most > highest):
        actual = f"{least:.3g} to {most:.3g} (`sym2real inspect` with --model says which unit or counts would fit)"
        raise DataError(log.name, f"a joint in its range of {low:.3g} to {high:.3g} {unit}", actual, column=column)
    return log
