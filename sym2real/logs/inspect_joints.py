"""Evidence on a model's own columns, those of joints and actuators: units, signs, rates that the log has not."""

from collections.abc import Collection
from itertools import product
from math import log

import numpy as np

from sym2real.layout import Layouts
from sym2real.logs.draft import Confidence, Draft
from sym2real.logs.inspect_motion import FAST, FASTEST
from sym2real.logs.joint_names import Matching
from sym2real.logs.name_words import words_and_unit
from sym2real.logs.of_model import own_units
from sym2real.logs.reading import CLEAR, WEAK, Reading
from sym2real.logs.units import UNITS
from sym2real.vocabulary import LARGEST_PLACE

# Units that a log may have in the place of the model's, the model's first.
OTHER_UNITS = {
    "rad": ("rad", "deg"), "m": ("m", "mm", "cm"), "rad/s": ("rad/s", "deg/s", "rpm"), "m/s": ("m/s", "mm/s", "cm/s"),
}  # fmt: skip
PACES = {"rad": FASTEST, "m": FAST}  # a second, beyond which no place is in the unit
MOVING = 1e-3  # standard deviation of a slope, from which on it says something
SAME = log(1.5)  # units whose factors are closer to each other are not told apart by a ratio


def inspect_joints(draft: Draft, matching: Matching, layouts: Layouts, endless: Collection[str]) -> None:
    """Units of what was matched, and what could not be: rates from coordinates, the rest as lines to fill in.

    Args:
        draft: of the logs.
        matching: of their names.
        layouts: of the model.
        endless: joints without stops within a turn, or some metres.
    """
    wanted, rates = own_units(layouts), layouts.state.rates
    unknown = [column for column in layouts.action if column not in {*wanted, *draft.assignment.columns}]
    left = dict.fromkeys(unknown, "no column is called like it") | matching.open
    units: dict[str, Reading] = {}
    for joint, rate in rates.items():
        if joint not in matching.pairs or rate not in matching.pairs:
            continue
        slopes = draft.rows.slopes(draft.values(joint))
        if draft.rows.spread(slopes) > MOVING:
            agreement = draft.rows.correlation(draft.values(rate), slopes)
            if abs(agreement) < WEAK:
                source = draft.assignment.columns.pop(rate)
                left[rate] = f"{source!r} does not move like the slope of {joint}, correlation {agreement:+.2f}"
                continue
            share = draft.rows.ratio(draft.values(rate), slopes)
            units |= _pair(draft, (joint, rate), (wanted[joint], wanted[rate]), share, joint in endless)
            if agreement < -CLEAR:
                draft.suspect(matching.pairs[rate].source, f"correlation {agreement:+.2f} with the slope of {joint}")
    for column, match in matching.pairs.items():
        if column in left:
            continue
        unit, evidence, confidence = units.get(column) or _alone(draft, column, wanted[column], column in endless)
        draft.units[column] = "" if unit == wanted[column] else unit
        draft.add(match.source, column, unit, f"{match.evidence}; {evidence}", confidence if match.sure else "guess")
    _what_is_left(draft, left, layouts.action.units | wanted, {rate: joint for joint, rate in rates.items()})


def _pair(
    draft: Draft, columns: tuple[str, str], wanted: tuple[str, str], share: float, endless: bool
) -> dict[str, Reading]:
    """Units of a coordinate and its rate that fit each other; of those that fit alike the likelier coordinate's."""
    named = [_named(draft.column(column), unit) for column, unit in zip(columns, wanted, strict=True)]
    options = product(*((name,) if name else OTHER_UNITS[unit] for name, unit in zip(named, wanted, strict=True)))
    misfit = {(p, r): abs(log(share * UNITS[r][1] / UNITS[p][1])) for p, r in options}
    alike = [pair for pair, off in misfit.items() if off < min(misfit.values()) + SAME]
    size, large, far = _size(draft, columns[0], wanted[0], endless)
    chosen = next((pair for pair in alike if (pair[0] != wanted[0]) == large), alike[0])
    evidence = f"the rate moves {share:.3g} times as much as the slope of the coordinate, {size}"
    sure: Confidence = "certain" if len({pair[0] for pair in alike}) == 1 or large else "likely"
    decided: Confidence = "guess" if far else sure
    return {
        column: (unit, "the name says its unit", "certain") if name else (unit, evidence, decided)
        for column, unit, name in zip(columns, chosen, named, strict=True)
    }


def _size(draft: Draft, column: str, wanted: str, endless: bool) -> tuple[str, bool, bool]:
    """How large a place is, in words; whether that is beyond the model's unit, or only far.

    A joint without stops may have gone any way, but not at any speed.
    """
    values = draft.values(column)
    size = float(np.abs(values).max())
    beyond = wanted in LARGEST_PLACE and size > LARGEST_PLACE[wanted]
    far = beyond and endless and float(np.percentile(np.abs(draft.rows.slopes(values)), 95)) <= PACES[wanted]
    words = f"up to {size:.4g}" + f" (in {wanted} it goes as far as it may, without stops)" * far
    return words, beyond and not far, far


def _named(source: str, wanted: str) -> str:
    """The unit in a column's name, of the kind that the model has; of a rate a second is understood."""
    _, unit = words_and_unit(source)
    return next((name for name in (unit, f"{unit}/s") if UNITS.get(name, ("",))[0] == wanted), "")


def _alone(draft: Draft, column: str, wanted: str, endless: bool) -> Reading:
    if named := _named(draft.column(column), wanted):
        return named, "the name says its unit", "certain"
    size, large, far = _size(draft, column, wanted, endless)
    if large:
        return OTHER_UNITS[wanted][1], size, "certain"
    return wanted, f"{size}; in the model's unit, which the log cannot tell", "guess" if far else "likely"


def _what_is_left(draft: Draft, left: dict[str, str], wanted: dict[str, str], places: dict[str, str]) -> None:
    derived = [column for column in left if column in places and draft.has(places[column])]
    if derived:
        draft.derived.append("rate")
    for column, why in left.items():
        if column in derived:
            evidence = f"the log has none ({why}): slopes of {places[column]}"
            draft.add("", column, wanted[column], evidence, "certain")
        else:
            draft.add("", f"{column} is missing", wanted[column], why, "unknown")
            draft.comment("columns", f'{column} = "…"  # {wanted[column]}: {why}')
