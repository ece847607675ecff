"""Commands of whole logs as effects with memory let them through, for many parameter sets."""

import torch
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import padded
from sym2real.diagnosis.predict.library import Library

# Filtered logs that are kept, by the values of their filters.
MOST_CACHED = 400


class FilteredCommands:
    """The commands of a data set behind the filters of a library.

    Args:
        library: the candidates, whose filters act on commands.
        data: logs.
    """

    def __init__(self, library: Library, data: Dataset) -> None:
        self._library, self._parts = library, library.parts(data.dt)
        self._dt = data.dt / self._parts
        sent = (log.sent_in_parts(self._parts) for log in data)
        self._actions = padded(parts.reshape(-1, parts.shape[-1]) for parts in sent)  # (logs, T * parts, m)
        self._filtered: dict[bytes, Tensor] = {}

    def of(self, sets: Tensor) -> tuple[Tensor, Tensor]:
        """Commands for every different set of filters ``# (U, logs, T, parts * m)``, and which set has which."""
        library = self._library
        columns = [i for key, _ in library.equations.filters for i in library.indices(key)]
        if not columns:
            return self._of_rows(self._actions[None]), torch.zeros(len(sets), dtype=torch.long)
        unique, which = torch.unique(sets[:, columns], dim=0, return_inverse=True)
        names = [values.numpy().tobytes() for values in unique]
        missing = [i for i, name in enumerate(names) if name not in self._filtered]
        if missing:
            if len(self._filtered) + len(missing) > MOST_CACHED:
                self._filtered.clear()
                missing = list(range(len(names)))
            self._filtered.update(zip([names[i] for i in missing], self._filter(unique[missing]), strict=True))
        return self._of_rows(torch.stack([self._filtered[name] for name in names])), which

    def _of_rows(self, commands: Tensor) -> Tensor:
        return commands.reshape(*commands.shape[:2], -1, self._parts * commands.shape[-1])

    def _filter(self, unique: Tensor) -> Tensor:
        """All commands ``# (U, logs, T * parts, m)`` through filters of these values ``# (U, filter slots)``."""
        library = self._library
        rows = self._actions.expand(len(unique), -1, -1, -1)
        keys = [key for key, _ in library.equations.filters]
        for key, values in zip(keys, unique.split([len(library.indices(key)) for key in keys], dim=1), strict=True):
            effect, slots = library.effects[key], library.indices(key)
            busy = (values != library.null[list(slots)]).any(dim=1)
            if busy.any():
                given = {library.slots[i].parameter.name: values[busy, j, None] for j, i in enumerate(slots)}
                rows = rows.clone()
                rows[busy] = effect.filter(rows[busy], self._dt, given)
        return rows
