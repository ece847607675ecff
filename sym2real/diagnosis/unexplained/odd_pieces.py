"""Pieces of the logs that are so unlike all others that fits hardly heed them, and whether they lie in one place.

Where a mast is struck, a stop is met or a wheel lifts, a model fails in a few pieces by far. Each alone is an accident,
and robust weights leave it aside. Together they are none where they all reach further than the other pieces do, beyond
chance by ranks: H. Mann, D. Whitney, "On a test of whether one of two random variables is stochastically larger than
the other", Ann. Math. Statist. 18 (1947) 50–60.
"""

import numpy as np
from scipy.stats import mannwhitneyu
from torch import Tensor

from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.features import part_of_changes
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.logs.conditions import signed_features
from sym2real.trajectory import Array

# Pieces that a note names.
LISTED = 3


def odd_pieces(problems: Problems) -> list[int]:
    """Pieces so unlike all others that fits hardly heed them, by their M-estimator weights; the least alike first.

    Where they are most, what is missing from the model is in nearly all of them.
    """
    trust = problems.whitening.trust.numpy()
    return [int(piece) for piece in np.argsort(trust, kind="stable") if trust[piece] < SETTINGS.mostly]


def odd_pieces_notes(problems: Problems) -> tuple[str, ...]:
    """How many pieces are unlike all others, and where the least alike are."""
    segments, odd = problems.problem.segments, odd_pieces(problems)
    first, last = (rows * problems.data.dt for rows in (segments.row, segments.row + segments.length - 1))
    places = [f"{problems.data[segments.log[k]].name} ({first[k]:.1f} to {last[k]:.1f} s)" for k in odd[:LISTED]]
    some = f"{len(odd)} of {len(segments)} pieces, in {len(np.unique(segments.log[odd]))} of {problems.log_count} logs,"
    return (f"{some} are unlike all others and hardly count: look at {', '.join(places)}",) if places else ()


def find_where_odd(problems: Problems, left: Tensor) -> tuple[Leftover, ...]:
    """The end of a feature that odd pieces reach and others do not, if there is one.

    Args:
        problems: the logs.
        left: residuals of what was found ``# (S, R)``.
    """
    pieces = odd_pieces(problems)
    odd = np.isin(np.arange(len(left)), pieces)
    if not 0 < len(pieces) <= SETTINGS.mostly * len(odd):
        return ()
    reached = _reached(problems)
    tests = {end: mannwhitneyu(values[odd], values[~odd], alternative="greater") for end, values in reached.items()}
    end = min(tests, key=lambda end: (tests[end].pvalue, -tests[end].statistic))
    apart = tests[end].statistic >= SETTINGS.nearly * len(pieces) * (len(odd) - len(pieces))
    if not apart or tests[end].pvalue >= SETTINGS.false_alarms_of_each(len(tests)):
        return ()
    (name, sign), from_on, squares = end, reached[end][odd].min(), problems.whitening.squares(left)
    where = f"{name} is {'above' if sign > 0 else 'below'} {sign * from_on:.3g}"
    share, words = float(squares[pieces].sum() / squares.sum()), f"{len(pieces)} of {len(odd)} pieces"
    return (Leftover(where, "", share, words, motion=part_of_changes(problems.problem.segments, left)),)


def _reached(problems: Problems) -> dict[tuple[str, int], Array]:
    """Per feature and end of it, how far every piece goes ``# (S,)``."""
    tables, segments = [*map(signed_features, problems.data)], problems.problem.segments
    rows = [(log, slice(first, first + segments.length)) for log, first in zip(segments.log, segments.row, strict=True)]
    ends = ((name, sign) for name in tables[0] for sign in (1, -1))
    return {(name, sign): np.array([(sign * tables[log][name][own]).max() for log, own in rows]) for name, sign in ends}
