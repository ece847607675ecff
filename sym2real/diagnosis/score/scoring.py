"""What was found, scored: ladder and gate on held-out data, values with intervals, the floor of errors."""

from __future__ import annotations

from dataclasses import dataclass

from sym2real.diagnosis.errors.floor import Floor, floor_of_explained, no_higher_than_reached
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.diagnosis.score.finding import Finding, findings, told
from sym2real.diagnosis.score.held_out import Gate, Steps
from sym2real.diagnosis.search.groups import groups_of
from sym2real.diagnosis.search.growing import Found
from sym2real.diagnosis.search.near import Near


@dataclass(frozen=True, eq=False)
class Scored:
    """Findings and how they do on data that took no part in their fit.

    Args:
        found: the search's result.
        steps: the models of the ladder.
        stages: the ladder.
        gate: free runs of the first and the last of them.
        findings: effects that are there, in order of importance.
        horizons: of the ladder (s).
        floor: errors of a fully explained model.
    """

    found: Found
    steps: Steps
    stages: tuple[Stage, ...]
    gate: Gate
    findings: tuple[Finding, ...]
    horizons: tuple[float, ...]
    floor: tuple[Floor, ...]


def score(found: Found) -> Scored:
    """Errors of the base and of what was found, on logs that were kept aside or that each fit left out."""
    prepared, selection = found.prepared, found.selection
    library, logs, question = prepared.library, prepared.scored, prepared.question
    steps = Steps.of(library, selection, same=question.held_out is None)
    horizons = steps.horizons(logs, question.horizon)
    stages, gate = steps.ladder(library, logs, horizons), steps.gate(library, logs)
    floor = floor_of_explained(library, logs, selection.fit.values, prepared.whitening, horizons)
    return Scored(
        found,
        steps,
        stages,
        gate,
        findings_of(found, Near.of(selection)),
        horizons,
        no_higher_than_reached(floor, stages),
    )


def findings_of(found: Found, near: Near | None = None) -> tuple[Finding, ...]:
    """Values of what was found, with what else would do in its place where that is known."""
    prepared = found.prepared
    groups = {} if near is None else groups_of(near)
    values = findings(found.selection, near, groups, prepared.calibration) if found.selection.chosen else []
    return told(values, prepared.library, prepared.swing, prepared.checked.data)
