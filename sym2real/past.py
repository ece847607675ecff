"""The past that a model with memory sees: commands as sent, then states, each from the newest to the oldest.

Before the first row it is that row, repeated: as if the first command had been held for ever.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def past_of_rows(action: Array, state: Array, first: NDArray[np.int64], commands: int, states: int) -> Array:
    """What each row of a log has behind it ``# (rows, commands·action + states·state)``.

    Args:
        action: ``# (rows, action)``.
        state: ``# (rows, state)``.
        first: of every row, the row that its trajectory begins with ``# (rows,)``.
        commands: how many past commands.
        states: how many past states.
    """
    rows = np.arange(len(action))
    parts = [
        values[np.maximum(rows - back, first)]
        for values, length in ((action, commands), (state, states))
        for back in range(1, length + 1)
    ]
    return np.concatenate([np.empty((len(rows), 0)), *parts], axis=1)


def past_rows(model: object) -> tuple[int, int]:
    """How many past commands and states a model sees, as its attribute ``past_rows`` says; none without."""
    return getattr(model, "past_rows", (0, 0))


class Past:
    """A ring buffer of the last rows while commands are sent one by one.

    Args:
        commands: how many past commands it holds.
        states: how many past states.
    """

    def __init__(self, commands: int, states: int) -> None:
        self._commands: deque[Array] = deque(maxlen=commands)
        self._states: deque[Array] = deque(maxlen=states)
        self.reset()

    def reset(self) -> None:
        """Forget every row."""
        self._begun = False
        self._commands.clear()
        self._states.clear()

    def remember(self, sent: Array, state: Array | None) -> None:
        """Add a row: the command sent ``# (action,)`` on a state ``# (state,)``, None where nobody measured one."""
        self._begun = bool(self._commands.maxlen or self._states.maxlen)
        for row, rows in ((sent, self._commands), (state, self._states)):
            if row is not None:
                rows.extend([row] * (1 if rows else rows.maxlen or 0))

    def before(self, state: Array) -> Array | None:
        """What lies behind the present state ``# (commands·action + states·state,)``; None before the first row.

        None, too, where nothing is held.
        """
        if not self._begun:
            return None
        states = list(self._states) or [state] * (self._states.maxlen or 0)
        return np.concatenate([np.empty(0), *reversed(self._commands), *reversed(states)])
