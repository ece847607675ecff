"""Filters that equations carry: over a whole log, and step by step in a controller.

A controller that plans with such equations puts its candidates through :meth:`FilterState.apply` before the model sees
them, and calls :meth:`FilterState.remember` with what was sent.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache

import torch
from sympy import Expr, Float
from torch import Tensor

from sym2real.effects.bound import Effect
from sym2real.effects.catalogue import effect
from sym2real.effects.memory import as_given, replaced
from sym2real.effects.terms import without_quantities
from sym2real.errors import ModelError
from sym2real.symbolic import Equations, compile_function, symbol
from sym2real.symbolic.expressions import exchange

Step = Callable[[Tensor, Tensor, Tensor | None], Tensor]


def command_filters(equations: Equations) -> list[tuple[Effect, Mapping[str, Expr]]]:
    """Filters that commands go through, in this order."""
    return [pair for pair in _filters(equations) if pair[0].of.columns == "action"]


def measurement_filters(equations: Equations) -> list[tuple[Effect, Mapping[str, Expr]]]:
    """Filters that measurements go through, in this order; a controller cannot undo them."""
    return [pair for pair in _filters(equations) if pair[0].of.columns == "state"]


def _filters(equations: Equations) -> list[tuple[Effect, Mapping[str, Expr]]]:
    return [(effect(key, equations), values) for key, values in equations.filters]


def filter_commands(equations: Equations, actions: Tensor, dt: float | None = None) -> Tensor:
    """What of the commands of a whole log reaches the robot.

    Args:
        equations: with filters.
        actions: ``# (..., T, action)``.
        dt: time between two commands in s; that of the equations by default.
    """
    for command_filter, values in command_filters(equations):
        actions = command_filter.filter(actions, dt or equations.dt, numbers(equations, values))
    return actions


def numbers(equations: Equations, values: Mapping[str, Expr]) -> dict[str, float]:
    """Values of an effect as numbers.

    Raises:
        ModelError: for an expression that is neither a number nor a parameter.
    """
    result: dict[str, float] = {}
    for name, value in values.items():
        if value.is_number:
            result[name] = float(value)
        elif value.is_Symbol and value.name in equations.parameters:
            result[name] = equations.parameters[value.name]
        else:
            raise ModelError(f"a filter's value must be a number or a parameter, found {name} = {value}")
    return result


class FilterState:
    """Memory of the command filters of equations while commands are sent one by one.

    Args:
        equations: with filters; without, :meth:`apply` gives back what it gets.
    """

    def __init__(self, equations: Equations) -> None:
        self.dt = equations.dt
        self.filters = [(effect, numbers(equations, values)) for effect, values in command_filters(equations)]
        self.reset()

    def reset(self) -> None:
        """Forget what was sent: the next command is taken to have been held for ever."""
        self.memories: list[Tensor] = []  # one per filter; none before the first command was sent

    def remember(self, sent: Tensor) -> Tensor:
        """Advance by one command ``# (action,)``; what of it reaches the robot ``# (action,)``."""
        self.memories, reaching = self._run(sent[None, :])
        return reaching[0]

    def apply(self, actions: Tensor) -> Tensor:
        """What of the commands that might follow ``# (..., H, action)`` would reach the robot; nothing is advanced."""
        return self._run(actions)[1]

    def _run(self, actions: Tensor) -> tuple[list[Tensor], Tensor]:
        memories = []
        for position, (command_filter, values) in enumerate(self.filters):
            given, columns = as_given(values, actions), command_filter.filtered_columns
            rows = actions[..., columns]
            if self.memories:
                memory = self.memories[position].to(actions)
            else:
                memory = command_filter.memory.begin(rows[..., 0, :], self.dt, given)
            memory, output = command_filter.memory.run(memory, rows, self.dt, given)
            memories.append(memory)
            actions = replaced(actions, columns, output)
        return memories, actions


def with_hidden_start(equations: Equations, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
    """States of the equations ``# (..., n)`` for states without their hidden columns; those that have them stay.

    Args:
        equations: hidden columns last, as effects add them.
        state: measured columns ``# (..., n - hidden)``.
        action: the first action ``# (..., action)``.
        inputs: ``# (..., inputs)``; None for zeros.
    """
    layouts = equations.layouts
    if state.shape[-1] == len(layouts.state):
        return state
    if inputs is None:
        inputs = state.new_zeros(*state.shape[:-1], len(layouts.inputs))
    columns = [layouts.state.columns[: state.shape[-1]], layouts.action.columns, layouts.inputs.columns]
    given = [(names, values) for names, values in zip(columns, (state, action, inputs), strict=True) if len(names)]
    first = tuple(spelled_out(equations, expression) for expression in equations.start.values())
    hidden = _function_of(first, tuple(names for names, _ in given))(*(values for _, values in given))
    batch = torch.broadcast_shapes(state.shape[:-1], hidden.shape[:-1])
    return torch.cat([state.expand(*batch, -1), hidden.expand(*batch, -1)], dim=-1)


def hidden_along(
    equations: Equations, step: Step, states: Tensor, actions: Tensor, inputs: Tensor | None = None
) -> Tensor:
    """Hidden states in every row of a stretch ``# (..., T, hidden)``: they go on beneath the measured ones.

    Args:
        equations: say what they begin with in the first row.
        step: from whole states ``# (..., n)`` to the next ones, under actions and inputs.
        states: measured ``# (..., T, n - hidden)``.
        actions: that reach the robot ``# (..., T, action)``.
        inputs: ``# (..., T, inputs)``; None for zeros.
    """
    given = [None if inputs is None else inputs[..., row, :] for row in range(states.shape[-2])]
    whole = with_hidden_start(equations, states[..., 0, :], actions[..., 0, :], given[0])
    size = states.shape[-1]
    hidden = [whole[..., size:]]
    for row in range(1, states.shape[-2] if equations.start else 1):
        hidden.append(step(whole, actions[..., row - 1, :], given[row - 1])[..., size:])
        whole = torch.cat([states[..., row, :], hidden[-1]], dim=-1)
    return torch.stack(hidden, dim=-2).expand(*states.shape[:-1], -1)


@lru_cache(maxsize=16)
def _function_of(expressions: tuple[Expr, ...], columns: tuple[tuple[str, ...], ...]) -> torch.jit.ScriptModule:
    """Kept, because every rollout begins with it and compiling takes 13 ms; training makes equations anew each time."""
    return compile_function(expressions, columns)


def spelled_out(equations: Equations, expression: Expr) -> Expr:
    """The expression over columns alone: quantities put in, parameters at their values."""
    values = {symbol(name): Float(value) for name, value in equations.parameters.items()}
    return exchange(values)(without_quantities(equations, expression))
