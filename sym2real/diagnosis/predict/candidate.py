"""Which effects compete, and where fits of them start."""

import fnmatch
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType

from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.predict.competitors import NotTested, competing, values_for
from sym2real.diagnosis.predict.library import Library, library_of
from sym2real.effects import applicable, effect
from sym2real.effects.catalogue import require_patterns
from sym2real.effects.groups import Group, holding, others_of
from sym2real.effects.inputs import ANGLE, has_force, with_inputs_of
from sym2real.effects.wrench import with_force_inputs
from sym2real.symbolic import Equations

Counts = Mapping[str, tuple[float, ...]]  # starts of effects that repeat along a joint, by their keys
NO_COUNTS: Counts = MappingProxyType({})
NO_SWING = "nothing in these logs swings beyond chance, beside what goes with the path"
NO_RIPPLE = "nothing in these logs repeats beyond chance along the joint"


@dataclass(frozen=True)
class Candidate:
    """A hypothesis that competes.

    Args:
        name: key of its effect.
        free: slots of its parameters.
        starts: further starting values of the first free parameter; the null value is always one.
        needs_start: the null value is no start, because nothing changes there.
        alike: keys of effects that this data cannot tell from it, by physics.
        excludes: those of them that cannot be found beside it.
    """

    name: str
    free: tuple[int, ...]
    starts: tuple[float, ...] = ()
    needs_start: bool = False
    alike: tuple[str, ...] = ()
    excludes: tuple[str, ...] = ()

    @property
    def slots(self) -> list[int]:
        """The free ones, as tensors are indexed."""
        return list(self.free)

    def started(self, values: Tensor, level: float) -> Tensor:
        """A parameter set ``# (P,)`` with the first parameter at one of the starts."""
        values = values.clone()
        values[self.free[0]] = level
        return values

    def copied(self, source: Tensor, into: Tensor) -> Tensor:
        """A parameter set ``# (P,)`` with the effect's parameters as another one has them."""
        copy = into.clone()
        copy[self.slots] = source[self.slots]
        return copy


def library_for(
    equations: Equations, data: Dataset, exclude: Collection[str] = (), include: Sequence[str] = ()
) -> Library:
    """The equations with every effect that competes on this data, and those to be included in any case.

    Logs with the battery's voltage give the equations that input, so that thrust may sag with it.
    """
    require_patterns(exclude)
    equations = competing_in(equations, data)
    return library_of(equations, tuple(dict.fromkeys((*competing(equations, data, exclude)[0], *include))))


def competing_in(equations: Equations, data: Dataset) -> Equations:
    """The equations that effects compete in: with inputs of the logs, and a force that these do not know.

    A force that the logs know is not the base's to leave out.
    """
    equations = with_inputs_of(equations, data)
    return equations if any(map(has_force, data)) else _with_forces(equations)


_with_forces = lru_cache(maxsize=4)(with_force_inputs)  # the same equations again, of which libraries are kept


def candidates(library: Library, data: Dataset, counts: Counts = NO_COUNTS) -> tuple[Candidate, ...]:
    """What competes: one candidate per effect; of those that repeat along a joint the ones that are in ``counts``."""
    candidates: list[Candidate] = []
    groups, known = holding(data), [effect.key for effect in applicable(library.equations)]
    exclusive = [group for group in groups if group.exclusive]
    for key, own in library.effects.items():
        slots, searching = library.indices(key), own.searching
        if not slots or (searching.swings and not swings(data)) or (searching.repeats and key not in counts):
            continue
        values = values_for(library.equations, own, data)
        fixed, starts = searching.fixed(own.body, values, data), counts.get(key, searching.starts(own.body, values))
        free = tuple(slot for slot in slots if library.slots[slot].parameter.name not in fixed)
        alike, excludes = (_matching(key, some, known) for some in (groups, exclusive))
        candidates.append(Candidate(key, free, starts, not searching.from_null, alike, excludes))
    return tuple(candidates)


def not_tested(
    equations: Equations, data: Dataset, counts: Counts, exclude: Collection[str], include: Collection[str]
) -> tuple[NotTested, ...]:
    """What is no candidate for :func:`candidates`, and why: not to compete, or because nothing swings or repeats."""
    keys, others = competing(competing_in(equations, data), data, exclude)
    searching = {key: effect(key, equations).searching for key in keys}
    calm = [NotTested(key, NO_SWING) for key in keys if searching[key].swings and not swings(data)]
    even = [NotTested(key, NO_RIPPLE) for key in keys if searching[key].repeats and key not in counts]
    return (*(left_out for left_out in others if left_out.effect not in include), *calm, *even)


def at_first_count(library: Library, competing: Iterable[Candidate]) -> tuple[Tensor, tuple[Candidate, ...]]:
    """No effect ``# (P,)``, but what repeats along a joint where it most likely does, from where its size is smooth."""
    null, others = library.null, list[Candidate]()
    for own in competing:
        repeats = library.effects[own.name].searching.repeats
        null = own.started(null, own.starts[0]) if repeats else null
        others.append(replace(own, starts=(), needs_start=False) if repeats else own)
    return null, tuple(others)


def swings(data: Dataset) -> bool:
    """Whether a swing has been found in the logs."""
    return any(ANGLE in log.extra for log in data)


def _matching(key: str, groups: Iterable[Group], known: Sequence[str]) -> tuple[str, ...]:
    others = {other for pattern in others_of(key, groups) for other in fnmatch.filter(known, pattern)} - {key}
    return tuple(other for other in known if other in others)
