"""Effects that took no part in a search, in few words."""

from collections.abc import Iterable, Iterator
from itertools import groupby

from sym2real.diagnosis.predict.competitors import NotTested
from sym2real.effects.few_words import in_few_words


def lines_by_reason(left_out: Iterable[NotTested]) -> Iterator[str]:
    """A line for every reason, with the effects that it holds for."""
    ordered = sorted(left_out, key=lambda entry: entry.reason)
    for reason, same in groupby(ordered, key=lambda entry: entry.reason):
        yield f"{', '.join(in_few_words(entry.effect for entry in same))}: {reason}"
