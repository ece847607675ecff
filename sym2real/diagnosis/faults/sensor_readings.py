"""Scale, bias and time shift of measured rates and velocities, against attitude, position or joint, which they change.

A sensor that reports w(t) = k ω(t - d) + b satisfies over any stretch of a log

    Δθ = ∫ω dt = (1/k) ∫w dt - (b/k) Δt + (d/k) Δw,

linear in what is unknown, with ∫w dt from the sensor and Δθ from the attitude (Δx from the position): integrals, so
that nothing noisy is differentiated. Shifts of several rows are looked for row by row first. What is tested must be
beyond chance, and beyond what honest logs have: velocities by differences are half a row late, filtered ones a row.

White noise of the sensor makes 1/k too small by the part that it has of the variance of ∫w (attenuation, see W. Fuller,
"Measurement Error Models", 1987, section 1.1), and the rate's mean then looks like a bias: on one circle, where a rate
hardly changes, that is most of it. What noise may have done in this way is no fault.

Where the sensor misses more than white noise (a rate that changes between two rows), the same happens to a degree that
nobody knows. So a scale is one only where the two go together beyond chance, and where the other regression, of the
sensor on the angle, says so as well: noise makes the one slope too small and the other's inverse too large, and the
true one lies between (C. Gini, Metron 1, 1921).

A controller that sees a noisy angle answers the noise: the rate follows it a row later, as if the sensor were early. So
a shift is one only where the angle's changes miss more without it than the angle's own noise.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np
from scipy.integrate import cumulative_trapezoid

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.start import ROWS
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.readings import SENSOR_BIAS, SENSOR_SCALE, TIME_SHIFT
from sym2real.layout import Layout
from sym2real.logs.agreement import RATES, turning
from sym2real.logs.noise import noise_level
from sym2real.logs.sources import AsRead
from sym2real.logs.wheel_speed import along, made_of_wheel, way, with_along
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import ATTITUDE, HEADING, POSITION

STRETCH = 0.4  # s
PATH, POSE = "path", (*POSITION.columns, *HEADING.columns)  # what a wheel's speed goes along, and what tells of it
EARLIEST, LATEST = -5, 12
Signals = tuple[Array, Array, Array]  # of a log: time and what a sensor says, and how the other changes from row to row


@dataclass(frozen=True)
class Reading:
    """How a sensor reports what it measures: w(t) = scale · ω(t - shift) + bias.

    Args:
        column: of the state.
        of: what it is the rate of: the attitude, the position or a joint.
        scale, bias, shift: factor, offset in the column's unit, s; 1, 0 and 0 where nothing is wrong.
        unsure: standard deviation of the offset.
    """

    column: str
    of: str
    scale: float
    bias: float
    unsure: float
    shift: float

    @property
    def faulty(self) -> dict[str, float]:
        """What is wrong, by kind of effect, in the order in which it is undone."""
        wrong = ((TIME_SHIFT, self.shift, 0.0), (SENSOR_BIAS, self.bias, 0.0), (SENSOR_SCALE, self.scale, 1.0))
        return {kind.name: value for kind, value, null in wrong if value != null}

    def undone(self, log: Trajectory) -> Trajectory:
        """The log as an honest sensor would have written it; its ends are held where a shift leaves them."""
        return log.with_columns({self.column: self.honest(log.time, log.column(self.column))})

    def honest(self, time: Array, values: Array) -> Array:
        """What an honest sensor would have reported in place of values ``# (rows,)``."""
        return np.asarray((np.interp(time + self.shift, time, values) - self.bias) / self.scale)


@dataclass(frozen=True)
class OfWheel(Reading):
    """Of a wheel's speed, which stands in velocities along the heading alone; ``column`` is the file's."""

    def undone(self, log: Trajectory) -> Trajectory:
        """With the velocity along the heading that an honest wheel would have given."""
        return with_along(log, self.honest(log.time, along(log)))


