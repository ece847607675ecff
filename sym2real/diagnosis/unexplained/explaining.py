"""What the findings do not explain: disturbances, constants, dependences, a misfit; and a term for the strongest."""

from __future__ import annotations

from dataclasses import dataclass

from sym2real.diagnosis.estimate.weighing import Prepared
from sym2real.diagnosis.score.finding import applied
from sym2real.diagnosis.score.scoring import Scored
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.unexplained.astray import worse_than_nothing
from sym2real.diagnosis.unexplained.constant import find_constants
from sym2real.diagnosis.unexplained.dependence import find_dependence
from sym2real.diagnosis.unexplained.leftover import Leftover, Rest, find_leftovers, find_misfit
from sym2real.diagnosis.unexplained.motion import part_of_changes
from sym2real.diagnosis.unexplained.term import Term, propose


@dataclass(frozen=True, eq=False)
class Explained:
    """What is left beside the findings.

    Args:
        scored: findings and held-out errors.
        leftovers: what no effect explains, the strongest of what matters first.
        proposal: a term that would explain some of the first, unverified.
    """

    scored: Scored
    leftovers: tuple[Leftover, ...]
    proposal: Term | None


def explain_rest(scored: Scored) -> Explained:
    """What is left beside what was found."""
    result, prepared = scored.result, scored.result.prepared
    selection, spread, problems = result.selection, prepared.spread, prepared.problems
    rest = Rest.of(problems.problem, spread, problems.whitening, selection.fit.values)
    # Commands that no row tells push the robot, and what they did goes with what it then did.
    leftovers = () if prepared.checked.commands_lost else _leftovers(prepared, selection, rest)
    if not (scored.findings or prepared.checked.commands_lost) and not any(leftover.matters for leftover in leftovers):
        leftovers = (*worse_than_nothing(scored), *leftovers)
    unexplained = any(leftover.matters for leftover in leftovers)
    proposal = None
    if unexplained:
        informed = applied(prepared.model, scored.findings)
        proposal = propose(informed, prepared.checked.data, rest, leftovers[0], problems.whitening)
    return Explained(scored, leftovers, proposal)


def _leftovers(prepared: Prepared, selection: Selection, rest: Rest) -> tuple[Leftover, ...]:
    """What no effect explains, the strongest of what matters first."""
    own, problems = prepared.calibration, selection.problems
    of_the_base = None if own is None else lambda: Rest.of(own.problem, own.spread, own.whitening, own.origin)
    leftovers = find_leftovers(rest, of_the_base)
    leftovers += find_constants(selection, prepared.spread, own, exclude=[leftover.channel for leftover in leftovers])
    leftovers = leftovers or find_dependence(selection, prepared.spread, own)
    if not any(leftover.matters for leftover in leftovers):
        errors = problems.problem.residuals(selection.fit.values[None])[0]
        motion = part_of_changes(problems.problem.segments, errors)
        leftovers += find_misfit(selection.fit.total / problems.whitening.freedom, motion)
    return tuple(sorted(leftovers, key=lambda leftover: not leftover.matters))
