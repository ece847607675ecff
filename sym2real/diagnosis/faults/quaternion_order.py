"""Whether a log has its quaternions with the scalar last, by what turns and pushes the robot then."""

from __future__ import annotations

from dataclasses import dataclass

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.agreement import rate_agreement, thrust_agreement
from sym2real.diagnosis.faults.mistakes.transformation import QUATERNION, Exchanged, of_all
from sym2real.diagnosis.settings import SETTINGS
from sym2real.logs.sources import AsRead

SHIFTED = Exchanged(QUATERNION, (*QUATERNION[1:], QUATERNION[0]), (1, 1, 1, 1))


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

    def fix(self, read: AsRead) -> str:
        """What to change, in the columns of the log."""
        columns = ", ".join(f'"{column}"' for column in read.columns(QUATERNION))
        entry = f'quaternion = [{columns}] and order = "xyzw"'
        return f"rename the columns, or say {entry} under [attitude] in a specification of the log"

    def undone(self, data: Dataset) -> Dataset:
        """The logs with the scalar first."""
        return of_all(SHIFTED, data)


def scalar_last(data: Dataset) -> list[ScalarLast]:
    """One entry where another order fits beyond doubt; none without a quaternion or motion."""
    if not data.layouts.state.has_field("attitude"):
        return []
    as_it_stands, reordered = _agreement(data), _agreement(of_all(SHIFTED, data))
    if as_it_stands is None or reordered is None:
        return []
    sure = as_it_stands <= SETTINGS.agreeing and reordered >= SETTINGS.scalar_last
    return [ScalarLast(as_it_stands, reordered)] if sure else []


def _agreement(data: Dataset) -> float | None:
    agreements = (*rate_agreement(list(data)).values(), thrust_agreement(list(data)))
    found = [agreement.correlation for agreement in agreements]
    return min((abs(correlation) for correlation in found if correlation is not None), default=None)
