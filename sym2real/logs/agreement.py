"""Whether measured rates and velocities are the derivatives of measured attitudes and positions.

Both are averaged over a few rows before they are compared, so that noise does not decide.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from sym2real import rotation
from sym2real.logs import derive
from sym2real.logs.course import courses, headings, together
from sym2real.logs.pose import attitude, turned
from sym2real.logs.reading import CLEAR
from sym2real.logs.units import GRAVITY
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import HEADING, POSITION, RATE, VELOCITY

RATES, VELOCITIES = RATE.columns, VELOCITY.columns
SMOOTHING = 5  # rows
LEAST_MOTION = {"rad/s": 0.05, "m/s": 0.02}  # standard deviation below which a sign is not judged
ALOFT = 0.05  # m that a height must be off the origin
DOWN = (POSITION.columns[2], f"-{POSITION.columns[2]}")  # a height that counts down
LEAST_TILT = 0.01  # standard deviation in units of gravity below which a tilt is not judged


@dataclass(frozen=True)
class Agreement:
    """A measured derivative against the derivative of what was measured.

    Args:
        of: whose derivative it should be: attitude, position or a joint.
        correlation: −1 is a wrong sign; None where there is too little motion to judge.
        in_other_frame: the same correlation with the velocity turned from body to world; None where it does not apply.
        ratio: of their standard deviations: how many times as large the measured derivative is (of a thrust, the push);
            1 where there is too little motion.
    """

    of: str
    correlation: float | None
    in_other_frame: float | None = None
    ratio: float = 1.0

    @property
    def verdict(self) -> str:
        """agrees, reversed, unclear or too little motion."""
        if self.correlation is None:
            return "too little motion"
        if self.correlation <= -CLEAR:
            return "reversed"
        return "agrees" if self.correlation >= CLEAR else "unclear"

    @property
    def concordance(self) -> float:
        """How nearly both are equal but for an offset and the sign, at most 1; NaN where there is too little motion.

        L. Lin, "A concordance correlation coefficient", Biometrics 45 (1989).
        """
        known = self.correlation is not None and self.ratio > 0.0
        return 2.0 * abs(self.correlation or 0.0) / (self.ratio + 1.0 / self.ratio) if known else float("nan")


def agreements(logs: Sequence[Trajectory]) -> dict[str, Agreement]:
    """Of every rate of a body, a position or a joint."""
    return {**rate_agreement(logs), **velocity_agreement(logs)}


def rate_agreement(logs: Sequence[Trajectory]) -> dict[str, Agreement]:
    """Every body rate against the derivative of the attitude or heading."""
    layout = logs[0].layouts.state
    if not (layout.has_field("attitude") or layout.has_field("heading")):
        return {}
    by_column = {}
    for column in (name for name in RATES if name in layout):
        pairs = [(_middle(trajectory.column(column)), turning(trajectory, column)) for trajectory in logs]
        correlation, ratio = _compared(pairs, LEAST_MOTION["rad/s"])
        by_column[column] = Agreement("attitude", correlation, ratio=ratio)
    return by_column


def thrust_agreement(logs: Sequence[Trajectory]) -> Agreement:
    """The horizontal way that a quadrotor accelerates, against where its attitude says that its thrust points.

    As it stands, and with the attitude turned the other way (world to body where body to world is meant).
    """
    layout = logs[0].layouts.state
    if not layout.has_field("attitude") or not all(name in layout for name in POSITION.columns[:2]):
        return Agreement("attitude", None)
    comparisons = []
    for turn in (lambda q: q, rotation.conjugate):
        pairs = [lateral_motion(log, turn) for log in logs]
        comparisons.append(_compared([(axis[:, i], moved[:, i]) for moved, axis in pairs for i in (0, 1)], LEAST_TILT))
    (own, ratio), (other, _) = comparisons
    return Agreement("attitude", own, other, 1.0 / ratio if ratio else 0.0)


def least_agreement(logs: Sequence[Trajectory]) -> float:
    """The least of rates with the attitude's derivative and of accelerations with the thrust; NaN where all rests."""
    agreements = (*rate_agreement(logs).values(), thrust_agreement(logs))
    correlations = [abs(agreement.correlation) for agreement in agreements if agreement.correlation is not None]
    return min(correlations, default=float("nan"))


