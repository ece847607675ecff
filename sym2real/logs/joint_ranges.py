"""Evidence by where a model's joints end: the units that keep a coordinate within, and counts of an encoder."""

from collections.abc import Sequence
from math import pi

import numpy as np

from sym2real.logs.draft import Draft
from sym2real.logs.reading import Said
from sym2real.logs.units import UNITS
from sym2real.trajectory import Array
from sym2real.vocabulary import roughly

Ends = tuple[float, float]  # of a joint, or of what it is told, rad or m

COUNTS = (4096, 16384)  # a turn: of servos on a bus, and of finer magnetic encoders


def possible(draft: Draft, column: str, units: Sequence[str], ends: Ends | None) -> tuple[str, ...]:
    """Those of the units that keep a column of the model in its range, widened by its width; all without a range."""
    values = draft.values(column)
    return tuple(unit for unit in units if ends is None or _within(UNITS[unit][1] * values, ends))


def leave_counts_open(draft: Draft, column: str, wanted: str, ends: Ends, rate: str = "") -> None:
    """File a column that no unit keeps in its range, with the counts that would; the log is not read without a line.

    Args:
        draft: of the log.
        column: of the model.
        wanted: its unit.
        ends: its range.
        rate: column of the model that is its rate, of which the log has one; "" without.
    """
    values = draft.values(column)
    size = f"{values.min():.5g} to {values.max():.5g}, where it ends at {ends[0]:.3g} and {ends[1]:.3g} {wanted}"
    turn = next((turn for turn in COUNTS if _are_counts(values, turn, ends)), 0) if wanted == "rad" else 0
    if not turn:
        draft.leave_open(column, f"{column}, but far outside its range", size, f'unit = "…" }}  # {size}')
        return
    scale = 2.0 * pi / turn
    said = f"{size}: counts of {turn} a turn would fit"
    draft.leave_open(column, f"{column}, in counts", said, f"zero = {turn // 2}, scale = {scale:.6g} }}  # {said}")
    if rate:
        share = draft.rows.ratio(scale * draft.rows.slopes(values), draft.values(rate))
        said = f"the slope of {column} in rad/s moves {share:.4g} times as much"
        draft.leave_open(rate, f"{rate}, in counts", said, f"scale = {share:.4g} }}  # {said}")


def named_outside(draft: Draft, column: str, said: Said, ends: Ends) -> Said:
    """What is said of a column's unit, and that it lies far outside its range in this unit if it does."""
    unit, evidence, _ = said
    if possible(draft, column, (unit,), ends):
        return said
    return unit, f"{evidence}; far outside its range of {ends[0]:.3g} to {ends[1]:.3g}", "guess"


def _within(values: Array, ends: Ends) -> bool:
    low, high = roughly(ends)
    return bool(low <= values.min() and values.max() <= high)


def _are_counts(values: Array, turn: int, ends: Ends) -> bool:
    whole = bool((values == np.round(values)).all() and values.min() >= 0 and values.max() < turn)
    return whole and _within(2.0 * pi / turn * (values - turn // 2), ends)
