"""Which manoeuvre distinguishes what the logs could not: simulated plainly before anybody flies it.

What was found is put into the prediction of every manoeuvre; then its alternative is fitted to that in its place, with
all its free parameters, the noise and the disturbances of the logs. The part of the effect that it does not explain is
what the manoeuvre shows: the two part where it is more than the gain that any finding needs (the rule by which they
were held for one in the logs).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from sym2real.control.manoeuvres import DITHER, TRIALS, Trial
from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import cut
from sym2real.diagnosis.estimate.fit import Hypothesis, Problems
from sym2real.diagnosis.estimate.simulator import fly
from sym2real.diagnosis.estimate.whitening import Spread, Whitening
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.score.finding import Finding
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import effect
from sym2real.errors import Sym2RealError
from sym2real.plants import MujocoPlant
from sym2real.symbolic import Equations
from sym2real.tasks.standard_paths import path_of
from sym2real.tasks.task import follows_paths, motion

# One note for all findings.
UNTESTED = (
    "manoeuvres that would tell effects apart were not simulated: that takes the simulator of a robot that flies or "
    "drives along paths (`sym2real plan` assesses others)"
)
# Alternatives to a finding that manoeuvres are sought for.
MOST_ALTERNATIVES = 2


@dataclass(frozen=True)
class _Outcome:
    """What a manoeuvre shows: the part of a finding that each alternative explains, and how much is left at least.

    Args:
        words: what is flown.
        explained: by alternative.
        left: of the whitened squares, by the alternative that leaves least, in units of what parts them.
    """

    words: str
    explained: dict[str, float]
    left: float


def with_advice(
    findings: Sequence[Finding], equations: Equations, whitening: Whitening, plant: MujocoPlant | None
) -> tuple[Finding, ...]:
    """The findings, those that others may stand for with the manoeuvre that tells them apart and what it shows.

    Args:
        findings: what was found.
        equations: the base.
        whitening: noise and disturbances of the logs.
        plant: the plain simulator; None where nothing can be simulated, as of a robot that follows no path.
    """
    testable = {finding.effect: _testable(finding, equations) for finding in findings}
    unflown = [replace(own, separate_by=_unflown(own, testable[own.effect], equations)) for own in findings]
    if plant is None or not follows_paths(plant.robot) or not any(testable.values()):
        return tuple(unflown)
    keys = dict.fromkeys(key for name, others in testable.items() if others for key in (name, *others))
    library = Library.of(equations, [effect(key, equations) for key in keys])
    flown, result = cache(partial(_flown, plant)), []
    for finding, plain in zip(findings, unflown, strict=True):
        outcomes, others = list[_Outcome](), testable[finding.effect]
        for trial in _made_for((finding.effect, *others), plant, equations) if others else ():
            if (data := flown(trial)) is None:
                continue
            outcomes.append(_outcome(finding, others, library, whitening, (trial, data)))
            if outcomes[-1].left > 1.0 and max(outcomes[-1].explained.values()) < SETTINGS.clear:
                break
        result.append(replace(plain, separate_by=_advice(finding, outcomes, equations)) if outcomes else plain)
    return tuple(result)


def untested_notes(findings: Sequence[Finding], equations: Equations, plant: MujocoPlant | None) -> tuple[str, ...]:
    """A sentence where :func:`with_advice` names manoeuvres that it could not simulate; arguments as there."""
    if plant is not None and follows_paths(plant.robot):
        return ()
    return (UNTESTED,) if any(_testable(finding, equations) for finding in findings) else ()


def _testable(finding: Finding, equations: Equations) -> tuple[str, ...]:
    """Alternatives that physics may distinguish from a finding, and that a fit can put in its place."""
    if effect(finding.effect, equations).searching.swings:
        return ()
    others = [key for key in finding.alternatives if not _always(key, finding.effect, equations)]
    # One that stands for an alternative on every flight fares as that does.
    first = [key for at, key in enumerate(others) if not any(_always(key, other, equations) for other in others[:at])]
    return tuple(key for key in first if effect(key, equations).applies(equations))[:MOST_ALTERNATIVES]


def _always(key: str, other: str, equations: Equations) -> bool:
    return key == effect(other, equations).stood_for_by or other == effect(key, equations).stood_for_by


def _made_for(effects: Sequence[str], plant: MujocoPlant, equations: Equations) -> list[Trial]:
    """The manoeuvres of such a robot, those that are made for one of the effects first."""
    known = [effect(key, equations) for key in effects]
    shown = {manner for effect in known for manner in effect.searching.shown_in(effect.body)}
    return sorted(TRIALS[motion(plant.robot)], key=lambda trial: trial.shows not in shown)


def _flown(plant: MujocoPlant, trial: Trial) -> Dataset | None:
    """A manoeuvre in the simulator; None where that cannot fly it."""
    robot = plant.robot
    usual = zip(robot.layouts.action, robot.recipe.dither, strict=True)
    dither, rows = np.array([DITHER.get(*command) for command in usual]), round(trial.seconds / robot.dt)
    logs = []
    for number, path in enumerate(trial.paths):
        noise = np.random.default_rng(number).standard_normal((rows, len(dither)))
        reference = path_of(robot, path, 0.0, trial.yaw_rate)
        try:
            logs.append(fly(plant, reference, trial.dither * dither * noise, name=f"{trial.words} {number}"))
        except Sym2RealError:  # a simulator that cannot follow this, as of wheels too light for their servos
            return None
    return Dataset(logs) if all(len(log) == rows for log in logs) else None


def _outcome(
    finding: Finding, alternatives: Sequence[str], library: Library, whitening: Whitening, flown: tuple[Trial, Dataset]
) -> _Outcome:
    trial, data = flown
    values = library.null
    for slot in library.indices(finding.effect):
        values[slot] = finding.values.get(library.slots[slot].parameter.name, float(values[slot]))
    plain = Problem(library, data, cut(data, whitening.fields, whitening.length))
    problem = Problem(library, data, replace(plain.segments, measured=plain.states(values[None])[0]))
    problems = Problems(problem, Spread.of(problem, library.null).like(whitening))
    nothing = problems.quadratics([Hypothesis((), library.null)])[0].total
    known, left = candidates(library, data), {}
    for key in alternatives:
        same = [candidate for candidate in known if candidate.name == key]
        hypotheses = [Hypothesis(own.free, library.null) for own in same]
        hypotheses += [Hypothesis(own.free, own.started(library.null, level)) for own in same for level in own.starts]
        left[key] = min((fit.total for fit in problems.fit(hypotheses)), default=nothing)
    explained = {key: 1.0 - rest / max(nothing, 1e-300) for key, rest in left.items()}
    least = min([nothing, *left.values()])
    return _Outcome(trial.words, explained, least / (SETTINGS.gain_beside * problems.whitening.freedom))


def _advice(finding: Finding, outcomes: Sequence[_Outcome], equations: Equations) -> str:
    """What to fly, and what that shows; or that no manoeuvre simulated would do."""
    best = max(outcomes, key=lambda outcome: outcome.left)
    shares = " and ".join(f"{key} explains {100 * part:.3g} %" for key, part in best.explained.items())
    shown = f"{best.words}: there {shares} of what {finding.effect} does"
    none = f"none of {len(outcomes)} manoeuvres simulated (at best {best.words}: {shares} of it)"
    return "; ".join([shown if best.left > 1.0 else none, *_never(finding, equations)])


def _unflown(finding: Finding, others: Sequence[str], equations: Equations) -> str:
    never = _never(finding, equations)
    if not others:
        return "; ".join(never)
    return "; ".join([*never, f"from {' or '.join(others)}: {finding.separate_by}"]) if never else finding.separate_by


def _never(finding: Finding, equations: Equations) -> list[str]:
    same = [key for key in finding.alternatives if _always(key, finding.effect, equations)]
    ways = [way for way in (effect(key, equations).of.distinguished_by for key in (finding.effect, *same)) if way]
    instead = f", but {ways[0]}" if ways else ""
    return [f"no motion tells it from {' or '.join(same)}{instead}"] if same else []
