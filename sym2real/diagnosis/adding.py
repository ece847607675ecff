"""A physical effect into equations: at values that are known, or as a hypothesis that logs confirm or refuse.

add(base, "added_mass", {"value": 0.005})            "I taped 5 g on it"
add(base, "added_mass", fit=logs)                    how much is it?
try_effect(base, "added_mass", logs)                 is it there at all, and what else explains the logs as well?
try_effect(base, ("wind", "com_offset"), logs)       are both there?
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from copy import copy
from functools import partial
from typing import Any

from sym2real.dataset import Dataset, Logs
from sym2real.diagnosis.design.separation import with_advice
from sym2real.diagnosis.errors.rungs import cut_notes
from sym2real.diagnosis.estimate.calibrate import Calibration
from sym2real.diagnosis.estimate.preparation import Prepared
from sym2real.diagnosis.estimate.significance import least_gain
from sym2real.diagnosis.pipeline import prepare
from sym2real.diagnosis.predict.candidate import Candidate, candidates
from sym2real.diagnosis.question import Question
from sym2real.diagnosis.score.finding import Finding, findings, laddered
from sym2real.diagnosis.score.hypothesis_test import Alternative, HypothesisTest
from sym2real.diagnosis.search.near import Near, as_good, by_own_starts, by_price, left_its_part
from sym2real.diagnosis.search.needed import Predicted, keep_needed
from sym2real.diagnosis.search.select import EffectSet, Selection
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import compose, effect
from sym2real.effects.catalogue import always_alike
from sym2real.errors import ModelError
from sym2real.plants import MujocoPlant
from sym2real.stages import OnProgress, Stages
from sym2real.symbolic import Equations
from sym2real.threads import one_thread

Values = Mapping[str, float]
Judged = Mapping[str, Sequence[Alternative]]  # by effect of a hypothesis, others in its place
MOST_ALTERNATIVES = 5


def add(
    equations: Equations,
    what: str | Iterable[str | tuple[str, Values]],
    values: Values | None = None,
    *,
    fit: Logs | None = None,
    plant: MujocoPlant | None = None,
) -> Equations:
    """The equations with an effect in them, or with several, which go in together in the order that physics allows.

    Args:
        equations: the base.
        what: key of an effect, or keys with their values; to be fitted: a key, or several, which are fitted together.
        values: by parameter name, in SI units; what is not given stays at its null value.
        fit: logs that the values are fitted to instead; :func:`try_effect` says whether they ask for the effect.
        plant: the plain simulator that calibrates the base before a fit.

    Raises:
        UnknownNameError: for an effect or a parameter that does not exist.
        ModelError: when an effect does not apply, with the reason; when values are given and to be fitted.

    Examples:
        >>> add(car(wheelbase=0.3), "offset:steer", {"value": 0.05})
        <Equations: x y sin_yaw cos_yaw vx vy wz after 0.05 s, with offset:steer>
    """
    given: list[str | tuple[str, Values]] = [what] if isinstance(what, str) else list(what)
    if values is not None and not isinstance(values, Mapping):
        raise ModelError(f'values: expected numbers by parameter, as {{"value": 0.05}}, found {values!r:.80}')
    if fit is None:
        chosen = [(entry, values or {}) if isinstance(entry, str) else entry for entry in given]
        return compose(equations, [(effect(key, equations), known) for key, known in chosen])
    keys = [entry for entry in given if isinstance(entry, str)]
    if values is not None or len(keys) < len(given):
        raise ModelError("expected values or logs to fit them to, found both")
    return try_effect(equations, keys, fit, plant).apply(equations)


@one_thread()
def try_effect(
    equations: Equations,
    keys: str | Sequence[str],
    data: Logs,
    plant: MujocoPlant | None = None,
    *,
    calibrate: bool = True,
    held_out: Dataset | None = None,
    exclude: Collection[str] = (),
    horizon: float | None = None,
    on_progress: OnProgress = lambda _: None,
) -> HypothesisTest:
    """Fit one effect to logs, or several together, and hold each against every other effect in its place.

    Args:
        equations: the base.
        keys: of the effect, or of several that are one hypothesis: all are there.
        data, plant, calibrate, held_out, exclude, horizon, on_progress: as of :func:`~sym2real.diagnosis.diagnose`.

    Raises:
        UnknownNameError: for an effect that does not exist.
        ModelError: for an effect that does not apply, or whose parameters motion does not show; for two that these logs
            cannot tell apart.
        ShapeError: when no log is long enough, columns differ, or the horizon is no step long.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> model, task = robot.nominal(), make_task("circle", robot)
        >>> target = EquationsPlant(add(model, "offset:steer", {"value": 0.05}), robot)
        >>> log = run_episode(target, MPPI(compile_model(model), robot, task), task, steps=300)
        >>> round(try_effect(model, "offset:steer", log, exclude=["*"]).finding.values["value"], 2)
        0.05
    """
    started = time.perf_counter()
    keys = (keys,) if isinstance(keys, str) else tuple(keys)
    question = Question(equations, data, plant, calibrate, held_out, exclude, include=keys, horizon=horizon)
    for key in keys:
        effect(key, equations).require_fittable(equations)
    prepared = prepare(question, Stages(on_progress))
    on_progress(f"fitting {', '.join(keys)}")
    selection, gain = _fitted(prepared, keys)
    verdict, groups = _judged(prepared, keys, selection, on_progress)
    on_progress("scoring on held-out data")
    fitted = _findings(selection, groups, prepared.calibration)
    steps, horizons, stages, floor = laddered(prepared, selection)
    return HypothesisTest(
        findings=with_advice(fitted, prepared.model, prepared.whitening, prepared.plant),
        **verdict,
        gain=gain,
        faults=prepared.checked.faults,
        ladder=stages,
        floor=floor,
        held_out=steps.names,
        apart=held_out is not None,
        notes=(*prepared.notes, *cut_notes(horizons, horizon)),
        seconds=time.perf_counter() - started,
    )


def _judged(
    prepared: Prepared, keys: Sequence[str], selection: Selection, on_progress: OnProgress
) -> tuple[dict[str, Any], Judged]:
    """What an answer says of a hypothesis, and by effect that is supported what others bring in its place."""
    near = Near(selection, (), by_own_starts(selection, selection.present))
    without = {own.name: selection.without(selection.present, own) for own in selection.chosen}
    empty = {name: by_own_starts(selection, rest) for name, rest in without.items()}
    beside = {key: 1.0 - near.present.loss / without.loss for key, without in empty.items()}
    supported, unneeded = _supported(keys, selection, prepared, beside)
    on_progress("trying other effects in its place")
    others = [candidate for candidate in prepared.candidates if candidate.name not in keys]
    places = [(own, by_price(selection, selection.ranked(without[own.name], others))) for own in selection.chosen]
    judged = {own.name: _alternatives(near, own, empty[own.name], sets) for own, sets in places}
    better = [(own, sets[0]) for own, sets in places if sets and judged[own.name][0].better]
    outdone = tuple(own.name for own, best in better if not left_its_part(selection, own, without[own.name], best))
    refused = tuple(key for key in keys if key not in supported or key in outdone)
    lines = tuple(other for key in keys for other in _worth_a_line(judged[key], beside[key]))
    verdict = {"beside": beside, "unneeded": unneeded, "outdone": outdone, "rivals": lines, "refused": refused}
    return {**verdict, "supported": not refused}, {key: () if key in refused else judged[key] for key in keys}


def _supported(
    keys: Sequence[str], selection: Selection, prepared: Prepared, beside: Mapping[str, float]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The effects that are beyond chance: those that predictions need, and those that they do not."""
    needed = partial(least_gain, selection.problems, values=selection.fit.values, count=len(keys))
    gaining = [candidate for candidate in selection.chosen if beside[candidate.name] > needed(candidate)]
    shown = {candidate.name for candidate in gaining if selection.significant(selection.fit, candidate)}
    # As in a search, on a copy: what is not supported is reported with its values, too.
    apart = Predicted(copy(selection), prepared.library, prepared.checked.data)
    small = {member.name for member in keep_needed(apart)}
    return tuple(key for key in keys if key in shown - small), tuple(key for key in keys if key in shown & small)


