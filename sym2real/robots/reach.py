"""Whether logs lie where a robot's joints can be, and its commands where its actuators go."""

import numpy as np

from sym2real.dataset import Dataset
from sym2real.errors import DataError
from sym2real.robots.robot import Robot
from sym2real.vocabulary import LARGEST_PLACE, roughly

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


def require_reach(robot: Robot | None, logs: Dataset) -> None:
    """Refuse logs in which a joint with stops lies far beyond them, and beyond a turn or some metres.

    The stops of many files are rough, so their range counts three times as wide.

    Args:
        robot: of the logs; None where nobody knows.
        logs: in SI units.

    Raises:
        DataError: naming the log and the joint.
    """
    ranges = robot.ranges if robot is not None and logs.layouts.state.joints else {}
    for log in logs:
        for column in (name for name in log.layouts.state.joints if name in ranges):
            (low, high), unit = ranges[column], log.layouts.state.units[column]
            least, most = np.quantile(log.column(column), ENDS).tolist()
            lowest, highest = roughly((low, high))
            if max(-least, most) > LARGEST_PLACE[unit] and (least < lowest or most > highest):
                actual = (
                    f"{least:.3g} to {most:.3g} (`sym2real inspect` with --model says which unit or counts would fit)"
                )
                raise DataError(
                    log.name, f"a joint in its range of {low:.3g} to {high:.3g} {unit}", actual, column=column
                )
