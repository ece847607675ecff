"""Which effects equations have already: in words, and as changes that a simulated robot needs to have them too."""

from collections.abc import Mapping

from sym2real.effects.body import Body, Describable
from sym2real.effects.bound import Effect
from sym2real.effects.catalogue import effect
from sym2real.effects.composing import place
from sym2real.effects.kind import Parameter, with_unit
from sym2real.effects.kinds import EFFECTS
from sym2real.effects.voltage import VOLTAGE
from sym2real.errors import ModelError
from sym2real.protocols import Change
from sym2real.symbolic import Equations

# Begins the key of a term of one's own, which no catalogue has.
TERM = "term:"

Known = tuple[tuple[str, Mapping[str, float]], ...]


def noted(equations: Equations) -> tuple[str, ...]:
    """The effects that equations have, each as ``KEY PARAMETER=VALUE UNIT, …``, the first one first; without terms."""
    notes = []
    for key, values in equations.effects:
        if not key.startswith(TERM):
            known = [parameter for parameter in _parameters(key, equations) if parameter.name in values]
            numbers = (
                f"{parameter.name}={with_unit(values[parameter.name], parameter.unit, 4)}" for parameter in known
            )
            notes.append(f"{key} {', '.join(numbers)}")
    return tuple(notes)


def _parameters(key: str, equations: Equations) -> tuple[Parameter, ...]:
    """Numbers of an effect; a parameter that was scaled may have become a number of the equations since."""
    kind, _, column = key.partition(":")
    return Effect(EFFECTS[kind], Body.of(equations, column)).parameters


def as_simulated(equations: Equations) -> Known:
    """The effects that equations have, in the order in which a simulated robot must be given them.

    A command meets what went into equations last first, behind the filters, which have an order of their own; a
    measurement the other way round.

    Raises:
        ModelError: for what a simulated robot does not have, or not beside another one.
    """
    _require_counterparts(equations)
    changes = [(effect(key, equations), values) for key, values in equations.effects]
    filters = [change for change in changes if change[0].of.memory is not None]
    filters.sort(key=lambda change: place(change[0].key))
    static = [change for change in changes if change[0].of.memory is None]
    moving = [change for change in reversed(static) if change[0].stage != "measurement"]
    measured = [change for change in static if change[0].stage == "measurement"]
    before = [change for change in filters if change[0].stage != "measurement"]
    after = [change for change in filters if change[0].stage == "measurement"]
    return tuple((change.key, values) for change, values in (*before, *moving, *measured, *after))


def injected(equations: Equations, robot: Describable) -> tuple[Change, ...]:
    """The changes that give a plain simulated robot the effects that equations have; errors of :func:`as_simulated`."""
    return tuple(effect(key, robot).inject(**values) for key, values in as_simulated(equations))


def _require_counterparts(equations: Equations) -> None:
    keys = [key for key, _ in equations.effects]
    for key in keys:
        if key.startswith(TERM):
            raise ModelError(f"a term of one's own has no counterpart there ({key.removeprefix(TERM)})")
        if EFFECTS[key.partition(":")[0]].columns == "parameter":
            raise ModelError(f"a parameter of one's own equations has no counterpart there ({key.partition(':')[2]})")
    if VOLTAGE in equations.layouts.inputs and "battery_sag" in keys:
        raise ModelError("its battery has no voltage that the thrust could sag with")
