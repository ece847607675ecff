"""Name the physical effect that a model misses, from logs: the method of DIAGNOSIS.md, step by step."""

from __future__ import annotations

import time
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from typing import Any

from sym2real.diagnosis.competing import NotTried
from sym2real.diagnosis.constant import find_constants
from sym2real.diagnosis.dependence import find_dependence
from sym2real.diagnosis.features import Region
from sym2real.diagnosis.findings import Finding, applied, findings, rated, told
from sym2real.diagnosis.floor import Floor, floor_of_explained, no_higher_than_reached
from sym2real.diagnosis.groups import groups_of
from sym2real.diagnosis.held_out import Gate, without_harm
from sym2real.diagnosis.ladder import Stage, cut_said, require_step
from sym2real.diagnosis.leftover import Leftover, Rest, find_leftovers, find_misfit
from sym2real.diagnosis.locate import Where, locate
from sym2real.diagnosis.sanity import Fault, with_sensors_of
from sym2real.diagnosis.search import search
from sym2real.diagnosis.select import Selection
from sym2real.diagnosis.separation import with_advice
from sym2real.diagnosis.significance import FEWEST_BLOCKS
from sym2real.diagnosis.stages import Stages
from sym2real.diagnosis.term import Term, propose
from sym2real.diagnosis.verdict import Verdict, summary, verdict
from sym2real.diagnosis.weighing import OnProgress, Weighed, check_and_filter, weigh
from sym2real.plants import MujocoPlant
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset, Trajectory


@dataclass(frozen=True)
class Diagnosis:
    """What was found.

    Args:
        verdict, summary: the answer in a word and in a sentence.
        faults: of the data, undone before the search where the logs tell how.
        findings: effects that are there, in order of importance.
        leftovers: what no effect explains, the strongest first.
        proposal: a term that would explain some of the first, unverified.
        where: regions in which the model fails.
        ladder: errors of the base and of the first k findings, on held-out data.
        floor: errors of a fully explained model.
        held_out: names of the logs that scored the ladder.
        apart: whether these took no part in any fit; else each is scored by the fit of the others.
        gate: whether free runs on them become better by as much as they must.
        seconds: time it took.
        tried: number of hypotheses that competed.
        not_tried: effects that did not compete, and why.
        notes: remarks on data and method.
        misfit: whitened squares per degree of freedom, of the base and of the result; 1 is fully explained.
    """

    verdict: Verdict
    summary: str
    faults: tuple[Fault, ...] = ()
    findings: tuple[Finding, ...] = ()
    leftovers: tuple[Leftover, ...] = ()
    proposal: Term | None = None
    where: tuple[Where, ...] = ()
    ladder: tuple[Stage, ...] = ()
    floor: tuple[Floor, ...] = ()
    held_out: tuple[str, ...] = ()
    apart: bool = False
    gate: Gate = field(default_factory=Gate)
    seconds: float = 0.0
    tried: int = 0
    not_tried: tuple[NotTried, ...] = ()
    notes: tuple[str, ...] = ()
    misfit: tuple[float, float] = field(default=(float("nan"), float("nan")))

    @property
    def leftover(self) -> Leftover | None:
        """The strongest of what is left."""
        return self.leftovers[0] if self.leftovers else None

    @property
    def established(self) -> bool:
        """Whether something was found that held-out predictions bear out."""
        return self.verdict == "EFFECT" and bool(self.findings) and self.gate.passed

    def apply(self, equations: Equations) -> Equations:
        """The equations with every finding in them, and with the sensors that were found wrong.

        What is wrong with how a log is written (a unit, an order of columns, a time stamp) is no part of a model.
        """
        return with_sensors_of(applied(equations, self.findings), self.faults)

    def _leftover(self) -> dict[str, Any] | None:
        """The strongest, with where the push changes in words, and the proposed expression as its term."""
        if self.leftover is None:
            return None
        words, proposed = {**self.leftover.to_dict(), "split": self.leftover.term}, self.proposal
        if proposed is None:
            return {**words, "term": ""}
        return {**words, "term": proposed.expression, "gain": proposed.gain, "verified": False}

    def to_dict(self) -> dict[str, Any]:
        """The object that ``--json`` prints (DESIGN.md, "Names that stay")."""
        return {
            "verdict": self.verdict,
            "summary": self.summary,
            "faults": [fault.to_dict() for fault in self.faults],
            "findings": [finding.to_dict() for finding in self.findings],
            "leftover": self._leftover(),
            "leftovers": [one.to_dict() for one in self.leftovers],
            "where": [one.to_dict() for one in self.where],
            "ladder": [stage.to_dict() for stage in self.ladder],
            "floor": [one.to_dict() for one in self.floor],
            "held_out": list(self.held_out),
            "held_out_apart": self.apart,
            "gate": self.gate.to_dict(),
            "seconds": self.seconds,
            "tried": self.tried,
            "not_tried": [one.to_dict() for one in self.not_tried],
            "notes": list(self.notes),
        }


