"""Which of the effects that these logs hardly tell apart is named: another one, where that predicts better.

At one speed tyres that slip do what a lever arm does, and the arm is named (``groups.py``). Drives at other speeds
tell them apart, and where something is left beside the arm, the slip is put in its place.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from fnmatch import fnmatch

from sym2real.dataset import Dataset
from sym2real.diagnosis.answer import Diagnosis
from sym2real.diagnosis.predict.competitors import EXCLUDED
from sym2real.diagnosis.question import Question
from sym2real.diagnosis.score.finding import Scored
from sym2real.diagnosis.score.held_out import Gate
from sym2real.diagnosis.search.beam import SearchResult
from sym2real.effects.groups import unnamed

INSTEAD = "another effect, which predicts these logs better, stands for it"
Searched = tuple[SearchResult, Scored | None]


def doubtful_names(answer: Diagnosis, data: Dataset) -> tuple[str, ...]:
    """Effects that are named for others in such logs, where something is left: one of those may do better."""
    behind = unnamed({finding.effect for finding in answer.findings}, data) if answer.leftovers else {}
    return tuple(dict.fromkeys(behind[other.effect][0] for other in answer.not_tried if other.effect in behind))


def instead(scored: Scored | None, searched: Callable[[Question], Searched], key: str) -> Scored | None:
    """What predicts better with one that an effect stands for in its place: of few effects, then of all; else None."""
    if scored is None:
        return None
    prepared, before = scored.result.prepared, scored.gate.after
    chosen = {candidate.name for candidate in scored.result.selection.chosen}
    others = [prepared.library.key(other.name) for other in prepared.candidates if other.name not in chosen]
    for beside in (others, ()):
        _, other = searched(replace(prepared.question, exclude=(*prepared.question.exclude, key, *beside)))
        if other is None or not Gate(before, other.gate.after).fallen:
            return None
    return other


def renamed(answer: Diagnosis, exclude: Collection[str]) -> Diagnosis:
    """An answer that was made without effects which others now stand for, beside those that a user excludes."""
    by_user = [entry.effect for entry in answer.not_tried if any(fnmatch(entry.effect, key) for key in exclude)]
    gone = [entry for entry in answer.not_tried if entry.reason == EXCLUDED and entry.effect not in by_user]
    now = tuple(replace(entry, reason=INSTEAD) if entry in gone else entry for entry in answer.not_tried)
    return replace(answer, not_tried=now)
