"""What columns are counted in, and whether their sign holds: by their names, by what they must move like, by size.

Whatever a log holds twice, measured and as the slope or the cause of something else, must move alike. The ratio of the
two tells the unit, their correlation the sign.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from sym2real.logs.draft import Confidence, Draft
from sym2real.logs.units import unit_by_ratio
from sym2real.trajectory import Array

CLEAR = 0.5  # a correlation that decides
WEAK = 0.3  # one below it says nothing
SHORTEST_PULSE, LONGEST_PULSE = 900.0, 2200.0  # µs, of servos and speed controllers

Reading = tuple[str, str, Confidence]  # a unit, the evidence for it, and how sure that is


def largest(draft: Draft, names: Sequence[str]) -> float:
    """Largest magnitude of standard columns, in the log's unit."""
    return float(np.abs(draft.values(*names)).max())


def turning(draft: Draft, rate: str) -> Array | None:
    """A body rate by attitude or heading, else by the gyro; None where none is known."""
    return draft.turning.get(rate, draft.series(rate) if draft.has(rate) else None)


def are_pulses(values: Array) -> bool:
    """Whether these are pulses in µs, of servos or speed controllers."""
    return bool(((values >= SHORTEST_PULSE) & (values <= LONGEST_PULSE)).all())


def by_name(draft: Draft, names: Sequence[str]) -> Reading | None:
    """The unit that the name of one of these states, standard columns or columns of the log."""
    unit = draft.named_unit(*names)
    return (unit, "the name says so", "certain") if unit else None


def by_ratio(units: Sequence[str], share: float, what: str) -> Reading:
    """The unit of numbers that move so many times as much as something in SI units, in words."""
    return unit_by_ratio(share, units), f"moves {share:.3g} times as much as {what}", "certain"


def by_others(draft: Draft, units: Sequence[str], expected: Mapping[str, Array], what: str) -> Reading | None:
    """The unit of standard columns by what they should be in SI units ``# (rows,)``, in words; None without any.

    One that never moves says nothing of it: a car's odometry has no velocity to the side.
    """
    moving = {name: values for name in expected if np.ptp(values := draft.values(name)) > 0}
    shares = [draft.rows.ratio(values, expected[name]) for name, values in moving.items()]
    return by_ratio(units, float(np.median(shares)), what) if shares else None


def by_size(units: Sequence[str], size: float, most: float, otherwise: Reading | None = None) -> Reading:
    """The first of the units, or the second where a size is beyond the most that is possible in the first.

    What other evidence says is taken instead, if it is possible.
    """
    if otherwise and (size <= most or otherwise[0] != units[0]):
        return otherwise
    return (units[1], f"up to {size:.4g}", "certain") if size > most else (units[0], f"up to {size:.3g}", "likely")


def settle(draft: Draft, names: Sequence[str], reading: Reading, correlations: Mapping[str, float], what: str) -> None:
    """File standard columns of one unit; ``correlations`` are with what they should be.

    ``what`` they should be, in words, is empty where the log does not tell.
    """
    unit, evidence, confidence = reading
    unknown = "too little motion for its sign" if what else "nothing in the log tells its sign"
    for name in names:
        agreement = f"correlation {correlations[name]:+.3f} with {what}" if name in correlations else unknown
        draft.settle(name, unit, f"{evidence}; {agreement}", confidence)
        if correlations.get(name, 0.0) < -CLEAR:
            draft.suspect(draft.column(name), agreement)