def readings(data: Dataset, honest: float = 1.0, *, noisy: bool = True) -> tuple[Reading, ...]:
    """Columns whose sensor is wrong in scale, bias or time; the others are left out, and logs too short to judge by.

    Args:
        data: logs, or what a model predicts of them.
        honest: rows that a sensor may be late: differences are by half of one, filters by one.
        noisy: whether sensors have noise; predictions have none, and their scale is what it is, small or not.
    """
    readings = list[Reading | None]()
    logs = [log for log in data if len(log) > ROWS]
    if not logs:
        return ()
    for column, other in rates_of(data).items():
        if other == PATH:
            signals = [(log.time, along(log), way(log)) for log in logs]
            wheel = _reading(signals, AsRead(logs[0].sources).column(column), PATH, honest, noisy)
            readings.append(wheel and OfWheel(**vars(wheel)))
        else:
            signals = [(log.time, log.column(column), _change(log, column, other)) for log in logs]
            readings.append(_reading(signals, column, other, honest, noisy))
    return tuple(reading for reading in readings if reading is not None and reading.faulty)


def rates_of(data: Dataset) -> dict[str, str]:
    """Columns that are measured rates, with what each is the rate of; a wheel's speed by the column that it was."""
    layout, made = data.layouts.state, made_of_wheel(data)
    turns = layout.has_field("attitude") or layout.has_field("heading")
    moving = {rate: coordinate for coordinate, rate in layout.rates.items() if rate not in made}
    return {rate: "attitude" for rate in RATES if turns and rate in layout} | moving | dict.fromkeys(made[:1], PATH)


def measured_by(state: Layout, of: str) -> tuple[str, tuple[str, ...]]:
    """Name and columns of what rates are of: an attitude or a heading, the position, a joint."""
    if of == PATH:
        return "pose", tuple(name for name in POSE if name in state)
    names = (ATTITUDE.name, HEADING.name) if of == ATTITUDE.name else (of,)
    return next(((field.name, field.columns) for field in state.fields if field.name in names), (of, (of,)))


def _change(log: Trajectory, column: str, of: str) -> Array:
    """From row to row ``# (rows - 1,)``."""
    return turning(log, column) * np.diff(log.time) if column in RATES else np.diff(log.column(of))


def _reading(signals: Sequence[Signals], column: str, of: str, honest: float, noisy: bool) -> Reading | None:
    """None where there are too few stretches, or the sensor does not go with what it is the rate of."""
    dt = float(np.median(np.concatenate([np.diff(time) for time, _, _ in signals])))
    length = max(5, round(STRETCH / dt))
    tables = {rows: _stretches(signals, length, rows) for rows in range(EARLIEST, LATEST + 1)}
    if len(tables[0]) < SETTINGS.sensor_stretches:
        return None
    levels = [noise_level(values[:, None]) for _, values, _ in signals] if noisy else [np.zeros(1)]
    noise = float(np.median(levels) * dt * np.sqrt(length))
    of_angle = float(np.median([noise_level(np.cumsum(change)[:, None]) for _, _, change in signals]))
    if (moved := _shift(tables, dt, honest, noise**2 + 2.0 * of_angle**2)) is None:
        return None
    rows, shift = moved
    # Predictions begin with the speed that a wheel says, right or wrong: their own scale is beyond chance or none.
    if (scale_and_bias := _scale_and_bias(tables[rows], noise, noisy or of == PATH)) is None:
        return None
    return Reading(column, POSITION.name if of in POSITION.columns else of, *scale_and_bias, shift)


