"""Commands of whole logs as effects with memory let them through, for many parameter sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import torch
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import padded
from sym2real.diagnosis.predict.library import Library
from sym2real.effects import Effect
from sym2real.effects.memory import as_given

# Columns of whole logs that are kept behind filters, per command.
MOST_CACHED = 400

# A command's column, and by key the filters that it went through, each with its values.
Passed = tuple[int | tuple[str, bytes], ...]


class FilteredCommands:
    """The commands of a data set behind the filters of a library.

    A command goes through its filters one after the other. What it is behind the first ones does not depend on those
    that follow, so a derivative by the value of one filter asks anew for that one and for what follows it.

    Args:
        library: the candidates, whose filters act on commands.
        data: logs.
    """

    def __init__(self, library: Library, data: Dataset) -> None:
        self._parts = library.parts(data.dt)
        self._dt = data.dt / self._parts
        sent = (log.sent_in_parts(self._parts) for log in data)
        actions = padded(parts.reshape(-1, parts.shape[-1]) for parts in sent)  # (logs, T * parts, m)
        self._sent: dict[Passed, Tensor] = {(column,): rows for column, rows in enumerate(actions.unbind(-1))}
        self._known = dict(self._sent)
        self._null = library.null
        self._filters = [
            (library.effects[key], {library.slots[slot].parameter.name: slot for slot in library.indices(key)})
            for key, _ in library.equations.filters
        ]
        self._slots = [slot for _, fitted in self._filters for slot in fitted.values()]

    def of(self, sets: Tensor) -> tuple[Tensor, Tensor]:
        """Commands for every different set of filters ``# (U, logs, T, parts * m)``, and which set has which."""
        unique, which = self._unique(sets)
        if len(self._known) + len(unique) > MOST_CACHED * len(self._sent):
            self._known = dict(self._sent)
        commands = torch.stack([self._behind(column, unique) for column in range(len(self._sent))], dim=-1)
        rows: Tensor = commands.unflatten(2, (-1, self._parts)).flatten(-2)
        return rows, which

    def _unique(self, sets: Tensor) -> tuple[Tensor, Tensor]:
        """Parameter sets that differ in their filters, nothing else away from null, and which set has which."""
        if not self._slots:
            return self._null[None], torch.zeros(len(sets), dtype=torch.long)
        values, which = torch.unique(sets[:, self._slots], dim=0, return_inverse=True)
        unique = self._null.repeat(len(values), 1)
        unique[:, self._slots] = values
        return unique, which

    def _behind(self, column: int, sets: Tensor) -> Tensor:
        """A command behind all of its filters ``# (U, P) -> (U, logs, T * parts)``."""
        passed: list[Passed] = [(column,)] * len(sets)
        for effect, fitted in self._filters:
            if column in effect.filtered_columns:
                passed = self._behind_one(effect, fitted, sets, passed)
        return torch.stack([self._known[name] for name in passed])

    def _behind_one(
        self, effect: Effect, fitted: Mapping[str, int], sets: Tensor, before: Sequence[Passed]
    ) -> list[Passed]:
        """Names of a command behind one more filter; what is not known by its name is computed."""
        slots = list(fitted.values())
        values, busy = sets[:, slots], (sets[:, slots] != self._null[slots]).any(dim=1)
        passed = [
            (*name, (effect.key, own.numpy().tobytes())) if acts else name
            for name, own, acts in zip(before, values, busy.tolist(), strict=True)
        ]
        new = {name: place for place, name in enumerate(passed) if name not in self._known}
        if new:
            asked = list(new.values())
            rows = torch.stack([self._known[before[place]] for place in asked])[..., None]
            given = as_given(effect.null | {name: sets[asked, slot, None] for name, slot in fitted.items()}, rows)
            start = effect.memory.begin(rows[..., 0, :], self._dt, given)
            _, found = effect.memory.run(start, rows, self._dt, given)
            self._known.update(zip(new, found[..., 0], strict=True))
        return passed
