"""Which of several logs are in other units than most of them: as when one day's recorder was set otherwise."""

from collections import Counter
from collections.abc import Sequence
from itertools import chain
from math import log

import numpy as np

from sym2real.logs.draft import Draft
from sym2real.logs.units import UNITS

Column = tuple[str, str]  # of the log, and what it means


def in_other_units(alone: Sequence[Draft]) -> dict[int, dict[Column, tuple[str, str]]]:
    """Place of every log that is surely in other units than most, with each such column, its unit and the usual one.

    Its numbers are larger, or smaller, by about as much: a log that moves most may be the only one that tells a unit.

    Args:
        alone: what each log by itself seems to hold.
    """
    findings = [{(own.column, own.meaning): own for own in draft.findings if own.unit in UNITS} for draft in alone]
    counts: dict[Column, Counter[str]] = {}
    for column, finding in chain.from_iterable(of_log.items() for of_log in findings):
        counts.setdefault(column, Counter())[finding.unit] += 1
    odd: dict[int, dict[Column, tuple[str, str]]] = {}
    for column, count in counts.items():
        ((usual, many),) = count.most_common(1)
        spreads = [float(np.nanstd(draft.tables[0].columns[column[0]])) for draft in alone] if len(count) > 1 else []
        for place, spread in enumerate(spreads if 2 * many > len(alone) else []):
            own = findings[place].get(column)
            sure = own is not None and own.confidence == "certain" and UNITS[own.unit][0] == UNITS[usual][0]
            if own and sure and own.unit != usual and _as_large(spread / (np.median(spreads) or 1.0), own.unit, usual):
                odd.setdefault(place, {})[column] = own.unit, usual
    return odd if 2 * len(odd) < len(alone) else {}


def _as_large(larger: float, unit: str, usual: str) -> bool:
    """Whether numbers are rather larger by as much as those in a unit are than as large as in the usual one."""
    return larger > 0.0 and abs(log(larger * UNITS[unit][1] / UNITS[usual][1])) < abs(log(larger))
