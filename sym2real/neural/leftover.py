"""What a frozen base leaves of transitions, and how an error of the state goes on from row to row.

In tangents of the measured states (``Layout.difference``), to first order in errors e and residual r::

    e_0 = 0,   e_k+1 = A_k e_k + d_k + G_k r(s_k, a_k),   d_k = f(s_k, a_k) ⊖ s_k+1,   B_k = ∂f/∂a

A, d and G follow from the base and the log alone, so that a rollout over many steps costs a training step hardly more
than a single one: the base is never called again. What is neglected is of second order in e, and vanishes as the
residual learns. A, B and G are central differences through the base in double precision.
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import torch
from torch import Tensor

from sym2real.dataset import Transitions
from sym2real.effects.along_logs import require_step
from sym2real.effects.filters import command_filters, filter_commands, hidden_along
from sym2real.effects.sensors import Sensors
from sym2real.errors import ShapeError
from sym2real.layout import Layout
from sym2real.neural.composed import Base, state_of
from sym2real.neural.ensemble import Ensemble
from sym2real.symbolic import Equations, build_module
from sym2real.trajectory import Array
from sym2real.vocabulary import is_push

STEP = 1e-5  # of central differences, in the columns' units: error about 1e-10 relative
TIME = "t"
Step = Callable[..., Tensor]


@dataclass(frozen=True, eq=False)
class Leftover:
    """Rows of a log as a residual is trained on them; n state columns, t tangent components.

    Args:
        layout: of the state.
        seen: what the residual sees: state, action, past ``# (rows, seen)``, float32.
        error: d, the base's one-step error ``# (rows, t)``, float32.
        moved: G ``# (rows, t, n)``, float32.
        carried: A ``# (rows, t, t)``, float32.
        turned: how the state's columns follow its tangent ``# (rows, n, t)``, float32.
        driven: B, how the next state follows the command ``# (rows, t, m)``, float32.
        change: of the measured state in a step ``# (rows, t)``, float32.
        runs: first and last-but-one row of every stretch of consecutive rows.
    """

    layout: Layout
    seen: Tensor
    error: Tensor
    moved: Tensor
    carried: Tensor
    turned: Tensor
    driven: Tensor
    change: Tensor
    runs: tuple[tuple[int, int], ...]

    def __len__(self) -> int:
        return len(self.error)


@torch.no_grad()
def leftover(transitions: Transitions, base: Base, commands: int = 0, states: int = 0) -> Leftover:
    """What a base leaves of transitions.

    Args:
        transitions: measured; taken are the states that the sensors mean and the commands that filters let through.
        base: stays as it is.
        commands, states: past rows that the residual sees.

    Raises:
        ShapeError: when the columns or the time step are not the base's, or an input is missing that it uses.
    """
    layout, runs = state_of(base), runs_of(transitions)
    state, following, action, step = _steps(transitions, base, runs)
    predicted = step(state, action)
    tangents = torch.eye(layout.tangent_size, dtype=torch.float64) * STEP
    columns = torch.eye(len(layout), dtype=torch.float64) * STEP
    commanded = torch.eye(action.shape[-1], dtype=torch.float64) * STEP

    def away(prediction: Tensor) -> Tensor:
        return layout.difference(layout.normalise(prediction), following)

    def carried(move: Tensor) -> Tensor:
        return away(step(layout.retract(state, move.expand(len(state), -1)), action))

    past = torch.as_tensor(replace(transitions, state=state.numpy(), action=action.numpy()).past(commands, states))
    return Leftover(
        layout=layout,
        seen=torch.cat([state, action, past], dim=-1).float(),
        error=away(predicted).float(),
        moved=_slopes(lambda move: away(predicted + move), columns),
        carried=_slopes(carried, tangents),
        turned=_slopes(lambda move: layout.retract(state, move.expand(len(state), -1)), tangents),
        driven=_slopes(lambda move: away(step(state, action + move)), commanded),
        change=layout.difference(following, state).float(),
        runs=runs,
    )


def errors_by_parameters(transitions: Transitions, base: Equations) -> Callable[[Tensor], Tensor]:
    """One-step errors of equations ``# (rows, t, sets)``, float32, under parameter sets ``# (sets, P)``.

    Measured states, filtered commands and hidden states are taken as of :func:`leftover`, at the values that the
    parameters have. Errors as of :func:`leftover`.
    """
    layout = state_of(base)
    state, following, action, step = _steps(transitions, base, runs_of(transitions))

    def errors(sets: Tensor) -> Tensor:
        predicted = step(state, action, sets[:, None]).expand(len(sets), -1, -1)
        return layout.difference(layout.normalise(predicted), following).permute(1, 2, 0).float()

    return errors


def _slopes(function: Callable[[Tensor], Tensor], moves: Tensor) -> Tensor:
    """Central differences ``# (rows, out, moves)``."""
    slopes = [(function(move) - function(-move)) / (2.0 * STEP) for move in moves]
    return torch.stack(slopes, dim=-1).float()


