"""Attitudes and headings that are meant otherwise than they were read: in degrees, scalar last, exchanged, mirrored.

Of angles that are 57 times too large whole turns are lost, which rates count (``derive.counted_angles``). Where the
heading then starts follows from where the robot accelerates, or goes.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import torch

from sym2real import rotation
from sym2real.dataset import Dataset
from sym2real.diagnosis.data.preparation import present
from sym2real.diagnosis.faults.fault import Breach
from sym2real.diagnosis.faults.mistakes.transformation import Exchanged, Misread, counted_otherwise, of_all
from sym2real.diagnosis.faults.units import Scaled, factors
from sym2real.diagnosis.settings import SETTINGS
from sym2real.logs.agreement import RATES, least_agreement, off_the_way, points_along, rate_agreement, thrust_agreement
from sym2real.logs.course import between, courses, decides, headings, together
from sym2real.logs.derive import counted_angles
from sym2real.logs.pose import attitude, with_all_measured, with_angles
from sym2real.logs.sources import AsRead
from sym2real.logs.units import UNITS
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import ATTITUDE, EULER_ANGLES, HEADING, POSITION

COMMANDED = "_cmd"
QUATERNION, SINE_COSINE = ATTITUDE.columns, HEADING.columns
LEVEL = POSITION.columns[:2]


@dataclass(frozen=True)
class OfAttitude(Exchanged):
    """Roll and pitch of an attitude in each other's place, or with the other sign.

    Args:
        quaternion: the attitude's columns; those that are exchanged are angles.
    """

    quaternion: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Which angles, of what was measured or of what was commanded."""
        of = "attitude" if self.quaternion == QUATERNION else "commanded attitude"
        return f"{super().name} in the {of}"

    def fix(self, read: AsRead) -> str:
        """What to change, in the angles that the log has, or in those that its quaternion is made of."""
        if all(own in read.sources for own in self.columns):
            return super().fix(read)
        return f"put them right where {' '.join(read.columns(self.quaternion))} are made of angles{AsRead().frame}"

    def undone(self, log: Trajectory) -> Trajectory:
        """With every angle in its own place."""
        attitude = np.stack([log.column(name) for name in self.quaternion], axis=1)
        angles = rotation.to_euler(torch.as_tensor(attitude)).clone()
        first, places = angles.clone(), [EULER_ANGLES.index(own.removesuffix(COMMANDED)) for own in self.columns]
        for place, source, sign in zip(places, self.sources, self.signs, strict=True):
            angles[:, EULER_ANGLES.index(source.removesuffix(COMMANDED))] = sign * first[:, place]
        return with_angles(log, angles.numpy(), self.quaternion)


TURN_BACK = 'log quaternions from body to world, or say direction = "world_to_body" under [attitude] (or leave it out)'
FROM_WORLD = Misread(
    "the attitude turned the other way (quaternions from world to body)",
    lambda _: TURN_BACK,
    lambda log: log.with_columns(dict(zip(QUATERNION, rotation.conjugate(attitude(log)).numpy().T, strict=True))),
)
# Order of components in a specification → the mistake, and what the columns of w, x, y and z hold.
ORDERS = {
    "xyzw": ("quaternions with the scalar last (x y z w)", (*QUATERNION[1:], QUATERNION[0])),
    "wxyz": ("quaternions with the scalar first (w x y z) in columns of x y z w", (QUATERNION[-1], *QUATERNION[:-1])),
}
DEGREES, READ = 1.0 / UNITS["deg"][1], ("degrees", "radians")


def other_order(data: Dataset) -> list[Breach]:
    """Quaternions whose scalar is last, or first where it should be last, beyond doubt; none without motion."""
    measured = Dataset(map(with_all_measured, data))
    if present(measured, QUATERNION) != QUATERNION or not (now := least_agreement([*measured])) <= SETTINGS.mostly:
        return []
    for misread in orders_of():
        if (then := least_agreement([*of_all(misread, measured)])) >= SETTINGS.scalar_last:
            told = f"rates and accelerations correlate with the attitude by {then:.2f} then, by {now:.2f} as it stands"
            return [Breach(misread, told)]
    return []


def orders_of(ending: str = "") -> Iterator[Misread]:
    """The other orders of a quaternion whose columns have this ending."""
    own = tuple(f"{name}{ending}" for name in QUATERNION)
    for order, (name, held) in ORDERS.items():
        exchanged = Exchanged(own, tuple(f"{column}{ending}" for column in held), (1, 1, 1, 1))
        yield Misread(f"{'commanded ' * bool(ending)}{name}", partial(_in_order, order, own), exchanged.undone)


def _in_order(order: str, quaternion: Sequence[str], read: AsRead) -> str:
    names, table = read.columns(quaternion), "attitude" if (*quaternion,) == QUATERNION else "attitude_command"
    columns = ", ".join(f'"{name}"' for name in (names if order == "xyzw" else (*names[1:], names[0])))
    entry = f'quaternion = [{columns}] and order = "{order}"'
    return f"rename the columns, or say {entry} under [{table}] in a specification of the log"


