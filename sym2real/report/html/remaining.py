"""What remains? What no effect explains, what was not tested, and remarks on data and method."""

from sym2real.diagnosis import Comparison, Diagnosis
from sym2real.report.diagnosis import leftover_lines, misfit_line, proposal_lines
from sym2real.report.html.page import Lines, Part, Section
from sym2real.report.html.sentences import plain, sentences
from sym2real.report.not_tested import lines_by_reason

QUESTION = "What remains?"


def remaining(comparison: Comparison, diagnosis: Diagnosis | None) -> Section:
    """Section of what nobody has explained, and of what to know about the data.

    Args:
        comparison: of the model that is given.
        diagnosis: its diagnosis, if there is one.
    """
    parts: list[Part] = []
    if diagnosis is not None:
        left = [*leftover_lines(diagnosis.leftovers), *proposal_lines(diagnosis.proposal), misfit_line(diagnosis)]
        parts.append(Lines("Left over", sentences(map(plain, left))))
    if comparison.residuals is not None and comparison.residuals.lines():
        parts.append(Lines("One step ahead", sentences(comparison.residuals.lines())))
    if comparison.data is not None:
        parts.append(Lines("The data", sentences(comparison.data.lines())))
    remarks = list(dict.fromkeys([*(diagnosis.notes if diagnosis else ()), *comparison.notes]))
    if remarks:
        parts.append(Lines("Remarks", sentences(remarks)))
    if diagnosis is not None and diagnosis.not_tried:
        parts.append(Lines("Not tested", sentences(lines_by_reason(diagnosis.not_tried))))
    return Section("remaining", QUESTION, parts)
