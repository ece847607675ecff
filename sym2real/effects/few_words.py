"""Keys of effects in few words: those of one kind together, as in ``lag:{wx_cmd,wy_cmd}``."""

from collections.abc import Iterable

MOST_BRACED = 4  # columns of a kind that are named one by one


def in_few_words(keys: Iterable[str]) -> list[str]:
    """Names of the kinds among some keys, in their order."""
    kinds: dict[str, list[str]] = {}
    for key in keys:
        kind, _, column = key.partition(":")
        kinds.setdefault(kind, []).append(column)
    return [name for kind, columns in kinds.items() for name in _of_kind(kind, columns)]


def _of_kind(kind: str, columns: list[str]) -> list[str]:
    whole, named = [kind] * ("" in columns), [column for column in columns if column]
    if len(named) <= 1:
        return [*whole, *(f"{kind}:{column}" for column in named)]
    return [*whole, f"{kind}:{{{','.join(named)}}}" if len(named) <= MOST_BRACED else f"{kind}:*"]
