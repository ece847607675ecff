"""Evidence on a model's own columns, those of joints and actuators: units, signs, rates that the log has not."""

from __future__ import annotations

from itertools import product
from math import log, pi

from sym2real.layout import Layouts
from sym2real.logs import signals
from sym2real.logs.draft import Confidence, Draft
from sym2real.logs.inspect_attitude import CLEAR, WEAK
from sym2real.logs.joint_names import Matching
from sym2real.logs.name_words import words_and_unit
from sym2real.logs.of_model import own_units
from sym2real.logs.units import UNITS

# Units that a log may have in the place of the model's, the model's first.
OTHER_UNITS = {
    "rad": ("rad", "deg"), "m": ("m", "mm", "cm"), "rad/s": ("rad/s", "deg/s", "rpm"), "m/s": ("m/s", "mm/s", "cm/s"),
}  # fmt: skip
# Beyond these sizes, a turn and a reach of robots on tables and wheels, a coordinate is in another unit.
LARGEST = {"rad": 2 * pi, "m": 5.0}
MOVING = 1e-3  # standard deviation of a slope, from which on it says something
SAME = log(1.5)  # units whose factors are closer to each other are not told apart by a ratio

Said = tuple[str, str, bool]  # a unit, the evidence, and whether that decides


def inspect_joints(draft: Draft, matching: Matching, layouts: Layouts) -> None:
    """Units of what was matched, and what could not be: rates from coordinates, the rest as lines to fill in."""
    wanted, rates = own_units(layouts), layouts.state.rates
    left = dict(matching.open)
    units: dict[str, Said] = {}
    for joint, rate in rates.items():
        if joint in matching.found and rate in matching.found and _moves(draft, joint):
            found = _correlation(draft, joint, rate)
            if abs(found) < WEAK:
                source = draft.assignment.columns.pop(rate)
                left[rate] = f"{source!r} does not move like the slope of {joint}, correlation {found:+.2f}"
                continue
            units |= _pair(draft, (joint, rate), (wanted[joint], wanted[rate]))
            if found < -CLEAR:
                draft.suspect(matching.found[rate].source, f"correlation {found:+.2f} with the slope of {joint}")
    for column, match in matching.found.items():
        if column in left:
            continue
        unit, evidence, sure = units.get(column) or _alone(draft, column, wanted[column])
        draft.units[column] = "" if unit == wanted[column] else unit
        confidence: Confidence = ("certain" if sure else "likely") if match.sure else "guess"
        draft.add(match.source, column, unit, f"{match.evidence}; {evidence}", confidence)
    _what_is_left(draft, left, wanted, {rate: joint for joint, rate in rates.items()})


def _moves(draft: Draft, joint: str) -> bool:
    return signals.spread(signals.slopes(draft.stamps, draft.values(joint))) > MOVING


def _correlation(draft: Draft, joint: str, rate: str) -> float:
    place, speed = (draft.values(column) for column in (joint, rate))
    return signals.correlation(speed, signals.slopes(draft.stamps, place))


def _pair(draft: Draft, columns: tuple[str, str], wanted: tuple[str, str]) -> dict[str, Said]:
    """Units of a coordinate and its rate that fit each other; of those that fit alike the likelier coordinate's."""
    sources = [draft.assignment.columns[column] for column in columns]
    place, speed = (draft.raw(source) for source in sources)
    share = signals.ratio(speed, signals.slopes(draft.stamps, place))
    named = [_named(source, unit) for source, unit in zip(sources, wanted, strict=True)]
    options = product(*((name,) if name else OTHER_UNITS[unit] for name, unit in zip(named, wanted, strict=True)))
    misfit = {(p, r): abs(log(share * UNITS[r][1] / UNITS[p][1])) for p, r in options}
    alike = [pair for pair, off in misfit.items() if off < min(misfit.values()) + SAME]
    large = signals.largest(place) > LARGEST[wanted[0]]
    chosen = next((pair for pair in alike if (pair[0] != wanted[0]) == large), alike[0])
    said = (
        f"the rate moves {share:.3g} times as much as the slope of the coordinate, up to {signals.largest(place):.3g}"
    )
    decided = len({pair[0] for pair in alike}) == 1 or large
    return {
        column: (unit, "the name says its unit" if name else said, bool(name) or decided)
        for column, unit, name in zip(columns, chosen, named, strict=True)
    }


def _named(source: str, wanted: str) -> str:
    """The unit in a column's name, of the kind that the model has; of a rate a second is understood."""
    _, unit = words_and_unit(source)
    return next((name for name in (unit, f"{unit}/s") if UNITS.get(name, ("",))[0] == wanted), "")


def _alone(draft: Draft, column: str, wanted: str) -> Said:
    source = draft.assignment.columns[column]
    if named := _named(source, wanted):
        return named, "the name says its unit", True
    size = signals.largest(draft.raw(source))
    if wanted in LARGEST and size > LARGEST[wanted]:
        return OTHER_UNITS[wanted][1], f"up to {size:.4g}, more than {LARGEST[wanted]:.3g} {wanted}", False
    return wanted, f"up to {size:.4g}; in the model's unit, which the log cannot tell", False


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