def _worth_a_line(alternatives: Sequence[Alternative], beside: float) -> Sequence[Alternative]:
    least = max(SETTINGS.gain, SETTINGS.mostly * beside)
    return [other for other in alternatives if other.better or other.gain > least][:MOST_ALTERNATIVES]


def _fitted(prepared: Prepared, keys: Sequence[str]) -> tuple[Selection, float]:
    """The effects, chosen whatever they gain, the one that gains most first; their held-out gain together."""
    known = candidates(prepared.library, prepared.checked.data, prepared.counts)
    competing = {candidate.name: candidate for candidate in known}
    # As each competes, or with all its parameters where it does not.
    own = tuple(competing.get(key) or Candidate(key, prepared.library.indices(key)) for key in keys)
    selection = Selection(prepared.problems, own, prepared.origin)
    # As sure as a search must be, so that both say the same.
    selection.tested = max(len(own), len(prepared.candidates))
    without = selection.present.loss
    while left := [candidate for candidate in own if candidate not in selection.chosen]:
        ranking = selection.ranked(selection.present, left)
        if not ranking:
            first, second = (" and ".join(candidate.name for candidate in some) for some in (left, selection.chosen))
            raise ModelError(f"{first} beside {second}: expected one of what these logs cannot tell apart, found both")
        selection.put(ranking[0].chosen, ranking[0].fit)
    if len(own) > 1:  # a delay's error has a kink at every step, which stops fits
        present = selection.present
        best = min((present, *selection.fitted_anew(present)), key=lambda effects: effects.fit.total)
        selection.put(best.chosen, best.fit)
    return selection, 1.0 - selection.present.loss / without


def _alternatives(near: Near, own: Candidate, without: EffectSet, sets: Sequence[EffectSet]) -> tuple[Alternative, ...]:
    """What others bring in the place of an effect; one that surely does more is not as good, it is better.

    Args:
        near: the hypothesis.
        own: the effect.
        without: the hypothesis without it.
        sets: with others in its place.
    """
    library, alternatives = near.selection.problems.library, []
    same = (*own.alike, *always_alike(own.name, library.equations))
    for scored in sets:
        key = library.key(scored.candidate.name)
        weight = float(near.weights(near.present.held_out, scored.held_out)[0])
        more = scored.loss < (1 - SETTINGS.gain_beside) * near.present.loss
        better = more and weight <= SETTINGS.level and key not in same
        alike = not (better or left_its_part(near.selection, own, without, scored))
        alike = alike and as_good(near, without.held_out, scored.held_out)
        alternatives.append(Alternative(key, 1.0 - scored.loss / without.loss, alike, own.name, better))
    return tuple(alternatives)


def _findings(selection: Selection, alternatives: Judged, calibration: Calibration | None) -> list[Finding]:
    equations = selection.problems.library.equations
    alike = {name: [other.effect for other in others if other.as_good] for name, others in alternatives.items()}
    groups = {own.name: (*own.alike, *always_alike(own.name, equations), *alike[own.name]) for own in selection.chosen}
    return findings(selection, None, groups, calibration)