def above_ground(logs: Sequence[Trajectory]) -> bool:
    """Whether robots are above the origin most of the time, as those that fly are with z up."""
    heights = [log.column(POSITION.columns[2]) for log in logs if POSITION.columns[2] in log.layouts.state]
    return bool(heights) and float(np.median(np.concatenate(heights))) > ALOFT


def lateral_motion(log: Trajectory, turn: Callable[[torch.Tensor], torch.Tensor] = lambda q: q) -> tuple[Array, Array]:
    """How a robot accelerates sideways, and its thrust axis, level, in units of gravity ``# (rows - 2, 2)`` each.

    Args:
        turn: what is made of the attitude first.
    """
    axis = derive.up(turn(attitude(log)).numpy())
    accelerations = [_acceleration(log.column(name), log.dt) for name in POSITION.columns[:2]]
    return np.stack(accelerations, axis=1), axis[1:-1, :2]


def points_along(logs: Sequence[Trajectory]) -> float:
    """How nearly a car heads where it goes, or thrust points where it pushes, at most 1; 0 where nobody can tell."""
    if logs[0].layouts.state.has_field(HEADING.name):
        return together(courses(logs), headings(logs))
    return thrust_agreement(logs).correlation or 0.0


def off_the_way(log: Trajectory) -> float:
    """Angle in rad from where a car heads to where it goes, or from where thrust points to where it pushes."""
    if log.layouts.state.has_field(HEADING.name):
        return float(np.angle(np.nansum(np.exp(1j * (courses([log])[0] - headings([log])[0])))))
    acceleration, axis = (level @ np.array([1.0, 1.0j]) for level in lateral_motion(log))
    return float(np.angle(np.vdot(axis, acceleration)))


def _acceleration(position: Array, dt: float) -> Array:
    """Acceleration in units of gravity between rows that are averaged first ``# (rows - 2,)``."""
    kernel = np.ones(2 * SMOOTHING + 1) / (2 * SMOOTHING + 1)
    smooth = np.convolve(np.pad(position, SMOOTHING, mode="edge"), kernel, "valid")
    return np.diff(smooth, n=2) / dt**2 / GRAVITY


def turning(trajectory: Trajectory, column: str) -> Array:
    """Rate between rows about a body axis in rad/s ``# (rows - 1,)``, from the attitude."""
    facing = attitude(trajectory)
    turn = rotation.logarithm(rotation.multiply(rotation.conjugate(facing[:-1]), facing[1:])).numpy()
    return np.asarray(turn[:, RATES.index(column)] / np.diff(trajectory.time))


def velocity_agreement(logs: Sequence[Trajectory]) -> dict[str, Agreement]:
    """Velocities and rates of joints against the change of the coordinate; velocities turned from body axes as well."""
    state, by_column = logs[0].layouts.state, {}
    faces = state.has_field("attitude") or state.has_field("heading")
    for coordinate, column in state.rates.items():
        least = LEAST_MOTION.get(state.units[column], 0.0)
        moved = [np.diff(log.column(coordinate)) / np.diff(log.time) for log in logs]
        own, ratio = _compared([(_middle(log.column(column)), m) for log, m in zip(logs, moved, strict=True)], least)
        if column not in VELOCITIES:
            by_column[column] = Agreement(coordinate, own, ratio=ratio)
            continue
        place = VELOCITIES.index(column)
        other = [(_middle(turned(log, VELOCITIES)[:, place]), m) for log, m in zip(logs, moved, strict=True) if faces]
        by_column[column] = Agreement(POSITION.name, own, _compared(other, least)[0] if other else None, ratio)
    return by_column


def _middle(values: Array) -> Array:
    """Between rows ``# (rows - 1,)``."""
    return 0.5 * (values[1:] + values[:-1])


def _compared(pairs: Sequence[tuple[Array, Array]], least: float) -> tuple[float | None, float]:
    """Correlation of two smoothed series, and how many times as large the first is; None and 1 where both rest."""
    kernel = np.ones(SMOOTHING) / SMOOTHING
    usable = [pair for pair in pairs if len(pair[0]) >= SMOOTHING]
    if not usable:
        return None, 1.0
    first, other = (np.concatenate([np.convolve(pair[i], kernel, "valid") for pair in usable]) for i in (0, 1))
    sizes = first.std(), other.std()
    if len(first) < 2 or max(sizes) < least or not min(sizes):
        return None, 1.0
    return float(np.corrcoef(first, other)[0, 1]), float(sizes[0] / sizes[1])