def require_columns(transitions: Transitions, base: Base) -> None:
    """Refuse transitions of other columns than the base's, or of another time step.

    Raises:
        ShapeError: with both.
    """
    for name, wanted in (("state", state_of(base)), ("action", base.layouts.action)):
        given = getattr(transitions.layouts, name)
        if given.columns != wanted.columns:
            raise ShapeError(f"the base's {name} columns are {wanted.columns}, the transitions' are {given.columns}")
    require_step(base.dt, transitions.dt)


def runs_of(transitions: Transitions) -> tuple[tuple[int, int], ...]:
    """``(first, end)`` of every stretch of consecutive rows of one trajectory."""
    breaks = (np.diff(transitions.trajectory) != 0) | (np.diff(transitions.step) != 1)
    edges = [0, *(np.flatnonzero(breaks) + 1).tolist(), len(transitions)]
    return tuple((first, end) for first, end in pairwise(edges) if end > first)


def _meant(measured: Array, base: Base) -> Tensor:
    """States that the sensors mean."""
    values = torch.as_tensor(measured)
    return Sensors(base).state(values) if isinstance(base, Equations) else values


def _reached(transitions: Transitions, base: Base, runs: tuple[tuple[int, int], ...]) -> Tensor:
    """Commands that reach the robot when it delays, limits or smooths them as the equations say."""
    action = torch.as_tensor(transitions.action)
    if not isinstance(base, Equations) or not command_filters(base):
        return action
    return torch.cat([filter_commands(base, action[first:end]) for first, end in runs])


def _inputs(transitions: Transitions, base: Base) -> Tensor | None:
    """Inputs of the equations by name: time from the trajectory's start, forces of zero where the log has none."""
    if not isinstance(base, Equations) or not len(base.layouts.inputs):
        return None
    columns = list[Array]()
    for name in base.layouts.inputs:
        if name in transitions.layouts.inputs:
            columns.append(transitions.inputs[:, transitions.layouts.inputs.index(name)])
        elif name == TIME or is_push(name):
            since = transitions.dt if name == TIME else 0.0
            columns.append(np.asarray(transitions.step * since, dtype=np.float64))
        else:
            raise ShapeError(f"the base's equations use the input {name!r}, which the transitions do not hold")
    return torch.as_tensor(np.stack(columns, axis=1))


def _steps(
    transitions: Transitions, base: Base, runs: tuple[tuple[int, int], ...]
) -> tuple[Tensor, Tensor, Tensor, Step]:
    """States, those that followed, commands that reached the robot ``# (rows, …)``, and the base's step from there.

    The step goes from states ``# (rows, n)`` under commands ``# (rows, m)``, inputs being those of the rows, and for
    equations under parameter sets.
    """
    require_columns(transitions, base)
    state, following = (_meant(values, base) for values in (transitions.state, transitions.next_state))
    action, inputs = _reached(transitions, base, runs), _inputs(transitions, base)
    if isinstance(base, Ensemble):
        frozen: Ensemble = copy.deepcopy(base).double().requires_grad_(False)
        return state, following, action, frozen
    module, size, parts = build_module(base).double(), state.shape[-1], list[Tensor]()
    for first, end in runs:  # hidden states begin with every run, and go on beneath the measured ones
        known = None if inputs is None else inputs[first:end]
        parts.append(hidden_along(base, module, state[first:end], action[first:end], known))
    hidden = torch.cat(parts)

    def step(values: Tensor, commands: Tensor, sets: Tensor | None = None) -> Tensor:
        following: Tensor = module(torch.cat([values, hidden], dim=-1), commands, inputs, sets)[..., :size]
        return following

    return state, following, action, step
