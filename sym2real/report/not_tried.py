"""Effects that took no part in a search, in few words."""

from collections.abc import Iterable, Iterator
from itertools import groupby

from sym2real.diagnosis.predict.competitors import NotTried

MOST_BRACED = 4  # columns of a kind that a line names one by one


def not_tried_said(left_out: Iterable[NotTried]) -> Iterator[str]:
    """A line for every reason, with the effects that it holds for."""
    ordered = sorted(left_out, key=lambda entry: entry.reason)
    for reason, same in groupby(ordered, key=lambda entry: entry.reason):
        yield f"{not_tried_names(same)}: {reason}"


def not_tried_names(left_out: Iterable[NotTried]) -> str:
    """The effects in few words: those of one kind together."""
    kinds: dict[str, list[str]] = {}
    for entry in left_out:
        kind, _, column = entry.effect.partition(":")
        kinds.setdefault(kind, []).append(column)
    return ", ".join(_keys(kind, columns) for kind, columns in kinds.items())


def _keys(kind: str, columns: list[str]) -> str:
    named = [column for column in columns if column]
    if len(columns) == 1 or not named:
        return f"{kind}:{columns[0]}" if named else kind
    return f"{kind}:{{{','.join(named)}}}" if len(columns) <= MOST_BRACED else f"{kind}:*"
