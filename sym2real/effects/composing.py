"""Several effects into equations, in the one order that physics allows.

From the dynamics outwards: mass (scales forces), rate loop and motors (turn commands into thrust and torque; of a
car, tyres that lead it where its wheels do not point), wrench (adds forces), thrust (what a thrust command gives),
command (static maps), then filters, through which a command goes first; measurements last, outside the motion. Every
substitution replaces a symbol wherever it stands, so that the mass scales a wind, a centre of mass turns the thrust
that the battery gives, and so on.

The way of a command is that of a real actuator: firmware cuts off what it receives (limit), or drops it (dead zone);
the link and the driver hold it up (delay); the driver ramps it (rate limit); the actuator follows (lag); its linkage
has play (dead band); and the linkage's travel, trim and shape make the quantity that moves the robot (gain, offset,
curve).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from sympy import Expr, Integer

from sym2real.effects.body import Body
from sym2real.effects.bound import Effect
from sym2real.effects.kind import Stage
from sym2real.errors import ModelError
from sym2real.symbolic import Equations

ORDER: tuple[Stage, ...] = ("mass", "loop", "wrench", "thrust", "command", "filter", "measurement")
# The way of a command, and after it of a measurement, through effects with memory.
FILTER_ORDER = ("limit", "dead_zone", "delay", "rate_limit", "lag", "dead_band", "sensor_lag", "time_shift")

DELAY = "delay"
# A command meets gain, offset and the linkage's curve in this order, so that they go in from behind; else by name.
BEHIND = ("steering_curve", "speed_curve", "offset", "gain")

Chosen = tuple[Effect, Mapping[str, Expr | float]]


def compose(equations: Equations, effects: Iterable[Chosen]) -> Equations:
    """The equations with all the effects in them, whatever the order they are given in.

    Compose from equations without effects: what stands in equations already is nearer to the dynamics than what
    comes. Effects whose values are all null change nothing; those whose values are numbers are recorded in
    ``Equations.effects``.

    Args:
        equations: the base.
        effects: each with its values by parameter name: numbers, or expressions; symbols that the equations do not
            have become parameters, whose value is the null value.

    Raises:
        ModelError: when an effect does not apply, with the reason.
        UnknownNameError: for a parameter that an effect does not have.
    """
    effects = sorted(effects, key=lambda chosen: _depth(chosen[0]))
    known = [(effect.key, given) for effect, given in effects if _acts(effect, given)]
    for effect, values in sorted(_parts(effects), key=lambda chosen: _depth(chosen[0])):
        reason = effect.why_not(equations)
        if reason:
            raise ModelError(reason)
        if any(not _is(values[parameter.name], parameter.null) for parameter in effect.parameters):
            equations = _put_in(_with_parameters(equations, effect, values), effect, values)
    return replace(equations, effects=(*equations.effects, *known)) if known else equations


def _acts(effect: Effect, given: Mapping[str, Expr | float]) -> bool:
    """Whether all values are numbers, and not all of them null."""
    values = effect.values(given)
    numbers = all(value.is_number for value in values.values())
    return numbers and any(not _is(values[parameter.name], parameter.null) for parameter in effect.parameters)


def _is(value: Expr, number: float) -> bool:
    """Equality of numbers: SymPy's own holds 0 and 0.0 for two things."""
    return bool(value.is_number) and float(value) == number


def _depth(effect: Effect) -> tuple[int, int, str]:
    behind = BEHIND.index(effect.kind) if effect.kind in BEHIND else len(BEHIND)
    return ORDER.index(effect.stage), behind, effect.key


def _parts(effects: Iterable[Chosen]) -> Sequence[tuple[Effect, dict[str, Expr]]]:
    whole: list[tuple[Effect, dict[str, Expr]]] = []
    for effect, given in effects:
        values = effect.values(given)
        if effect.of.parts is None:
            whole.append((effect, values))
        else:
            whole += [
                (Effect(kind, effect.body), dict(part_values))
                for kind, part_values in effect.of.parts(values, effect.body)
            ]
    return whole


def _with_parameters(equations: Equations, effect: Effect, values: Mapping[str, Expr]) -> Equations:
    new: dict[str, float] = {}
    for parameter in effect.parameters:
        value = values[parameter.name]
        for symbol in value.free_symbols:
            if symbol.name not in equations.names:
                new.setdefault(symbol.name, parameter.null if value == symbol else 0.0)
    return replace(equations, parameters={**equations.parameters, **new}) if new else equations


def _put_in(equations: Equations, effect: Effect, values: Mapping[str, Expr]) -> Equations:
    if effect.of.substitute is not None:
        return effect.of.substitute(equations, values, Body.of(equations, effect.column))
    filters = [*equations.filters, (effect.key, values)]
    late = [given["value"] for key, given in filters if key == effect.key and effect.kind == DELAY]
    if late and all(value.is_number for value in late):  # delays add up
        filters = [change for change in filters if change[0] != effect.key]
        filters.append((effect.key, {"value": sum(late, Integer(0))}))
    return replace(equations, filters=tuple(sorted(filters, key=lambda change: place(change[0]))))


def place(key: str) -> int:
    """Of a filter among the others, by its effect's key."""
    return FILTER_ORDER.index(key.partition(":")[0])
