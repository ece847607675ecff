"""What was found, scored: ladder and gate on held-out data, values with intervals, the floor of errors."""

from __future__ import annotations

from dataclasses import dataclass

from sym2real.diagnosis.errors.floor import Floor, floor_of_explained, no_higher_than_reached
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.diagnosis.estimate.significance import FEWEST_BLOCKS
from sym2real.diagnosis.score.finding import Finding, findings, told
from sym2real.diagnosis.score.held_out import Gate, Steps, without_harm
from sym2real.diagnosis.search.groups import groups_of
from sym2real.diagnosis.search.growing import Found


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
    steps, stages = without_harm(library, selection, logs, question.horizon, same=question.held_out is None)
    gate = steps.gate(library, logs)
    groups = groups_of(selection)
    horizons = steps.horizons(logs, question.horizon)
    floor = floor_of_explained(library, logs, selection.fit.values, prepared.whitening, horizons)
    return Scored(
        found,
        steps,
        stages,
        gate,
        findings_of(found, groups),
        horizons,
        no_higher_than_reached(floor, stages),
    )


def findings_of(found: Found, groups: dict[str, tuple[str, ...]]) -> tuple[Finding, ...]:
    """Values of what was found; groups by name of a candidate, effects that the data cannot tell from it."""
    prepared, selection = found.prepared, found.selection
    if not selection.chosen:
        return ()
    provisional = selection.problems.block_count < FEWEST_BLOCKS
    freedom = selection.problems.whitening.freedom
    values = findings(selection, groups, freedom, provisional, prepared.calibration)
    return told(values, prepared.library, prepared.swing, prepared.checked.data)
