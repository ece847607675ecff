"""All candidate effects in one set of equations, each at its null value until a parameter set says otherwise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import torch
from sympy import Expr, Symbol
from torch import Tensor

from sym2real.effects import Effect, compose, effect
from sym2real.effects.inputs import ANGLE
from sym2real.effects.kind import Parameter
from sym2real.effects.terms import shielded
from sym2real.symbolic import Equations, compile_function, compile_model, symbol
from sym2real.symbolic.period import at_period, steps_within


@dataclass(frozen=True)
class Slot:
    """A parameter of the problem, the effect that it is of ("" where it is of none), and its name in the equations."""

    effect: str
    parameter: Parameter
    symbol: str


@dataclass(frozen=True, eq=False)
class Library:
    """Equations with every candidate effect in them.

    Args:
        base: without them.
        equations: all effects at their null values.
        effects: the candidates by key; where one is of several kinds (which rotor), by key and number.
        slots: the parameters that can be fitted, in the order of a parameter set.
        form: equations that differ in values of parameters alone, and whose compiled functions serve these, too.
    """

    base: Equations
    equations: Equations
    effects: dict[str, Effect]
    slots: tuple[Slot, ...]
    form: Equations

    @classmethod
    def of(cls, base: Equations, effects: Sequence[Effect]) -> Library:
        """The base with these effects, their fitted parameters free.

        An effect with a phase of its own in every log swings with the logs' column :data:`ANGLE`; one that is a
        choice among few is there once for each.
        """
        named, slots, chosen = dict[str, Effect](), list[Slot](), []
        for own in effects:
            if own.searching.swings:
                base = replace(base, layouts=base.layouts.with_input(ANGLE))
            for name, given in _settled(own):
                named[name] = own
                fitted = {p: _symbol(own, name, p.name) for p in own.parameters if p.fitted and p.name not in given}
                chosen.append((own, {**given, **{p.name: free for p, free in fitted.items()}}))
                slots += [Slot(name, p, free.name) for p, free in fitted.items()]
        equations = compose(shielded(base), chosen)
        return cls(base, equations, named, tuple(slots), equations)

    def at(self, **values: float) -> Library:
        """The same with other values of the base's parameters; nothing is composed or compiled anew."""
        both = self.base, self.equations
        base, equations = (replace(given, parameters={**given.parameters, **values}) for given in both)
        return replace(self, base=base, equations=equations)

    @cached_property
    def columns(self) -> tuple[int, ...]:
        """Place of every slot among the parameters of the equations."""
        names = list(self.equations.parameters)
        return tuple(names.index(slot.symbol) for slot in self.slots)

    def choice(self, name: str) -> dict[str, float]:
        """What is settled of an effect that is a choice among few, by parameter."""
        choices = self.effects[name].searching.choices if name in self.effects else None
        return {} if choices is None else {choices(self.effects[name].body)[0]: float(name.partition(" ")[2])}

    def key(self, name: str) -> str:
        """Of the effect that stands here under a name."""
        return self.effects[name].key if name in self.effects else name

    def indices(self, *keys: str) -> tuple[int, ...]:
        """Slots of effects."""
        return tuple(i for i, slot in enumerate(self.slots) if slot.effect in keys)

    @property
    def null(self) -> Tensor:
        """``# (P,)``."""
        return torch.tensor([slot.parameter.null for slot in self.slots], dtype=torch.float64)

    @cached_property
    def scale(self) -> Tensor:
        """``# (P,)``."""
        return torch.tensor([slot.parameter.scale for slot in self.slots], dtype=torch.float64)

    @cached_property
    def bounds(self) -> tuple[Tensor, Tensor]:
        """``# (P,)`` each."""
        low = torch.tensor([slot.parameter.low for slot in self.slots], dtype=torch.float64)
        return low, torch.tensor([slot.parameter.high for slot in self.slots], dtype=torch.float64)

    def model(self, dt: float) -> torch.jit.ScriptModule:
        """(state, commands, inputs, parameters) → state ``dt`` s later, in float64; commands of :meth:`parts` parts."""
        return _in_double(at_period(self.form, dt, apart=True))

    def parts(self, dt: float) -> int:
        """Parts of a row of ``dt`` s, each with commands of its own."""
        return steps_within(self.equations, dt)

    @cached_property
    def measuring(self) -> tuple[int, ...] | None:
        """Slots without whose effects measurements are the state itself; None where the base's are not."""
        if self.base.output:
            return None
        return self.indices(*(key for key, effect in self.effects.items() if effect.stage == "measurement"))

    @cached_property
    def remembering(self) -> tuple[int, ...] | None:
        """Slots without whose effects hidden states do not matter; None where the base has hidden states itself."""
        if any(field.hidden for field in self.base.layouts.state.fields):
            return None
        state = {*self.equations.layouts.state}
        return self.indices(*(key for key, own in self.effects.items() if state & {*own.of.hidden, *own.of.shared}))

    def busy(self, sets: Tensor, slots: Sequence[int] | None) -> Tensor:
        """Which parameter sets ``# (B, P)`` have any of the slots away from null; all for None."""
        if slots is None:
            return torch.ones(len(sets), dtype=torch.bool)
        return (sets[:, list(slots)] != self.null[list(slots)]).any(dim=1)


@lru_cache(maxsize=8)
def library_of(equations: Equations, keys: tuple[str, ...]) -> Library:
    """The equations with these effects; kept, because composing and compiling takes longer than a search."""
    return Library.of(equations, [effect(key, equations) for key in keys])


def _settled(effect: Effect) -> list[tuple[str, dict[str, Expr | float]]]:
    """Names under which an effect competes, with the values that it has there."""
    if effect.searching.choices is None:
        return [(effect.key, dict(effect.searching.given))]
    parameter, numbers = effect.searching.choices(effect.body)
    return [(f"{effect.key} {number:g}", {parameter: number}) for number in numbers]


def _symbol(effect: Effect, name: str, parameter: str) -> Symbol:
    plain = effect.symbols()[parameter]
    number = name.partition(" ")[2]
    return symbol(f"{plain.name}_{number}") if number else plain


_in_double = lru_cache(maxsize=64)(partial(compile_model, dtype=torch.float64))


@lru_cache(maxsize=64)
def output_of(equations: Equations) -> torch.jit.ScriptModule | None:
    """(state, parameters) → what is measured, where an effect changes that."""
    if not equations.output:
        return None
    state = equations.layouts.state
    expressions = [equations.output.get(column, symbol(column)) for column in state]
    return compile_function(expressions, [group for group in (state.columns, tuple(equations.parameters)) if group])


@lru_cache(maxsize=64)
def hidden_start_of(equations: Equations) -> torch.jit.ScriptModule | None:
    """(state, action, inputs, parameters) → first values of hidden states."""
    if not equations.start:
        return None
    layouts = equations.layouts
    groups = [layouts.state.columns, layouts.action.columns, layouts.inputs.columns, tuple(equations.parameters)]
    return compile_function([*equations.start.values()], [group for group in groups if group], equations.quantities)
