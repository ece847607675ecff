"""The way from a key to an effect, and which effects apply to given equations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fnmatch import fnmatch

from sym2real.effects.body import Body, Describable
from sym2real.effects.effect import Effect
from sym2real.effects.groups import equivalents
from sym2real.effects.kind import Kind
from sym2real.effects.kinds import EFFECTS
from sym2real.errors import UnknownNameError
from sym2real.symbolic import Equations
from sym2real.vocabulary import load_quantity


def effect(key: str, described: Describable) -> Effect:
    """The effect of a key, ``kind`` or ``kind:column``.

    Args:
        key: as a user types it.
        described: the robot or equations that it is for.

    Raises:
        UnknownNameError: for a kind that does not exist, a column that the kind does not have, or one that is missing.

    Examples:
        >>> wind = effect("wind", ROBOTS["crazyflie"])
        >>> [f"{one.name} in {one.unit}" for one in wind.parameters]
        ['fx in N', 'fy in N', 'fz in N']
    """
    name, colon, column = key.partition(":")
    kind = EFFECTS[name]
    columns = columns_of(kind, described)
    bound = colon or (columns and kind.column_needed)
    if bound and column not in columns:
        raise UnknownNameError("effect", key, [f"{name}:{known}" for known in columns] or [name])
    body = Body.of(described, column)
    return Effect(
        kind,
        body,
        tuple(equivalent for equivalent in equivalents(key) if EFFECTS[equivalent.partition(":")[0]].fits(body)),
    )


def refusal(chosen: Effect, described: Describable) -> str:
    """Why an effect cannot be had on these equations, or this robot, and what they have in its place; "" if it can."""
    reason, name = chosen.why_not(described), chosen.of.of_joints
    if not reason or not name:
        return reason
    kind = EFFECTS[name]
    keys = [f"{name}:{column}" for column in columns_of(kind, described)] if kind.columns else [name]
    there = [key for key in keys if not effect(key, described).why_not(described)]
    return f"{reason}; in its place this robot has {', '.join(there)}" if there else reason


def known(equations: Equations) -> Iterator[Effect]:
    """Every effect of such a robot, one per column where a kind has columns, whether the equations can be given it."""
    body = Body.of(equations)
    for name, kind in EFFECTS.items():
        columns = columns_of(kind, equations)
        keys = [f"{name}:{column}" for column in columns]
        if not kind.columns or (columns and not kind.column_needed):
            keys.insert(0, name)
        yield from (effect(key, equations) for key in keys if kind.fits(body))


def applicable(equations: Equations) -> tuple[Effect, ...]:
    """Every effect that the equations can be given."""
    return tuple(effect for effect in known(equations) if effect.applies(equations))


def always_alike(key: str, equations: Equations) -> tuple[str, ...]:
    """Effects of these equations that an effect stands for on every flight."""
    return tuple(effect.key for effect in applicable(equations) if effect.stood_for_by == key)


def require_patterns(patterns: Iterable[str]) -> None:
    """Refuse keys, or patterns of keys, that no effect can match.

    Raises:
        UnknownNameError: for a kind that does not exist, or one that needs a column.
    """
    for pattern in patterns:
        name = pattern.partition(":")[0]
        matching = [kind for kind in EFFECTS.values() if fnmatch(kind.name, name)]
        if not matching:
            raise UnknownNameError("effect", pattern, EFFECTS)
        if pattern == name and all(kind.columns and kind.column_needed for kind in matching) and "*" not in pattern:
            raise UnknownNameError("effect", pattern, [f"{pattern}:*", f"{pattern}:COLUMN"])


def columns_of(kind: Kind, described: Describable) -> tuple[str, ...]:
    """Columns that an effect of this kind may be on, for a robot or equations; none where it has no column."""
    if kind.columns == "action":
        derived = ("thrust",) if "thrust" in getattr(described, "quantities", ()) and kind.substitute else ()
        return (*described.layouts.action, *derived)
    if kind.columns == "joint":
        return Body.of(described).joints
    if kind.columns == "site":
        quantities = getattr(described, "quantities", ())
        prefix = load_quantity("")
        return tuple(name.removeprefix(prefix) for name in quantities if name.startswith(prefix))
    if kind.columns == "state":
        fields = described.layouts.state.fields
        return tuple(column for field in fields if not field.hidden for column in field.columns)
    return ()