def other_angles(data: Dataset) -> list[Breach]:
    """Angles in degrees taken for radians, or the other way, where rates and a car's way agree with such alone.

    In all logs, or in some of them. Rates may be in degrees as well, and then agree with the angles as they stand: the
    way alone does not.
    """
    breaches = _of_all(data)
    if breaches or len(data) == 1:
        return breaches
    return [breach.in_log(data, place) for place, log in enumerate(data) for breach in _of_all(Dataset([log]))]


def _of_all(data: Dataset) -> list[Breach]:
    columns = present(data, RATES), present(data, (*QUATERNION, *SINE_COSINE))
    if present(data, LEVEL) != LEVEL or columns not in ((RATES, QUATERNION), (RATES[-1:], SINE_COSINE)):
        return []
    breaches, now = _misread(data, columns[1]), points_along([*data])
    if breaches or now > SETTINGS.mostly:
        return breaches
    rates = Breach(Scaled(columns[0], DEGREES, "deg/s"), "they turn the attitude as it is meant")
    in_radians = rates.undone(data)
    breaches = _misread(in_radians, columns[1])
    sure = breaches and decides(points_along([*breaches[0].undone(in_radians)]), now)  # a ship may go sideways
    return [rates, *breaches] if sure else []


def _misread(data: Dataset, columns: tuple[str, ...]) -> list[Breach]:
    now = _concordance(data)
    if not now or max(now) > SETTINGS.mostly:
        return []
    for times, unit, what in ((DEGREES, "deg", READ), (1.0 / DEGREES, "rad", READ[::-1])):
        words = f"an attitude in {' that is read as '.join(what)}"
        meant = Misread(words, partial(_unit, unit), partial(_divided, times))
        then = min(_concordance(of_all(meant, data)), default=0.0)
        if then >= SETTINGS.mostly and (times > 1.0 or columns == SINE_COSINE or _moved_in_degrees(data)):
            shown = f"what moves the robot agrees with it by {then:.2f} of 1 then, by {max(now):.2f} as it stands"
            return [Breach(meant, shown)]
    return []


def _moved_in_degrees(data: Dataset) -> bool:
    """Whether thrust moves a robot 57 times too far as well, and no unit of its position says so better."""
    ratio = thrust_agreement(list(data)).ratio
    off = {unit: abs(np.log(ratio / factor)) for unit, factor in (factors("m") | factors("rad")).items()}
    return ratio > 0.0 and min(off, key=off.__getitem__) == "deg"


def _unit(unit: str, read: AsRead) -> str:
    if own := read.logged(EULER_ANGLES) if read.sources else ():
        return f'say unit = "{unit}" of {" ".join(read.columns(own))} in a specification of the log'
    return f"make {' '.join(read.columns((*QUATERNION, *SINE_COSINE)))} of angles in rad"


def _concordance(data: Dataset) -> tuple[float, ...]:
    """Of every rate that moves with the attitude, and of a car's way with its heading; nothing where that rests."""
    rates = [rate.concordance for rate in rate_agreement(list(data)).values() if rate.correlation is not None]
    concordances = (*rates, together(courses(data), headings(data))) if present(data, SINE_COSINE) else (*rates,)
    return concordances if np.isfinite(concordances).all() else ()


def _divided(times: float, log: Trajectory) -> Trajectory:
    """A log whose angles are so many times too large, as they are meant."""
    rates, logged = np.stack([log.column(name) for name in present(Dataset([log]), RATES)], axis=1), attitude(log)
    if times < 1.0:  # no turn is lost
        return with_angles(log, rotation.to_euler(logged).numpy()[:, -rates.shape[1] :] / times)
    angles, lost = counted_angles(log.time, logged.numpy(), times * rates) / times, 2.0 * np.pi / times
    angles[:, -1] += lost * np.round(off_the_way(with_angles(log, angles)) / lost)
    return with_angles(log, angles)


def against_the_path(data: Dataset) -> list[Breach]:
    """A heading that turns against the path, beyond doubt; none of straight drives."""
    if present(data, (*SINE_COSINE, *LEVEL)) != (*SINE_COSINE, *LEVEL):
        return []
    ways, logged = courses(data), headings(data)
    turned = [-heading for heading in logged]
    now, then = together(ways, logged), together(ways, turned)
    if not decides(then, now):
        return []
    apart = between(ways, turned)  # 0 where slip may be all of it
    mirrored = Misread(
        "a heading that turns against the path",
        lambda read: counted_otherwise(read, -1.0, apart),
        lambda log: with_angles(log, apart - headings([log])[0][:, None]),
    )
    return [Breach(mirrored, f"with its sign reversed it turns with it ({then:.2f} of 1, as it stands {now:.2f})")]