def diagnose(
    model: Equations,
    data: Dataset | Trajectory,
    plant: MujocoPlant | None = None,
    *,
    calibrate: bool = True,
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
        plant: the robot's plain simulator, to calibrate the base and to try manoeuvres in; without one both are
            skipped. Effects that the model has already (``Equations.effects``) are put into it here.
        calibrate: whether the simulator calibrates the base.
        held_out: logs that score the ladder; by default every log by the fit without it, the last third of a single
            log by the fit to the rest.
        exclude: keys or patterns of effects that are not to be tried.
        horizon: the ladder's longest, in s.
        region: range of every column in the model's training, to say whether it fails inside or outside.
        on_progress: told what is being done.
        finish_on_interrupt: Ctrl-C during the search, or behind it, ends the stage that runs, and the answer is made
            of what is done.

    Raises:
        ShapeError: when no log is long enough, columns differ, or the horizon is no step long.
    """
    require_step(horizon, model.dt)
    started = time.perf_counter()
    weighed = weigh(model, data, plant, calibrate=calibrate, exclude=exclude, on_progress=on_progress)
    stages = Stages(on_progress, finish=finish_on_interrupt)
    selection = Selection(weighed.problems, weighed.tried, weighed.origin, on_progress=on_progress)
    stages.run(f"searching among {len(weighed.tried)} effects", lambda: search(selection))
    finished = not stages.interrupted
    scored = stages.run(
        "scoring on held-out data",
        lambda: _answer(model, weighed, selection, held_out, horizon, finished=finished),
    )
    found = _unscored(weighed, selection) if scored is None else scored
    advised = stages.run(
        "looking for manoeuvres that would tell more",
        lambda: with_advice(found.findings, weighed.model, weighed.whitening, weighed.plant),
    )
    where = stages.run("locating errors", lambda: locate(weighed.model, weighed.checked.data, region))
    return replace(
        found,
        findings=found.findings if advised is None else advised,
        where=where or (),
        notes=(*found.notes, *stages.notes),
        seconds=time.perf_counter() - started,
    )


def _unscored(weighed: Weighed, selection: Selection) -> Diagnosis:
    """What the search has found, where the scoring was interrupted: nothing is established."""
    found, faults = _findings(weighed, selection, {}), weighed.checked.faults
    return Diagnosis(
        verdict="CANNOT_TELL",
        summary=summary("CANNOT_TELL", faults, found, (), gate=Gate(), stages=(), interrupted="the scoring"),
        faults=faults,
        findings=found,
        tried=selection.tried,
        not_tried=weighed.not_tried,
        notes=weighed.notes,
        misfit=_misfit(weighed, selection),
    )


def _findings(weighed: Weighed, selection: Selection, groups: dict[str, tuple[str, ...]]) -> tuple[Finding, ...]:
    if not selection.chosen:
        return ()
    provisional = selection.problems.block_count < FEWEST_BLOCKS
    freedom = selection.problems.whitening.freedom
    found = findings(selection, groups, freedom, provisional, weighed.calibration)
    return told(found, weighed.library, weighed.swing, weighed.checked.data)


def _misfit(weighed: Weighed, selection: Selection) -> tuple[float, float]:
    problems = selection.problems
    base = problems.whitening.loss(problems.problem.residuals(weighed.library.null[None])).sum()
    return float(base) / problems.whitening.freedom, selection.fit.total / problems.whitening.freedom


def _answer(
    model: Equations,
    weighed: Weighed,
    selection: Selection,
    held_out: Dataset | None,
    horizon: float | None,
    *,
    finished: bool,
) -> Diagnosis:
    problems, library, checked = selection.problems, weighed.library, weighed.checked
    freedom = problems.whitening.freedom
    scored = checked.data if held_out is None else check_and_filter(model, held_out).data
    steps, stages = without_harm(library, selection, scored, horizon, same=held_out is None)
    gate = steps.gate(library, scored)
    groups = groups_of(selection)
    found = _findings(weighed, selection, groups)
    rest = Rest.of(problems.problem, weighed.spread, problems.whitening, selection.fit.values)
    own = weighed.calibration
    of_the_base = None if own is None else lambda: Rest.of(own.problem, own.spread, own.whitening, own.origin)
    horizons = steps.horizons(scored, horizon)
    leftovers = find_leftovers(rest, of_the_base)
    leftovers += find_constants(selection, weighed.spread, own, exclude=[one.channel for one in leftovers])
    leftovers = leftovers or find_dependence(selection, weighed.spread, own)
    leftovers = leftovers or find_misfit(selection.fit.total / freedom)
    found = rated(found, passed=gate.passed, leftover=bool(leftovers), calibrated=own is not None and finished)
    floor = floor_of_explained(library, scored, selection.fit.values, problems.whitening, horizons)
    proposal = None
    if leftovers:
        informed = applied(weighed.model, found)
        proposal = propose(informed, checked.data, rest, leftovers[0], problems.whitening)
    answer = verdict(checked.faults, found, leftovers, gate, problems, finished=finished)
    interrupted = "" if finished else "the search"
    return Diagnosis(
        verdict=answer,
        summary=summary(answer, checked.faults, found, leftovers, gate=gate, stages=stages, interrupted=interrupted),
        faults=checked.faults,
        findings=found,
        leftovers=leftovers,
        proposal=proposal,
        ladder=stages,
        floor=no_higher_than_reached(floor, stages),
        held_out=steps.names_of(scored),
        apart=held_out is not None,
        gate=gate,
        tried=selection.tried,
        not_tried=weighed.not_tried,
        notes=(*weighed.notes, *cut_said(horizons, horizon)),
        misfit=_misfit(weighed, selection),
    )