def _shift(tables: Mapping[int, Array], dt: float, honest: float, variance: float) -> tuple[int, float] | None:
    """Rows that the sensor is late, and s; zeros within what is honest, None where it does not go along.

    Args:
        tables: stretches by rows that the sensor is moved.
        variance: of what noise alone leaves of a stretch.
    """
    left = {rows: float(_fit(table)[2].var()) for rows, table in tables.items()}
    rows = min(left, key=lambda lag: left[lag])
    # A likelihood ratio, which must be as far beyond chance as the rest.
    if len(tables[0]) * np.log(max(left[0], 1e-300) / max(left[rows], 1e-300)) < SETTINGS.sensor_deviations**2:
        rows = 0
    (inverse, _, late), covariance, _ = _fit(tables[rows])
    if inverse <= 0:
        return None
    shift = rows * dt + late / inverse
    beyond_chance = abs(shift) > SETTINGS.sensor_deviations * sqrt(covariance[2, 2]) / inverse
    _, _, missed = _fit(tables[0][:, :3])  # by scale and bias alone
    likely = variance * (1.0 + SETTINGS.sensor_deviations * sqrt(2.0 / len(missed)))
    shifted = beyond_chance and abs(shift) > honest * dt and float(np.square(missed).mean()) > likely
    # A lag that is none was chosen for errors that it makes small: scale and bias read there take these errors up.
    return (rows, shift) if shifted else (0, 0.0)


def _scale_and_bias(table: Array, noise: float, noisy: bool) -> tuple[float, float, float] | None:
    """Scale, bias and its deviation as of :class:`Reading`, for white noise of this size in ∫w.

    None where the sensor does not go along.
    """
    (inverse, constant, _), covariance, _ = _fit(table)
    if inverse <= 0:
        return None
    spread = np.sqrt(covariance.diagonal())
    both, others = table[:, :2], table[:, 2:]
    # Δθ and ∫w beyond what time and Δw explain of them.
    turned, whole = (both - others @ np.linalg.lstsq(others, both, rcond=None)[0]).T
    weakened = min(1.0, noise**2 / max(float(np.square(whole).mean()), 1e-300))  # attenuation, see above
    turned_by = weakened * abs(table[:, 1].sum() / table[:, 2].sum())
    scale, bias = 1.0 / inverse, -constant / inverse
    # Slope of Δθ on ∫w, and the inverse of that of ∫w on Δθ: noise of ∫w makes the first too small, noise of Δθ the
    # second too large.
    together = float(turned @ whole)
    least, most = together / max(float(whole @ whole), 1e-300), float(turned @ turned) / max(together, 1e-300)
    by_chance = SETTINGS.sensor_deviations * spread[0]
    sure = inverse > by_chance and abs(inverse - 1.0) > by_chance + weakened
    scaled = sure and abs(np.log(scale)) > SETTINGS.uneven and not least <= 1.0 <= most
    usual = SETTINGS.sensor_bias * max(1.0, scale)
    biased = abs(constant) > SETTINGS.sensor_deviations * spread[1] + turned_by and abs(bias) > usual
    return scale if scaled or not noisy else 1.0, bias if biased else 0.0, float(spread[1] / inverse)


def _stretches(signals: Sequence[Signals], length: int, rows: int) -> Array:
    """Change, integral of the sensor so many rows later, time and change of the sensor ``# (stretches, 4)``."""
    stretches = []
    for time, value, change in signals:
        turned = np.concatenate([[0.0], np.cumsum(change)])
        first = np.arange(-EARLIEST, len(value) - length - LATEST, length)
        moved = ((turned, 0), (cumulative_trapezoid(value, time, initial=0), rows), (time, 0), (value, rows))
        stretches.append(np.stack([all_of[first + length + by] - all_of[first + by] for all_of, by in moved], axis=1))
    return np.concatenate(stretches)


def _fit(table: Array) -> tuple[Array, Array, Array]:
    """Least squares with a covariance that holds for errors of any size: values, covariance, what is left."""
    target, design = table[:, 0], table[:, 1:]
    inverse = np.linalg.pinv(design.T @ design)
    values = inverse @ design.T @ target
    left = target - design @ values
    return values, inverse @ ((design * left[:, None] ** 2).T @ design) @ inverse, left
