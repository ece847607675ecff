"""Whether a log has its quaternions with the scalar last, by what turns and pushes the robot then."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sym2real.diagnosis.data.agreement import AGREES, rate_agreement, thrust_agreement
from sym2real.trajectory import Dataset

SURE = 0.8  # correlation of everything that can be judged


@dataclass(frozen=True)
class ScalarLast:
    """Quaternions x, y, z, w in columns w, x, y, z.

    Args:
        as_it_stands, reordered: the least correlation of body rates with the attitude's derivative, and of the push
            aside with where thrust points, without regard to signs.
    """

    as_it_stands: float
    reordered: float

    @property
    def evidence(self) -> str:
        """What shows it, one clause."""
        return (
            "quaternions with the scalar last (x y z w): rates and accelerations correlate with the attitude by "
            f"{self.reordered:.2f} then, by {self.as_it_stands:.2f} as the columns stand"
        )

    @property
    def fix(self) -> str:
        """What to change."""
        told = 'quaternion = ["qw", "qx", "qy", "qz"] and order = "xyzw"'
        return f"rename the columns, or say {told} under [attitude] in a specification of the log"

    def undone(self, data: Dataset) -> Dataset:
        """The logs with the scalar first."""
        return _reordered(data)


def scalar_last(data: Dataset) -> list[ScalarLast]:
    """One entry where another order fits beyond doubt; none without a quaternion or motion."""
    if not data.layouts.state.has_field("attitude"):
        return []
    as_it_stands, reordered = _agreement(data), _agreement(_reordered(data))
    if as_it_stands is None or reordered is None or as_it_stands > AGREES or reordered < SURE:
        return []
    return [ScalarLast(as_it_stands, reordered)]


def _agreement(data: Dataset) -> float | None:
    found = [one.correlation for one in (*rate_agreement(list(data)).values(), thrust_agreement(list(data)))]
    return min((abs(one) for one in found if one is not None), default=None)


def _reordered(data: Dataset) -> Dataset:
    place, logs = data.layouts.state.slice("attitude"), []
    for log in data:
        state = log.state.copy()
        state[:, place] = np.roll(state[:, place], 1, axis=-1)
        logs.append(replace(log, state=state))
    return Dataset(logs)
