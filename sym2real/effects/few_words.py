"""Keys of effects in few words: those of one kind together, as in ``lag:{wx_cmd,wy_cmd}``."""

from collections.abc import Iterable

MOST_BRACED = 4  # columns of a kind that are named one by one


def in_few_words(keys: Iterable[str]) -> list[str]:
    """A name for every kind among some keys, in their order."""
    kinds: dict[str, list[str]] = {}
    for key in keys:
        kind, _, column = key.partition(":")
        kinds.setdefault(kind, []).append(column)
    return [_of_kind(kind, columns) for kind, columns in kinds.items()]


def _of_kind(kind: str, columns: list[str]) -> str:
    named = [column for column in columns if column]
    if len(columns) == 1 or not named:
        return f"{kind}:{columns[0]}" if named else kind
    return f"{kind}:{{{','.join(named)}}}" if len(columns) <= MOST_BRACED else f"{kind}:*"
