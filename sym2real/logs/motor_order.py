"""Which column of a log moves which motor of a quadrotor, from how the body's turning changes.

Over a stretch of a log, in body axes,

    ω(t + L) - ω(t) = g ∘ ∫ α(s - d) ds + nuisances,

where α is the angular acceleration that the motors should cause and g > 0 what inertia and thrust were wrong by, axis
by axis. In another order of the columns α is another series: of all 24 orders, each with the rotors turning as they
should or the other way (which reverses yaw alone), the right one correlates best. Motors answer late and logs are not
aligned, so that every order may choose its delay and lag. What else turns a body (a torque that is constant for a
second, its rates, their products, the air along its axes) is taken away first: under feedback it goes with the motors.

A correlation has no gain that could be fitted to it. It is taken second by second, whatever was flown in it, and what
one order has before another is held against its scatter from second to second. Motors that move all alike say nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.signal import lfilter

from sym2real.trajectory import Array

ORDERS = tuple(permutations(range(4)))
STRETCH, BLOCK = 0.1, 1.0  # s
# Time by which a log may have its motors late, or early, and time constants of rotors; s.
SHIFTS, LAGS = (-0.04, -0.02, 0.0, 0.02, 0.04), (0.0, 0.03, 0.06, 0.1)
FEWEST = 10  # seconds
# Standard deviations beyond which a difference of correlations is no chance, and the size that it must have on an axis;
# and those by which an order must lead the other 22 to be named.
SURE, CLEAR, NAMED = 5.0, 0.2, 3.0


@dataclass(frozen=True, eq=False)
class Turning:
    """A flight, as far as the order of its motors shows.

    Args:
        time: in s ``# (rows,)``.
        rates: about body axes (forward, left, up) in rad/s ``# (rows, 3)``.
        air: velocity along body axes in m/s ``# (rows, 3)``; any number of columns.
        caused: angular acceleration that the motors cause with the columns in each of :data:`ORDERS`, in any unit
            ``# (24, rows, 3)``.
    """

    time: Array
    rates: Array
    air: Array
    caused: Array


@dataclass(frozen=True)
class MotorOrder:
    """An order that fits decisively better than that of the log.

    Args:
        columns: of each motor, the column of the log that moves it, counted from 0.
        reversed: whether the rotors turn the other way.
        correlation: of what motors cause in this order and how the rates change, mean of the three axes.
        as_it_stands: the same of the log's own order.
        certain: whether no other order is left that may be the right one as well.
    """

    columns: tuple[int, ...]
    reversed: bool
    correlation: float
    as_it_stands: float
    certain: bool

    @property
    def moved(self) -> dict[int, int]:
        """Motor → column of the log that moves it, where they differ, counted from 0."""
        return {motor: column for motor, column in enumerate(self.columns) if motor != column}


def motor_order(flights: Sequence[Turning]) -> MotorOrder | None:
    """The order of the motors, where it is beyond doubt that it is not the log's; else None."""
    shortest = BLOCK + STRETCH + 2 * max(SHIFTS)
    flights = [
        turning for turning in flights if turning.time[-1] - turning.time[0] > shortest and len(_ends(turning.time)[0])
    ]
    blocks = _correlations(flights) if flights else np.zeros((0, len(ORDERS), 2, 3))
    if len(blocks) < FEWEST:
        return None
    score = blocks.sum((0, 3))
    order, way = (int(place) for place in np.unravel_index(int(score.argmax()), score.shape))
    leads = [_lead(blocks[:, order, way], blocks[:, other, int(score[other].argmax())]) for other in range(len(ORDERS))]
    certain = min(lead for other, lead in enumerate(leads) if other != order) > NAMED
    # Which way the rotors turn is a question of its own, and none where the order is not known.
    reversed_ = certain and way == 1 and _lead(blocks[:, order, 1], blocks[:, order, 0]) > SURE
    if not reversed_ and (order == 0 or leads[0] <= SURE):
        return None
    best, stands = blocks[:, order, int(reversed_)], blocks[:, 0, 0]
    return MotorOrder(ORDERS[order], reversed_, float(best.mean()), float(stands.mean()), certain)


