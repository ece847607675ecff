"""Attitudes and headings that are meant otherwise than they were read: scalar last, in degrees, against the path.

Of angles that are 57 times too large whole turns are lost, which rates count (``derive.counted_angles``). Where the
heading then starts follows from where the robot is pushed, or goes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from sym2real import rotation
from sym2real.dataset import Dataset
from sym2real.diagnosis.data.agreement import RATES, level_push, rate_agreement, thrust_agreement
from sym2real.diagnosis.faults.foreign_units import factors
from sym2real.diagnosis.faults.mistakes.of_attitude import with_angles
from sym2real.diagnosis.faults.mistakes.transformation import HEADING, POSITIONS, QUATERNION, Exchanged, of_all, present
from sym2real.diagnosis.settings import SETTINGS
from sym2real.logs.course import between, courses, decides, headings, together
from sym2real.logs.derive import counted_angles
from sym2real.logs.pose import attitude
from sym2real.logs.sources import ANGLES, AsRead
from sym2real.logs.units import UNITS
from sym2real.trajectory import Trajectory

SHIFTED = Exchanged(QUATERNION, (*QUATERNION[1:], QUATERNION[0]), (1, 1, 1, 1))
DEGREES, READ = 1.0 / UNITS["deg"][1], ("degrees", "radians")
LEVEL = POSITIONS[:2]


@dataclass(frozen=True)
class Misread:
    """An attitude or a heading that is meant otherwise.

    Args:
        evidence: what it is and what shows it, one clause.
        fix: what to change, in the columns of the log.
        undone: the logs as they are meant.
    """

    evidence: str
    fix: Callable[[AsRead], str]
    undone: Callable[[Dataset], Dataset]


def scalar_last(data: Dataset) -> list[Misread]:
    """Quaternions x, y, z, w in columns w, x, y, z, where that fits beyond doubt; none without motion."""
    if present(data, QUATERNION) != QUATERNION:
        return []
    now, then = _correlation(data), _correlation(of_all(SHIFTED, data))
    if not (now <= SETTINGS.mostly and then >= SETTINGS.scalar_last):
        return []
    evidence = (
        "quaternions with the scalar last (x y z w): rates and accelerations correlate with the attitude by "
        f"{then:.2f} then, by {now:.2f} as the columns stand"
    )

    def fix(read: AsRead) -> str:
        columns = ", ".join(f'"{column}"' for column in read.columns(QUATERNION))
        entry = f'quaternion = [{columns}] and order = "xyzw"'
        return f"rename the columns, or say {entry} under [attitude] in a specification of the log"

    return [Misread(evidence, fix, partial(of_all, SHIFTED))]


def _correlation(data: Dataset) -> float:
    """The least of rates with the attitude's derivative and of the push with the thrust's axis; NaN where all rests."""
    agreements = (*rate_agreement(list(data)).values(), thrust_agreement(list(data)))
    found = [abs(agreement.correlation) for agreement in agreements if agreement.correlation is not None]
    return min(found, default=float("nan"))


def other_angles(data: Dataset) -> list[Misread]:
    """Angles in degrees taken for radians, or the other way, where rates and a car's way agree with such alone."""
    columns = present(data, RATES), present(data, (*QUATERNION, *HEADING))
    placed = present(data, LEVEL) == LEVEL and columns in ((RATES, QUATERNION), (RATES[-1:], HEADING))
    now = _concordance(data) if placed else ()
    if not now or max(now) > SETTINGS.mostly:
        return []
    for times, unit, what in ((DEGREES, "deg", READ), (1.0 / DEGREES, "rad", READ[::-1])):
        undone = partial(_divided, times)
        then = min(_concordance(undone(data)), default=0.0)
        if then >= SETTINGS.mostly and (times > 1.0 or columns[1] == HEADING or _pushed_as_turned(data)):
            shown = f"what moves the robot agrees with it by {then:.2f} of 1 then, by {max(now):.2f} as it stands"
            return [Misread(f"an attitude in {' that is read as '.join(what)}: {shown}", partial(_unit, unit), undone)]
    return []


def _pushed_as_turned(data: Dataset) -> bool:
    """Whether thrust moves a robot 57 times too far as well, and no unit of its position says so better."""
    ratio = thrust_agreement(list(data)).ratio
    off = {unit: abs(np.log(ratio / factor)) for unit, factor in (factors("m") | factors("rad")).items()}
    return ratio > 0.0 and min(off, key=off.__getitem__) == "deg"


def _unit(unit: str, read: AsRead) -> str:
    if own := read.logged(ANGLES) if read.sources else ():
        return f'say unit = "{unit}" of {" ".join(read.columns(own))} in a specification of the log'
    return f"make {' '.join(read.columns((*QUATERNION, *HEADING)))} of angles in rad"


def _concordance(data: Dataset) -> tuple[float, ...]:
    """Of every rate that moves with the attitude, and of a car's way with its heading; nothing where that rests."""
    rates = [found.concordance for found in rate_agreement(list(data)).values() if found.correlation is not None]
    found = (*rates, together(courses(data), headings(data))) if present(data, HEADING) else (*rates,)
    return found if np.isfinite(found).all() else ()


def _divided(times: float, data: Dataset) -> Dataset:
    """Logs whose angles are so many times too large, as they are meant."""
    logs, lost = [], 2.0 * np.pi / times
    for log in data:
        rates, logged = np.stack([log.column(name) for name in present(data, RATES)], axis=1), attitude(log)
        if times > 1.0:
            angles = counted_angles(log.time, logged.numpy(), times * rates) / times
            angles[:, -1] += lost * np.round(_off(with_angles(log, angles)) / lost)
        else:  # no turn is lost
            angles = rotation.to_euler(logged).numpy()[:, -rates.shape[1] :] / times
        logs.append(with_angles(log, angles))
    return Dataset(logs)


def _off(log: Trajectory) -> float:
    """Angle in rad from where a car heads to where it goes, or from where thrust points to where it pushes."""
    if log.layouts.state.has_field("heading"):
        return float(np.angle(np.nansum(np.exp(1j * (courses([log])[0] - headings([log])[0])))))
    pushed, axis = (level @ np.array([1.0, 1.0j]) for level in level_push(log))
    return float(np.angle(np.vdot(axis, pushed)))


def against_the_path(data: Dataset) -> list[Misread]:
    """A heading that turns against the path, beyond doubt; none of straight drives."""
    if present(data, (*HEADING, *LEVEL)) != (*HEADING, *LEVEL):
        return []
    ways, logged = courses(data), headings(data)
    turned = [-heading for heading in logged]
    now, then = together(ways, logged), together(ways, turned)
    if not decides(then, now):
        return []
    apart = between(ways, turned)  # 0 where slip may be all of it

    def fix(read: AsRead) -> str:
        zero = f" and give it a zero of {read.sign(HEADING[0]) * apart:.2f} rad (in its unit)" if apart else ""
        own = read.column(HEADING[0]) if read.sources else "its column"
        return f"change the sign of yaw: flip {own} in the log's specification{zero}"

    def undone(logs: Dataset) -> Dataset:
        pairs = zip(logs, headings(logs), strict=True)
        return Dataset(with_angles(log, apart - heading[:, None]) for log, heading in pairs)

    shown = f"with its sign reversed it turns with it ({then:.2f} of 1, as it stands {now:.2f})"
    return [Misread(f"a heading that turns against the path: {shown}", fix, undone)]
