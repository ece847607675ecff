"""A physical effect into equations: at values that are known, or as a hypothesis that logs confirm or refuse.

add(base, "added_mass", {"value": 0.005})            "I taped 5 g on it"
add(base, "added_mass", fit=logs)                    how much is it?
try_effect(base, "added_mass", logs)                is it there at all, and what else explains the logs as well?
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping

from sym2real.diagnosis.design.separation import with_advice
from sym2real.diagnosis.errors.floor import floor_of_explained, no_higher_than_reached
from sym2real.diagnosis.errors.rungs import cut_said
from sym2real.diagnosis.estimate.calibrate import Calibration
from sym2real.diagnosis.estimate.weighing import Prepared
from sym2real.diagnosis.faults.checking import Question
from sym2real.diagnosis.pipeline import prepare
from sym2real.diagnosis.predict.candidate import Candidate, candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.score.finding import Finding, findings
from sym2real.diagnosis.score.held_out import Steps
from sym2real.diagnosis.score.tried import Rival, Tried
from sym2real.diagnosis.search.groups import as_good
from sym2real.diagnosis.search.select import GAIN, Selection
from sym2real.diagnosis.stages import OnProgress, Stages
from sym2real.effects import Effect, compose, effect
from sym2real.effects.catalogue import always_alike
from sym2real.errors import ModelError
from sym2real.plants import MujocoPlant
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset, Trajectory

Values = Mapping[str, float]
# Of the hypothesis's gain: from here on a rival is worth a line.
WORTH_A_LINE = 0.5
MOST_RIVALS = 5


def add(
    equations: Equations,
    what: str | Iterable[tuple[str, Values]],
    values: Values | None = None,
    *,
    fit: Dataset | Trajectory | None = None,
    plant: MujocoPlant | None = None,
) -> Equations:
    """The equations with an effect in them, or with several, which go in together in the order that physics allows.

    Args:
        equations: the base.
        what: key of an effect, or keys with their values.
        values: by parameter name, in SI units; what is not given stays at its null value.
        fit: logs that the values are fitted to instead; :func:`try_effect` says whether they ask for the effect.
        plant: the plain simulator that calibrates the base before a fit.

    Raises:
        UnknownNameError: for an effect or a parameter that does not exist.
        ModelError: when an effect does not apply, with the reason; when values are given and to be fitted.
    """
    if fit is not None:
        if values is not None or not isinstance(what, str):
            raise ModelError("expected values or logs to fit them to, found both")
        return try_effect(equations, what, fit, plant).apply(equations)
    chosen = [(what, values or {})] if isinstance(what, str) else what
    return compose(equations, [(effect(key, equations), given) for key, given in chosen])


def try_effect(
    equations: Equations,
    key: str,
    data: Dataset | Trajectory,
    plant: MujocoPlant | None = None,
    *,
    calibrate: bool = True,
    held_out: Dataset | None = None,
    exclude: Collection[str] = (),
    horizon: float | None = None,
    on_progress: OnProgress = lambda _: None,
) -> Tried:
    """Fit one effect to logs, alone, and hold it against every other effect in its place.

    Args:
        equations: the base.
        key: of the effect.
        data, plant, calibrate, held_out, exclude, horizon, on_progress: as of :func:`~sym2real.diagnosis.diagnose`.

    Raises:
        UnknownNameError: for an effect that does not exist.
        ModelError: for an effect that does not apply, or whose parameters motion does not show.
        ShapeError: when no log is long enough, columns differ, or the horizon is no step long.
    """
    started = time.perf_counter()
    question = Question(equations, data, plant, calibrate, held_out, exclude, include=(key,), horizon=horizon)
    _check_fittable(effect(key, equations), equations)
    prepared = prepare(question, Stages(on_progress))
    on_progress(f"fitting {key}")
    selection, gain, supported = _fitted(prepared, key)
    on_progress("trying other effects in its place")
    rivals = _rivals(selection, [one for one in prepared.tried if key not in one.keys])
    on_progress("scoring on held-out data")
    steps = Steps.of(prepared.library, selection, same=held_out is None)
    horizons = steps.horizons(prepared.scored, horizon)
    finding = _finding(selection, rivals if supported else (), prepared.calibration)
    stages = steps.ladder(prepared.library, prepared.scored, horizons)
    floor = floor_of_explained(prepared.library, prepared.scored, selection.fit.values, prepared.whitening, horizons)
    return Tried(
        finding=with_advice([finding], prepared.model, prepared.whitening, prepared.plant)[0],
        supported=supported,
        gain=gain,
        rivals=tuple(rival for rival in rivals if rival.gain > max(GAIN, WORTH_A_LINE * gain))[:MOST_RIVALS],
        faults=prepared.checked.faults,
        ladder=stages,
        floor=no_higher_than_reached(floor, stages),
        held_out=steps.names_of(prepared.scored),
        apart=held_out is not None,
        notes=(*prepared.notes, *cut_said(horizons, horizon)),
        seconds=time.perf_counter() - started,
    )


def _check_fittable(wanted: Effect, equations: Equations) -> None:
    reason = wanted.why_not(equations)
    if reason:
        raise ModelError(reason)
    # What is a choice (which rotor) or differs from log to log (a phase) has no derivative that a fit could follow.
    cannot = [one.name for one in wanted.parameters if one.per_log or (not one.fitted and one.null != 0.0)]
    if cannot:
        raise ModelError(f"{wanted.key}: expected values, found logs; its {', '.join(cannot)} cannot be fitted")


def _candidate(key: str, library: Library, data: Dataset) -> Candidate:
    """The effect as a hypothesis: as it competes, or with all its parameters where it would compete as one of two."""
    for one in candidates(library, data):
        if one.keys == (key,):
            return one
    return Candidate(key, (key,), tuple((slot,) for slot in library.indices(key)))


def _fitted(prepared: Prepared, key: str) -> tuple[Selection, float, bool]:
    """The effect alone, chosen whatever it gains; its held-out gain, and whether the logs ask for it."""
    own = _candidate(key, prepared.library, prepared.checked.data)
    selection = Selection(prepared.problems, (own,), prepared.origin)
    (scored,) = selection.ranked([], prepared.origin, [own])
    gain = selection.gain(scored)
    supported = gain > GAIN and selection.significant(scored.fit, own)
    selection.put([own], scored.fit)
    return selection, gain, supported


def _rivals(selection: Selection, others: list[Candidate]) -> tuple[Rival, ...]:
    """What brings how much in the place of the only effect chosen, the best first."""
    (own,) = selection.chosen
    rest, fit = selection.without(own)
    without = selection.problems.held_out(fit)
    gain = float((without - selection.held_out).sum())
    found = []
    for scored in selection.ranked(rest, fit.values, others):
        share = float((without - scored.held_out).sum()) / max(gain, 1e-12)
        alike = gain > 0.0 and as_good(share, scored.held_out - selection.held_out, selection.loss)
        found.append(
            Rival(
                selection.problems.problem.library.key(scored.candidate.name),
                1.0 - scored.loss / float(without.sum()),
                alike,
            )
        )
    return tuple(found)


def _finding(selection: Selection, rivals: Iterable[Rival], calibration: Calibration | None) -> Finding:
    (own,), problems = selection.chosen, selection.problems
    alike = (rival.effect for rival in rivals if rival.as_good)
    always = always_alike(own.name, problems.problem.library.equations)
    group = tuple(dict.fromkeys([*own.alike, *always, *alike]))
    (found,) = findings(selection, None, {own.name: group}, calibration)
    return found
