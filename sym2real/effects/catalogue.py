"""The way from a key to an effect, and which effects apply to given equations."""

import difflib
import re
from collections.abc import Iterable, Iterator
from fnmatch import fnmatch

from sym2real.effects.body import Body, Describable
from sym2real.effects.bound import Effect
from sym2real.effects.groups import equivalents
from sym2real.effects.kind import Kind
from sym2real.effects.kinds import EFFECTS
from sym2real.errors import UnknownNameError
from sym2real.symbolic import Equations
from sym2real.vocabulary import ATTITUDE_COMMAND, ATTITUDE_COMMANDED, quantity_of

SPELT_LIKE = 0.8  # a slip of the hand; less alike are names of other things
MOST_NEAR = 8


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
    if name not in EFFECTS:
        raise unknown_effect(key, keys(described))
    kind = EFFECTS[name]
    columns = columns_of(kind, described)
    bound = colon or (columns and not kind.of_all(Body.of(described)))
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
    yield from (effect(key, equations) for key in keys(equations))


def keys(described: Describable) -> Iterator[str]:
    """Those of every effect that such a robot may have, one per column where a kind has columns."""
    body = Body.of(described)
    for name, kind in EFFECTS.items():
        columns = columns_of(kind, described)
        if kind.fits(body) and (not kind.columns or (columns and kind.of_all(body))):
            yield name
        yield from (f"{name}:{column}" for column in columns if kind.fits(body))


def unknown_effect(key: str, known: Iterable[str]) -> UnknownNameError:
    """An error for a key that is none: those of the known that are spelt like it, else that share most words with it.

    Whoever types ``steer_offset`` or ``steer`` means ``offset:steer``, or another effect on that column.
    """
    known, typed = tuple(dict.fromkeys(known)), _words(key)
    near = difflib.get_close_matches(key, known, n=3, cutoff=SPELT_LIKE)
    shared = max((len(typed & _words(other)) for other in known), default=0)
    if not near and shared:
        near = [other for other in known if len(typed & _words(other)) == shared][:MOST_NEAR]
    return UnknownNameError(
        "effect", key, known if near else {other.partition(":")[0] for other in known}, near or None
    )


def _words(key: str) -> set[str]:
    return {word for word in re.split(r"[^a-z0-9]+", key.lower()) if word}


def applicable(equations: Equations) -> tuple[Effect, ...]:
    """Every effect that the equations can be given."""
    return tuple(effect for effect in known(equations) if effect.applies(equations))


def always_alike(key: str, equations: Equations) -> tuple[str, ...]:
    """Effects of these equations that an effect stands for on every flight."""
    return tuple(effect.key for effect in known(equations) if effect.stood_for_by == key and effect.applies(equations))


def require_patterns(patterns: Iterable[str]) -> None:
    """Refuse keys, or patterns of keys, that no effect can match.

    Raises:
        UnknownNameError: for a kind that does not exist, or one that needs a column.
    """
    for pattern in patterns:
        name = pattern.partition(":")[0]
        matching = [kind for kind in EFFECTS.values() if fnmatch(kind.name, name)]
        if not matching:
            raise unknown_effect(pattern, EFFECTS)
        if pattern == name and all(kind.column_needed for kind in matching) and "*" not in pattern:
            raise UnknownNameError("effect", pattern, [f"{pattern}:*", f"{pattern}:COLUMN"])


def columns_of(kind: Kind, described: Describable) -> tuple[str, ...]:
    """Columns that an effect of this kind may be on, for a robot or equations; none where it has no column."""
    if kind.columns == "action":
        derived = ("thrust",) if "thrust" in getattr(described, "quantities", ()) and kind.substitute else ()
        attitude = {*ATTITUDE_COMMAND.columns} & {*described.layouts.action}
        whole = (ATTITUDE_COMMANDED,) if attitude and kind.of_attitude else ()
        return (*(column for column in described.layouts.action if column not in attitude), *whole, *derived)
    if kind.columns == "joint":
        return Body.of(described).joints
    if kind.columns == "parameter":
        return tuple(Body.of(described).parameters)
    if kind.columns == "site":
        quantities = getattr(described, "quantities", ())
        prefix = quantity_of("load", "")
        return tuple(name.removeprefix(prefix) for name in quantities if name.startswith(prefix))
    if kind.columns == "state":
        fields = described.layouts.state.fields
        return tuple(column for field in fields if not field.hidden for column in field.columns)
    return ()
