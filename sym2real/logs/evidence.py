"""Which rows of long or fast logs evidence is taken from: enough that more would say the same, and no more.

Rows faster than :data:`RATE` only add noise to slopes. Of hours of recording, stretches are looked at that stand evenly
over the log: slopes and delays need rows in a row, and one stretch alone may be the one on the ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sym2real.trajectory import Array

RATE = 100.0  # rows a second
STRETCHES, LENGTH = 10, 3000  # of a log; rows of evidence in each, half a minute at that rate


@dataclass(frozen=True)
class Stretch:
    """Rows of one log.

    Args:
        log: which, counted from 0.
        rows: first row, row after the last, and stride.
    """

    log: int
    rows: slice


def stretches(times: Sequence[Array]) -> list[Stretch]:
    """The rows to look at in logs with these stamps in s ``# (rows,)``: the whole of a log that is short enough."""
    stretches = []
    for log, time in enumerate(times):
        stride = max(1, round(1.0 / (RATE * float(np.median(np.diff(time))))))
        length = LENGTH * stride
        if len(time) <= STRETCHES * length:
            stretches.append(Stretch(log, slice(0, len(time), stride)))
            continue
        firsts = np.linspace(0, len(time) - length, STRETCHES).astype(int).tolist()
        stretches += [Stretch(log, slice(first, first + length, stride)) for first in firsts]
    return stretches


def words(times: Sequence[Array], looked_at: Sequence[Stretch]) -> str:
    """What is looked at, for people; empty where it is every row."""
    used = sum(len(range(len(times[stretch.log]))[stretch.rows]) for stretch in looked_at)
    whole = sum(map(len, times))
    if used == whole:
        return ""
    strides = sorted({stretch.rows.step for stretch in looked_at})
    every = "" if strides == [1] else f"every {' to '.join(f'{stride}th' for stride in strides)} row"
    cut = len(looked_at) > len(times)
    parts = f"{STRETCHES} stretches of {LENGTH} rows, evenly over {'each long' if len(times) > 1 else 'the'} log"
    how = ", ".join(part for part in (every, parts if cut else "") if part)
    return f"{used} of {whole} rows ({how}) tell slopes, units and delays; stamps, limits and empty cells are of all"
