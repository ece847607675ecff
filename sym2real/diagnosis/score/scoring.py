"""What was found, scored: ladder and gate on held-out data, values with intervals, the floor of errors."""

from __future__ import annotations

from dataclasses import dataclass, replace

from sym2real.diagnosis.errors.floor import Floor, floor_of_explained, no_higher_than_reached
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.diagnosis.score.finding import Finding, findings, with_details
from sym2real.diagnosis.score.held_out import Gate, Steps
from sym2real.diagnosis.search.beam import SearchResult
from sym2real.diagnosis.search.groups import groups_of
from sym2real.diagnosis.search.near import Near


@dataclass(frozen=True, eq=False)
class Scored:
    """Findings and how they do on data that took no part in their fit.

    Args:
        result: of the search.
        steps: the models of the ladder.
        stages: the ladder.
        gate: free runs of the first and the last of them.
        findings: effects that are there, in order of importance.
        horizons: of the ladder (s).
        floor: errors of a fully explained model.
    """

    result: SearchResult
    steps: Steps
    stages: tuple[Stage, ...]
    gate: Gate
    findings: tuple[Finding, ...]
    horizons: tuple[float, ...]
    floor: tuple[Floor, ...]


def score(result: SearchResult) -> Scored:
    """Errors of the base and of what was found, on logs that were kept aside or that each fit left out."""
    prepared, selection = result.prepared, result.selection
    library, logs, question = prepared.library, prepared.scored, prepared.question
    steps = Steps.of(library, selection, same=question.held_out is None)
    horizons = steps.horizons(logs, question.horizon)
    stages, gate = steps.ladder(library, logs, horizons), steps.gate(library, logs)
    floor = floor_of_explained(library, logs, selection.fit.values, prepared.whitening, horizons)
    found = findings_of(result, Near.of(selection))
    return Scored(result, steps, stages, gate, found, horizons, no_higher_than_reached(floor, stages))


def findings_of(result: SearchResult, near: Near | None = None) -> tuple[Finding, ...]:
    """Values of what was found, with what else would do in its place where that is known."""
    prepared = result.prepared
    groups = {} if near is None else groups_of(near)
    values = findings(result.selection, near, groups, prepared.calibration) if result.selection.chosen else []
    small = {key for candidate in result.needed.small for key in candidate.keys}
    values = [replace(finding, small=finding.effect in small) for finding in values]
    return with_details(values, prepared.library, prepared.swing, prepared.checked.data)