def _lead(better: Array, worse: Array) -> float:
    """Standard deviations by which correlations ``# (blocks, axes)`` lead others; 0 where it is too little to count."""
    apart = better - worse
    if apart.mean(0).max() < CLEAR:
        return 0.0
    by_block = apart.sum(1)
    return float(by_block.mean() / max(by_block.std(ddof=1) / np.sqrt(len(by_block)), 1e-300))


def _correlations(flights: Sequence[Turning]) -> Array:
    """Of what motors cause and how rates change, each order with the delay and lag that suit it best.

    ``# (blocks, orders, 2, axes)``, rotors turning as they should and the other way.
    """
    candidates = (
        _by_block([_stretches(turning, shift, lag) for turning in flights]) for shift, lag in product(SHIFTS, LAGS)
    )
    best = next(candidates)
    for candidate in candidates:
        better = candidate.sum((0, 3)) > best.sum((0, 3))
        best[:, better] = candidate[:, better]
    return best


def _stretches(turning: Turning, shift: float, lag: float) -> tuple[Array, Array, Array, NDArray[np.int64]]:
    """Changes of the rates ``# (n, 3)``, nuisances ``# (n, k)``, what motors cause ``# (n, 72)``, blocks ``# (n,)``."""
    first, last = _ends(turning.time)
    caused = turning.caused.transpose(1, 0, 2).reshape(len(turning.time), -1)
    if lag:
        kept = np.exp(-float(np.median(np.diff(turning.time))) / lag)
        start = kept * caused[:1]
        caused = lfilter([1.0 - kept], [1.0, -kept], caused, axis=0, zi=start)[0]
    motors = make_interp_spline(turning.time, _integral(turning.time, caused), k=1)
    early, late = (motors(turning.time[rows] - shift) for rows in (first, last))
    rates = turning.rates
    coupled = np.stack([rates[:, 1] * rates[:, 2], rates[:, 0] * rates[:, 2], rates[:, 0] * rates[:, 1]], axis=1)
    others = _integral(turning.time, np.column_stack([rates, coupled, turning.air]))
    blocks = ((turning.time[first] - turning.time[first[0]]) / BLOCK).astype(np.int64)
    return rates[last] - rates[first], others[last] - others[first], late - early, blocks


def _ends(time: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and last rows of stretches that stay in the log whatever the shift ``# (n,)``; none of too few rows."""
    step = float(np.median(np.diff(time)))
    length = max(1, round(STRETCH / step))
    edge = int(np.ceil(max(map(abs, SHIFTS)) / step))
    first = np.arange(edge, len(time) - length - edge, max(1, length // 2))
    return first, first + length


def _integral(time: Array, values: Array) -> Array:
    """From the first row to every row, of values that are held from row to row ``# (rows, columns)``."""
    steps = values[:-1] * np.diff(time)[:, None]
    return np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(steps, axis=0)])


def _by_block(tables: Sequence[tuple[Array, Array, Array, NDArray[np.int64]]]) -> Array:
    """Correlations of one delay and lag, what nuisances explain taken away ``# (blocks, orders, 2, axes)``."""
    changes, others, motors, _ = (np.concatenate(parts) for parts in zip(*tables, strict=True))
    firsts = np.cumsum([0, *(int(table[3][-1]) + 1 for table in tables)])
    blocks = np.concatenate([first + table[3] for first, table in zip(firsts, tables, strict=False)])
    others, values = (_centred(part, blocks) for part in (others, np.column_stack([changes, motors])))
    rest = values - others @ np.linalg.lstsq(others, values, rcond=None)[0]
    change, cause = rest[:, None, :3], rest[:, 3:].reshape(len(rest), len(ORDERS), 3)
    sums = [np.zeros((firsts[-1], len(ORDERS), 3)) for _ in range(3)]
    for total, part in zip(sums, (change * cause, np.square(change), np.square(cause)), strict=True):
        np.add.at(total, blocks, part)
    together, changed, caused = sums
    correlations = together / np.sqrt(np.maximum(changed * caused, 1e-300))
    return np.stack([correlations, correlations * [1.0, 1.0, -1.0]], axis=2)


def _centred(values: Array, blocks: NDArray[np.int64]) -> Array:
    """Columns ``# (n, k)`` without their means over every block."""
    sums = np.zeros((int(blocks[-1]) + 1, values.shape[1]))
    np.add.at(sums, blocks, values)
    return values - (sums / np.maximum(np.bincount(blocks), 1)[:, None])[blocks]
