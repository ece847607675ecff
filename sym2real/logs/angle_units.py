"""Evidence on what angles are counted in: by their names, by what they move like, by size.

Size is the last to be asked, and of roll and pitch first: a yaw that counts on beyond a turn may have any.
"""

from collections.abc import Mapping
from itertools import product
from math import isnan, log, pi

import numpy as np
import torch

from sym2real import rotation
from sym2real.logs.attitude_reading import read_attitude, tilts
from sym2real.logs.course import decides, together
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_motion import FASTEST, RATES
from sym2real.logs.parts import Attitude
from sym2real.logs.reading import CLEAR, Reading, by_name, by_ratio, largest
from sym2real.logs.units import UNITS, unit_by_ratio
from sym2real.trajectory import Array
from sym2real.vocabulary import RATE

ANGLES = ("rad", "deg")
WHOLE_TURN = 0.1  # of a turn, within which a jump is one: it turns meanwhile
BEYOND = 1.01  # times, from which on a size is impossible, noise included
ALIKE = 4.0  # times; an acceleration as near to what a tilt causes is its: drag and wind are in it too


def of_measured(draft: Draft, columns: tuple[str, ...]) -> Reading:
    """Unit of measured roll, pitch and yaw."""
    turning = by_gyro(draft, dict(zip(RATE.columns, columns, strict=True)))
    return by_name(draft, columns) or turning or _by_tilt(draft, columns) or _by_size(draft, columns)


def of_wanted(draft: Draft, columns: tuple[str, ...]) -> Reading:
    """Unit of roll, pitch and yaw as commanded, or of a reference, once the measured attitude is known."""
    return by_name(draft, columns) or _by_answer(draft, columns) or _by_size(draft, columns)


def by_turning(values: Array, other: Array | None, what: str) -> tuple[float, Reading | None]:
    """The sense and unit in which a heading turns as another in rad does, in words, where only one does."""
    if other is None:
        return 1.0, None
    scores = {
        (unit, sense): together([other], [sense * UNITS[unit][1] * values])
        for unit, sense in product(ANGLES, (1.0, -1.0))
    }
    best = max(scores, key=lambda reading: scores[reading])
    if isnan(scores[best]) or not all(decides(scores[best], scores[score]) for score in scores if score != best):
        return 1.0, None
    unit, sense = best
    second = max(score for (name, _), score in scores.items() if name != unit)
    turned = "with" if sense > 0 else "against"
    return sense, (unit, f"in {unit} it turns {turned} {what} ({scores[best]:.2f}; {second:.2f})", "certain")


def by_gyro(draft: Draft, angles: Mapping[str, str]) -> Reading | None:
    """The unit in which angles, by the body rate that each has for its slope, turn as a gyro does.

    None where nothing turns, and where the gyro may be in the same unit a second, whatever that is.
    """
    slopes = {rate: draft.rows.slopes(draft.raw(column)) for rate, column in angles.items() if draft.has(rate)}
    like = [rate for rate in slopes if abs(draft.rows.correlation(slopes[rate], draft.values(rate))) > CLEAR]
    if not like:
        return None
    share = float(np.median([draft.rows.ratio(slopes[rate], draft.values(rate)) for rate in like]))
    known = draft.named_unit(*slopes) or (RATES[1] if largest(draft, [*slopes]) > FASTEST else "")
    gyros = (known,) if known else RATES[:2]
    units = {unit_by_ratio(share / UNITS[gyro][1], ANGLES) for gyro in gyros}
    what = f"the gyro in {' or '.join(gyros)}"
    return (units.pop(), f"turns {share:.3g} times as much as {what}", "certain") if len(units) == 1 else None


def by_wraps(draft: Draft, yaw: Array) -> Reading | None:
    """The unit whose whole turn is what a heading jumps by."""
    sizes = jumps(draft, yaw)
    span = max(float(np.ptp(part)) for part in draft.rows.parts(yaw))
    for unit in ANGLES:
        turn = turn_in(unit)
        whole = np.abs(sizes - turn) < WHOLE_TURN * turn
        if whole.any() and (1.0 - WHOLE_TURN) * turn < span < (1.0 + WHOLE_TURN) * turn:
            return unit, f"wraps by {sizes[whole].mean():.4g}, a turn in {unit}", "certain"
    return None


def by_turns(yaw: Array) -> Reading:
    """The unit of a heading that nothing tells but its size."""
    size = float(np.abs(yaw).max())
    if size > BEYOND * turn_in("rad"):
        return "deg", f"up to {size:.4g}, more than a turn in rad; or rad, if it counts on", "guess"
    return "rad", f"up to {size:.3g}", "likely"


def turn_in(unit: str) -> float:
    """A whole turn."""
    return 2.0 * pi / UNITS[unit][1]


def jumps(draft: Draft, values: Array) -> Array:
    """Sizes of steps from row to row."""
    return np.abs(draft.rows.each(np.diff, values))


def _by_tilt(draft: Draft, columns: tuple[str, ...]) -> Reading | None:
    """The unit in which a tilt causes the acceleration that positions show, whichever sign the angles have.

    Noise of positions adds to an acceleration, and not to what of it goes along with the tilt.
    """
    shares = {}
    for unit in ANGLES:
        pairs = tilts(draft, read_attitude(draft, Attitude(euler=columns, unit=unit)))  # type: ignore[arg-type]
        moved = [draft.rows.moving(np.stack(pair, axis=1)) for pair in pairs.values()]
        caused = sum(float(np.square(pair[:, 0]).sum()) for pair in moved)
        shown = sum(abs(float((pair[:, 0] * pair[:, 1]).sum())) for pair in moved)
        if shown > 0.0:
            shares[unit] = shown / caused
    best = min(shares, key=lambda unit: abs(log(shares[unit])), default="")
    if not best or abs(log(shares[best])) > log(ALIKE):
        return None
    return best, f"in {best} positions show {shares[best]:.2f} of the acceleration that its tilt causes", "certain"


def _by_answer(draft: Draft, columns: tuple[str, ...]) -> Reading | None:
    if draft.world is None:
        return None
    values, measured = draft.raw(*columns), rotation.to_euler(torch.from_numpy(draft.world)).numpy()
    pairs = list(zip(values.T, measured.T, strict=True))
    like = [pair for pair in pairs[:2] if abs(draft.rows.correlation(*pair)) > CLEAR]
    if not like:
        return by_turning(*pairs[2], "the measured attitude")[1]
    share = float(np.median([draft.rows.ratio(*pair) for pair in like]))
    return by_ratio(ANGLES, share, "the measured attitude in rad")


def _by_size(draft: Draft, columns: tuple[str, ...]) -> Reading:
    """Who flies tilts by at most half a turn to the sides, and a quarter turn ahead."""
    roll, pitch, yaw = draft.raw(*columns).T
    sizes = float(np.abs(roll).max()), float(np.abs(pitch).max())
    if sizes[0] > BEYOND * pi or sizes[1] > BEYOND * pi / 2.0:
        return "deg", f"tilts by up to {max(sizes):.4g}", "certain"
    return by_wraps(draft, yaw) or by_turns(yaw)
