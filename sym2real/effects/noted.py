"""Which effects were put into equations: nothing in an expression says that a mass was once smaller, so notes do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from sym2real.effects.catalogue import effect
from sym2real.effects.kind import with_unit
from sym2real.symbolic import Equations

PREFIX = "has the effect "


def with_noted(equations: Equations, chosen: Iterable[tuple[str, Mapping[str, float]]]) -> Equations:
    """Equations with a note for each effect that they already have in them.

    Args:
        equations: with the effects.
        chosen: keys and values in SI units; the notes tell the units.

    Raises:
        UnknownNameError: for an effect that these equations cannot have.
    """
    notes = []
    for key, values in chosen:
        units = {one.name: one.unit for one in effect(key, equations).parameters}
        told = (f"{name}={with_unit(value, units[name], 4)}" for name, value in values.items())
        notes.append(f"{PREFIX}{key} {', '.join(told)}")
    return replace(equations, notes=(*equations.notes, *notes))


def noted(equations: Equations) -> tuple[str, ...]:
    """What the notes tell of effects in the equations, each as ``KEY PARAMETER=VALUE UNIT, …``, the first one first."""
    return tuple(note.removeprefix(PREFIX) for note in equations.notes if note.startswith(PREFIX))
