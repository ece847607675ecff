"""What remains? What no effect explains, what was not tested, and remarks on data and method."""

import math

from sym2real.diagnosis import Comparison, Diagnosis
from sym2real.diagnosis.predict.competitors import not_tried_said
from sym2real.report.html.page import Lines, Part, Section
from sym2real.report.html.sentences import sentences
from sym2real.report.tables import number

QUESTION = "What remains?"


def remaining(comparison: Comparison, found: Diagnosis | None) -> Section:
    """Section of what nobody has explained, and of what to know about the data.

    Args:
        comparison: of the model that is given.
        found: its diagnosis, if there is one.
    """
    parts: list[Part] = [] if found is None else _left_over(found)
    if comparison.residuals is not None and comparison.residuals.lines():
        parts.append(Lines("One step ahead", sentences(comparison.residuals.lines())))
    if comparison.data is not None:
        parts.append(Lines("The data", sentences(comparison.data.lines())))
    remarks = list(dict.fromkeys([*(found.notes if found else ()), *comparison.notes]))
    if remarks:
        parts.append(Lines("Remarks", sentences(remarks)))
    if found is not None and found.not_tried:
        parts.append(Lines("Not tested", sentences(not_tried_said(found.not_tried))))
    return Section("remaining", QUESTION, parts)


def _left_over(found: Diagnosis) -> list[Part]:
    lines = [f"{leftover.statement} ({leftover.measure}): {leftover.term}" for leftover in found.leftovers]
    if found.proposal is not None:
        term = found.proposal
        lines.append(
            f"proposed but unverified: {term.expression} along {term.channel} lowers the whitened loss of pieces left "
            f"out by {100 * term.gain:.1f} %"
        )
    base, explained = found.misfit
    if not math.isnan(base):
        lines.append(f"misfit per degree of freedom {number(base)} → {number(explained)}; 1 is fully explained")
    return [Lines("Left over", sentences(lines or ["nothing that these logs would show"]))]
