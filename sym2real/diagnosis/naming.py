"""Which of the effects that these logs hardly tell apart is named: another one, where that predicts better.

At one speed tyres that slip do what a lever arm does, and the arm is named (``groups.py``). Drives at other speeds
tell them apart, and where something is left beside the arm, the slip is put in its place. So is a load at an arm, where
something is left beside a mass and a centre of mass, which stand for it. And what takes up much of what others do is
tried only then: the lever arm of what is measured in flight.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from fnmatch import fnmatch

from sym2real.dataset import Dataset
from sym2real.diagnosis.answer import Diagnosis
from sym2real.diagnosis.predict.competitors import EXCLUDED
from sym2real.diagnosis.question import Question
from sym2real.diagnosis.score.finding import Scored
from sym2real.diagnosis.score.held_out import Gate
from sym2real.diagnosis.search.beam import SearchResult
from sym2real.effects.catalogue import effect
from sym2real.effects.groups import same_on_every_flight, unnamed
from sym2real.effects.searching import LATER
from sym2real.symbolic import Equations

INSTEAD = "another effect, which predicts these logs better, stands for it"
Searched = tuple[SearchResult, Scored | None]


@dataclass(frozen=True)
class Doubt:
    """Named effects in whose place others may predict better.

    Args:
        named: their keys, and those of what is the same on every flight.
        included: what no search takes by itself, and may stand in their place.
    """

    named: tuple[str, ...]
    included: tuple[str, ...] = ()


def doubts(answer: Diagnosis, equations: Equations, data: Dataset) -> tuple[Doubt, ...]:
    """Effects that are named for others in such logs, where something that matters is left: one of those may do better.

    What several stand for is in doubt where all of them are named, and where what was found explains too little.
    """
    if not any(leftover.matters for leftover in answer.leftovers):
        return ()
    groups = [{finding.effect, *finding.group} for finding in answer.findings]
    behind = unnamed({finding.effect for finding in answer.findings}, data)
    names = (behind[other.effect][0] for other in answer.not_tried if other.effect in behind)
    # What is the same on every flight predicts no better, but for what the others' values then are relative to.
    found = [Doubt((name, *same_on_every_flight(name, data))) for name in names]
    excluded = {entry.effect for entry in answer.not_tried if entry.reason == EXCLUDED}
    for other in (effect(entry.effect, equations) for entry in answer.not_tried if entry.effect not in excluded):
        if any(fnmatch(key, pattern) for key in excluded for pattern in other.of.counts_as):
            continue
        together = other.of.counts_as if other.of.parts and other.applies(equations) else ()
        named = (any(key in group for group in groups) for key in together)
        later = other.searching.why_not(other.body) == LATER and other.applies(equations)
        if later or (together and (answer.verdict == "UNEXPLAINED" or all(named))):
            found.append(Doubt(together, (other.key,)))
    return tuple(dict.fromkeys(found))


def instead(scored: Scored | None, searched: Callable[[Question], Searched], doubt: Doubt) -> Scored | None:
    """What predicts better with others in the place of what is named; else None.

    What no search takes by itself must predict better by a tenth, or as well with fewer beside; others by a tenth, or
    surely without more effects. First of few effects, then of all.
    """
    if scored is None:
        return None
    question, library = scored.result.prepared.question, scored.result.prepared.library
    beside = {finding.effect for finding in scored.findings} - {*doubt.named}
    others = sorted({*map(library.key, library.effects)} - beside)
    for left_out in (others, ()):
        exclude = (*question.exclude, *doubt.named, *left_out)
        _, other = searched(replace(question, exclude=exclude, include=doubt.included))
        found = {finding.effect for finding in other.findings} if other else set[str]()
        if other is None or not found.issuperset(doubt.included):
            return None
        change = Gate(scored.gate.after or other.gate.before, other.gate.after)
        fewer = len(found.difference(doubt.included)) < len(beside)
        better = fewer if doubt.included else change.falling and len(found) <= len(scored.findings)
        if change.worse or not (change.fallen or better):
            return None
    return other


def renamed(answer: Diagnosis, exclude: Collection[str]) -> Diagnosis:
    """An answer that was made without effects which others now stand for, beside those that a user excludes."""
    by_user = [entry.effect for entry in answer.not_tried if any(fnmatch(entry.effect, key) for key in exclude)]
    gone = [entry for entry in answer.not_tried if entry.reason == EXCLUDED and entry.effect not in by_user]
    now = tuple(replace(entry, reason=INSTEAD) if entry in gone else entry for entry in answer.not_tried)
    return replace(answer, not_tried=now)
