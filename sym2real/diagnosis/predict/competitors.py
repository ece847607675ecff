"""Which effects compete in a diagnosis, and why each of the others does not: what was not tried is not refuted."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import asdict, dataclass
from fnmatch import fnmatch
from itertools import groupby

from sym2real.diagnosis.predict.commands import still
from sym2real.diagnosis.predict.library import Library
from sym2real.effects import Effect
from sym2real.effects.catalogue import known
from sym2real.effects.groups import unnamed
from sym2real.errors import ModelError
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset

EXCLUDED = "excluded on request"
QUATERNION = "quaternion"  # kind of a field
COMPONENT = "a component of a quaternion is no command of its own"
MOST_BRACED = 4  # columns of a kind that a line names one by one


@dataclass(frozen=True)
class NotTried:
    """An effect that took no part in a search, and why."""

    effect: str
    reason: str

    def to_dict(self) -> dict[str, str]:
        """An entry of ``not_tried`` in ``diagnosis.json``."""
        return asdict(self)


def competing(
    equations: Equations, data: Dataset, exclude: Collection[str] = ()
) -> tuple[tuple[str, ...], tuple[NotTried, ...]]:
    """Keys of the effects of such a robot that compete on this data, and all others."""
    effects = {one.key: one for one in known(equations)}
    reasons = {key: _why_not(one, equations, data, exclude) for key, one in effects.items()}
    reasons |= {
        key: f"{one.stood_for_by} stands for it: no flight tells them apart"
        for key, one in effects.items()
        if not reasons[key] and reasons.get(one.stood_for_by) == ""
    }
    left = {key for key, reason in reasons.items() if not reason}
    reasons |= {
        key: f"{by} stands for it: in these logs {why}"
        for key, (by, why) in unnamed(left, data).items()
        if not reasons.get(key, "-")
    }
    keys = tuple(key for key, reason in reasons.items() if not reason)
    return keys, tuple(NotTried(key, reason) for key, reason in reasons.items() if reason)


def _why_not(one: Effect, equations: Equations, data: Dataset, exclude: Collection[str]) -> str:
    """Why an effect does not compete; "" where it does."""
    if any(fnmatch(one.key, pattern) for pattern in exclude):
        return EXCLUDED
    return (
        (COMPONENT if _is_component(one) else one.searching.why_not(one.body))
        or one.why_not(equations).removeprefix(f"{one.key} ")
        or still(equations, one, data)
        or _refused(one, equations)
    )


def _is_component(one: Effect) -> bool:
    return any(one.column in field.columns for field in one.body.layouts.action.fields if field.kind == QUATERNION)


def _refused(one: Effect, equations: Equations) -> str:
    """Why the equations cannot be given an effect that has all it names: a push without a place, a number for that."""
    try:
        Library.of(equations, [one])
    except ModelError as error:
        return str(error)
    return ""


def not_tried_said(left_out: Iterable[NotTried]) -> Iterator[str]:
    """A line for every reason, with the effects that it holds for."""
    ordered = sorted(left_out, key=lambda one: one.reason)
    for reason, same in groupby(ordered, key=lambda one: one.reason):
        kinds: dict[str, list[str]] = {}
        for one in same:
            kind, _, column = one.effect.partition(":")
            kinds.setdefault(kind, []).append(column)
        yield f"{', '.join(_keys(kind, columns) for kind, columns in kinds.items())}: {reason}"


def _keys(kind: str, columns: list[str]) -> str:
    named = [column for column in columns if column]
    if len(columns) == 1 or not named:
        return f"{kind}:{columns[0]}" if named else kind
    return f"{kind}:{{{','.join(named)}}}" if len(columns) <= MOST_BRACED else f"{kind}:*"
