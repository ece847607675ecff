"""Name the physical effect that a model misses, from logs: the method of DIAGNOSIS.md, step by step."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import torch

from sym2real.diagnosis.candidates import Candidate
from sym2real.diagnosis.constant import find_constant
from sym2real.diagnosis.deviations import parameter_set
from sym2real.diagnosis.features import Region
from sym2real.diagnosis.findings import Finding, findings
from sym2real.diagnosis.floor import Floor, floor_of_explained
from sym2real.diagnosis.groups import groups_of
from sym2real.diagnosis.importance import by_importance
from sym2real.diagnosis.ladder import Stage, horizons_for, ladder
from sym2real.diagnosis.leftover import Leftover, Rest, find_leftover
from sym2real.diagnosis.library import Library
from sym2real.diagnosis.locate import Where, locate
from sym2real.diagnosis.sanity import Fault
from sym2real.diagnosis.search import search
from sym2real.diagnosis.select import Selection
from sym2real.diagnosis.significance import FEWEST_BLOCKS
from sym2real.diagnosis.term import Term, propose
from sym2real.diagnosis.verdict import Verdict, makes_worse, summary, verdict
from sym2real.diagnosis.weighing import OnProgress, Weighed, check_and_filter, weigh
from sym2real.effects import compose, effect
from sym2real.plants import MujocoPlant
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset, Trajectory


@dataclass(frozen=True)
class Diagnosis:
    """What was found.

    Args:
        verdict, summary: the answer in a word and in a sentence.
        faults: of the data, undone before the search.
        findings: effects that are there, in order of importance.
        leftover: what no effect explains.
        proposal: a term that would explain some of it, unverified.
        where: regions in which the model fails.
        ladder: errors of the base and of the first k findings, on held-out data.
        floor: errors of a fully explained model.
        held_out: names of the logs that scored the ladder.
        seconds: time it took.
        tried: number of hypotheses that competed.
        notes: remarks on data and method.
        misfit: whitened squares per degree of freedom, of the base and of the result; 1 is fully explained.
    """

    verdict: Verdict
    summary: str
    faults: tuple[Fault, ...] = ()
    findings: tuple[Finding, ...] = ()
    leftover: Leftover | None = None
    proposal: Term | None = None
    where: tuple[Where, ...] = ()
    ladder: tuple[Stage, ...] = ()
    floor: tuple[Floor, ...] = ()
    held_out: tuple[str, ...] = ()
    seconds: float = 0.0
    tried: int = 0
    notes: tuple[str, ...] = ()
    misfit: tuple[float, float] = field(default=(float("nan"), float("nan")))

    def apply(self, equations: Equations) -> Equations:
        """The equations with every finding in them."""
        for one in self.findings:
            equations = one.bound(equations)
        return compose(equations, [(effect(one.effect, equations), one.values) for one in self.findings])

    def _leftover(self, leftover: Leftover) -> dict[str, Any]:
        """With the proposed expression as its term, and where the push changes in words."""
        words = leftover.to_dict()
        if self.proposal is None:
            return {**words, "split": leftover.term, "term": ""}
        proposed = self.proposal
        return {**words, "split": leftover.term, "term": proposed.expression, "gain": proposed.gain, "verified": False}

    def to_dict(self) -> dict[str, Any]:
        """The object that ``--json`` prints (DESIGN.md, "Names that stay")."""
        return {
            "verdict": self.verdict,
            "summary": self.summary,
            "faults": [fault.to_dict() for fault in self.faults],
            "findings": [finding.to_dict() for finding in self.findings],
            "leftover": None if self.leftover is None else self._leftover(self.leftover),
            "where": [one.to_dict() for one in self.where],
            "ladder": [stage.to_dict() for stage in self.ladder],
            "floor": [one.to_dict() for one in self.floor],
            "held_out": list(self.held_out),
            "seconds": self.seconds,
            "tried": self.tried,
            "notes": list(self.notes),
        }


def diagnose(
    model: Equations,
    data: Dataset | Trajectory,
    plant: MujocoPlant | None = None,
    *,
    held_out: Dataset | None = None,
    exclude: Collection[str] = (),
    horizon: float | None = None,
    region: Region | None = None,
    on_progress: OnProgress = lambda _: None,
    finish_on_interrupt: bool = False,
) -> Diagnosis:
    """Find the effects that a model misses.

    Args:
        model: the base's equations.
        data: logs with the model's columns and time step.
        plant: the plain simulator that the base was learned from, to calibrate it; without one that step is skipped.
        held_out: logs that score the ladder; by default every log by the fit without it.
        exclude: keys or patterns of effects that are not to be tried.
        horizon: the ladder's longest, in s.
        region: range of every column in the model's training, to say whether it fails inside or outside.
        on_progress: told what is being done.
        finish_on_interrupt: Ctrl-C during the search ends it, and the answer is what was found until then.

    Raises:
        ShapeError: when no log is long enough, or columns differ.
    """
    started = time.perf_counter()
    weighed = weigh(model, data, plant, exclude=exclude, on_progress=on_progress)
    on_progress(f"searching among {len(weighed.tried)} effects")
    selection = Selection(weighed.problems, weighed.tried, weighed.origin, on_progress=on_progress)
    try:
        search(selection)
    except KeyboardInterrupt:
        if not finish_on_interrupt:
            raise
        weighed = replace(weighed, notes=(*weighed.notes, "interrupted: the search was not finished"))
    on_progress("scoring on held-out data")
    found = _answer(model, weighed, selection, held_out, horizon)
    on_progress("locating errors")
    where = locate(weighed.model, weighed.checked.data, region)
    return replace(found, where=where, seconds=time.perf_counter() - started)


def _answer(
    model: Equations, weighed: Weighed, selection: Selection, held_out: Dataset | None, horizon: float | None
) -> Diagnosis:
    problems, library, checked = selection.problems, weighed.library, weighed.checked
    freedom = problems.whitening.freedom
    scored = checked.data if held_out is None else check_and_filter(model, held_out).data
    horizons = horizons_for(scored, horizon)
    stages = tuple(_gated(library, selection, scored, horizons, same=held_out is None))
    groups = groups_of(selection)
    provisional = problems.block_count < FEWEST_BLOCKS
    found = tuple(findings(selection, groups, freedom, provisional)) if selection.chosen else ()
    rest = Rest.of(problems.problem, weighed.spread, problems.whitening, selection.fit.values)
    own = weighed.calibration
    of_the_base = None if own is None else lambda: Rest.of(own.problem, own.spread, own.whitening, own.origin)
    leftover = find_leftover(rest, of_the_base) or find_constant(selection, weighed.spread, own)
    proposal = None
    if leftover is not None:
        informed = compose(weighed.model, [(effect(one.effect, weighed.model), one.values) for one in found])
        proposal = propose(informed, checked.data, rest, leftover, problems.whitening)
    base = float(problems.whitening.loss(problems.problem.residuals(library.null[None])).sum())
    answer = verdict(checked.faults, found, leftover, problems)
    return Diagnosis(
        verdict=answer,
        summary=summary(answer, checked.faults, found, leftover, stages),
        faults=checked.faults,
        findings=found,
        leftover=leftover,
        proposal=proposal,
        ladder=stages,
        floor=floor_of_explained(library, scored, selection.fit.values, problems.whitening, horizons),
        held_out=tuple(trajectory.name for trajectory in scored),
        tried=selection.tried,
        notes=weighed.notes,
        misfit=(base / freedom, selection.fit.total / freedom),
    )


def _gated(
    library: Library, selection: Selection, data: Dataset, horizons: Sequence[float], *, same: bool
) -> list[Stage]:
    """The ladder, after every finding at its end that makes held-out predictions worse has been dropped."""
    while True:
        stages, last = ladder_of(library, selection, data, horizons, same)
        if last is None or not makes_worse(stages[-2:]):
            return stages
        selection.put(*selection.without(last))


def ladder_of(
    library: Library, selection: Selection, data: Dataset, horizons: Sequence[float], same: bool
) -> tuple[list[Stage], Candidate | None]:
    """Base and first k findings, each log by parameters that it took no part in where the logs are the fit's own.

    Also the last finding.
    """
    stages = [("base", library.null[None])]
    done: list[Candidate] = []
    for one, fit in by_importance(selection):
        done.append(one)
        steps = _fold_steps(selection, fit) if same else [torch.zeros(len(fit.whole), dtype=torch.float64)]
        sets = [parameter_set(selection, done, selection.problems.moved(fit, step)) for step in steps]
        stages.append((f"+ {one.name}", torch.stack(sets)))
    fold_of = _fold_of_log(selection) if same else None
    return ladder(library, data, stages, fold_of, horizons), done[-1] if done else None


def _fold_of_log(selection: Selection) -> np.ndarray:
    log = selection.problems.problem.segments.log
    count = len(selection.problems.problem.data)
    return np.array([int((log[log <= index]).size and np.unique(log[log <= index]).size - 1) for index in range(count)])


def _fold_steps(selection: Selection, fit: Any) -> list[torch.Tensor]:
    """Per log, the step from the fit of all logs to that of the others."""
    log = torch.as_tensor(selection.problems.problem.segments.log)
    steps = []
    for index in log.unique():
        rest = log != index
        if not rest.any():
            steps.append(torch.zeros(len(fit.whole), dtype=torch.float64))
            continue
        steps.append(selection.problems.best_step(fit.of_segments(rest)))
    return steps
