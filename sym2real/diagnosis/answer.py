"""What a diagnosis says: verdict, faults, findings, what is left, and the errors that bear it out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sym2real.dataset import Logs
from sym2real.diagnosis.conclusion import Parts, Verdict, verdict
from sym2real.diagnosis.errors.floor import Floor
from sym2real.diagnosis.errors.regions import Where
from sym2real.diagnosis.errors.rungs import Rung, cut_notes
from sym2real.diagnosis.faults.fault import Fault, with_sensors_of
from sym2real.diagnosis.predict.competitors import NotTested
from sym2real.diagnosis.score.finding import Finding, Scored, applied, findings_of
from sym2real.diagnosis.score.held_out import Gate
from sym2real.diagnosis.score.prediction_refit import PredictionRefit
from sym2real.diagnosis.search.beam import SearchResult
from sym2real.diagnosis.unexplained.explaining import disturbance_notes
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.diagnosis.unexplained.odd_pieces import odd_pieces_notes
from sym2real.diagnosis.unexplained.term import Term
from sym2real.json_objects import fields_of
from sym2real.symbolic import Equations
from sym2real.upward import upward

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Diagnosis:
    """What was found.

    Args:
        verdict, summary: the answer in a word and in a sentence.
        faults: of the data, undone before the search where the logs tell how.
        findings: effects that are there, in order of importance.
        leftovers: what no effect explains, the strongest of what matters first.
        suspects: where nothing was found, effects of which each would explain nearly all that is left, and that part of
            it; too few independent pieces of the logs tell of them.
        proposal: a term that would explain some of the first, unverified.
        where: regions in which the model fails.
        ladder: errors of the base and of the first k findings, on held-out data.
        floor: errors of a fully explained model.
        held_out: names of the logs that scored the ladder.
        apart: whether these took no part in any fit; else each is scored by the fit of the others.
        gate: whether free runs on them become better by as much as they must.
        prediction: values that predict best, where something is established.
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
    suspects: Mapping[str, float] = field(default_factory=dict)
    proposal: Term | None = None
    where: tuple[Where, ...] = ()
    ladder: tuple[Rung, ...] = ()
    floor: tuple[Floor, ...] = ()
    held_out: tuple[str, ...] = ()
    apart: bool = False
    gate: Gate = field(default_factory=Gate)
    prediction: PredictionRefit | None = None
    seconds: float = 0.0
    tried: int = 0
    not_tried: tuple[NotTested, ...] = ()
    notes: tuple[str, ...] = ()
    misfit: tuple[float, float] = field(default=(float("nan"), float("nan")))

    def __repr__(self) -> str:
        return f"<Diagnosis {self.verdict}: {self.summary}>"

    def __str__(self) -> str:
        """The answer in short: findings with values and intervals, and what these logs cannot tell."""
        return str(upward("diagnosis_text")(self))

    def plot(self) -> Figure:
        """Held-out error over the horizon, one effect after the other: a figure of matplotlib.

        Raises:
            ModelError: where nothing was scored.
        """
        return upward("ladder_plot")(self)

    def report(self, equations: Equations, logs: Logs, file: str | Path) -> Path:
        """Write all of it as one HTML file that works offline, with effects to switch on and off; the file.

        Args:
            equations: the model that was diagnosed.
            logs: those of the diagnosis.
            file: what to write.
        """
        return upward("write_diagnosis_page")(self, equations, logs, file)

    def _repr_html_(self) -> str:
        return str(upward("diagnosis_html")(self))

    @property
    def leftover(self) -> Leftover | None:
        """The strongest of what is left, where it matters."""
        return next((leftover for leftover in self.leftovers if leftover.matters), None)

    @property
    def established(self) -> bool:
        """Whether something was found that held-out predictions bear out."""
        return self.verdict == "EFFECT" and bool(self.findings) and self.gate.passed

    @property
    def predicts_better(self) -> bool:
        """Whether other values than those of the findings predict logs better that each fit left out."""
        return self.prediction is not None and self.prediction.kept

    def apply(self, equations: Equations, *, for_prediction: bool = False) -> Equations:
        """The equations with every finding in them, and with the sensors that were found wrong.

        What is wrong with how a log is written (a unit, an order of columns, a time stamp) is no part of a model, nor
        is what may be commands that changed between its rows.

        Args:
            equations: the base.
            for_prediction: with the values that predict best, where the refit found better ones, in place of those that
                are most likely.
        """
        refit, findings = self.prediction, self.findings
        if for_prediction and refit is not None and refit.kept:
            findings = refit.of(findings)
        sure = [finding for finding in findings if not finding.doubtful]
        return with_sensors_of(applied(equations, sure), self.faults)

    def _leftover(self) -> dict[str, Any] | None:
        """The strongest, with where the disturbance changes in words, and the proposed expression as its term."""
        if self.leftover is None:
            return None
        words, proposed = {**fields_of(self.leftover), "split": self.leftover.term}, self.proposal
        if proposed is None:
            return {**words, "term": ""}
        return {**words, "term": proposed.expression, "gain": proposed.gain, "verified": False}

    def to_dict(self) -> dict[str, Any]:
        """The object that ``--json`` prints (docs/method.md, "Answers as files")."""
        known = fields_of(self, without=("proposal", "apart", "misfit"))
        return {**known, "leftover": self._leftover(), "held_out_apart": self.apart}


def conclude(scored: Scored, leftovers: tuple[Leftover, ...], proposal: Term | None) -> Diagnosis:
    """The answer that findings and held-out errors, and what is left beside them, make."""
    findings, result, prepared = scored.findings, scored.result, scored.result.prepared
    suspects = {} if findings else result.suspects()
    parts = Parts(prepared.checked.faults, findings, leftovers, scored.gate, scored.stages, scored.floor, suspects)
    of_search = _of_search(result)
    answer = verdict(parts, prepared.problems, finished=result.finished, misfit=of_search["misfit"])
    beside = (*odd_pieces_notes(prepared.problems), *disturbance_notes(scored.floor))
    return Diagnosis(
        verdict=answer,
        summary=upward("summary")(answer, parts, interrupted="" if result.finished else "the search"),
        **vars(parts),
        proposal=proposal,
        held_out=scored.steps.names,
        apart=prepared.question.held_out is not None,
        notes=(*result.notes, *beside, *cut_notes(scored.horizons, prepared.question.horizon)),
        **of_search,
    )


def unscored(result: SearchResult) -> Diagnosis:
    """What the search has found, where the scoring was interrupted: nothing is established."""
    parts = Parts(result.prepared.checked.faults, findings_of(result))
    sentence: str = upward("summary")("CANNOT_TELL", parts, interrupted="the scoring")
    return Diagnosis("CANNOT_TELL", sentence, **vars(parts), notes=result.notes, **_of_search(result))


def _of_search(result: SearchResult) -> dict[str, Any]:
    """What an answer says of the search, scored or not."""
    problems, values = result.prepared.problems, (result.prepared.library.null, result.selection.fit.values)
    base, informed = (problems.whitening.misfit(problems.problem.residuals(each[None])[0]) for each in values)
    return {"tried": result.selection.tested, "not_tried": result.prepared.not_tested, "misfit": (base, informed)}
