"""A residual network in the fused step: text for its sizes, weights as data (retraining compiles nothing)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from torch import Tensor


class Residual(Protocol):
    """What the kernel needs to know of a residual: layers over (state, action, past) with ReLU in between."""

    commands: int
    states: int

    def layers(self) -> list[tuple[Tensor, Tensor]]:
        """Weights ``# (in, out)`` and biases ``# (out,)``."""


@dataclass(frozen=True)
class Network:
    """What of a residual is in the text.

    Args:
        sizes: inputs, widths of the hidden layers, outputs.
        commands: past commands among the inputs, behind state and action.
        states: past states, behind those.
    """

    sizes: tuple[int, ...]
    commands: int
    states: int

    @classmethod
    def of(cls, residual: Residual) -> Network:
        """That of a residual."""
        layers = residual.layers()
        sizes = (layers[0][0].shape[0], *(weight.shape[1] for weight, _ in layers))
        return cls(sizes, residual.commands, residual.states)


def residual_text(sizes: Sequence[int]) -> str:
    """C function ``residual(weights, x, y)`` for layers of these sizes, inputs first, outputs last."""
    room = f"ROOM({max(sizes[1:])})"
    lines = ["APART void residual(const real *w, const v *x, v *y) {", f"    v a[{room}], b[{room}];"]
    here, there = "x", "a"
    for place, (inputs, outputs) in enumerate(pairwise(sizes)):
        last = place == len(sizes) - 2
        lines.append(f"    w = layer(w, {here}, {inputs}, {'y' if last else there}, {outputs}, {int(last)});")
        here, there = there, "b" if there == "a" else "a"
    return "\n".join([*lines, "}"])


def residual_lines(network: Network, state: Sequence[str], actions: Sequence[str]) -> tuple[list[str], list[str]]:
    """Statements ahead of a rollout, and those of each step.

    Args:
        network: how much of the past it sees.
        state: columns that a log holds; ``residual_<column>`` is what the network adds to them.
        actions: columns; the network sees those that act.
    """
    begin, move, repeat = _past_lines(network, state, len(actions))
    room = f"v seen[{network.sizes[0]}], left[ROOM({len(state)})];"
    now = [f"seen[{i}] = x_{column};" for i, column in enumerate((*state, *actions))]
    added = [f"const v residual_{column} = left[{i}];" for i, column in enumerate(state)]
    return [room, *begin], [*move, *now, *repeat, "residual(p->weights, seen, left);", *added]


def _past_lines(network: Network, state: Sequence[str], actions: int) -> tuple[list[str], list[str], list[str]]:
    """Statements that begin the past, move it by the last row ahead of a new one, and repeat the first row in it."""
    size = len(state)
    commands, states = network.commands * actions, network.states * size
    sent, seen = size + actions, size + actions + commands
    begin, move, repeat = [], [], []
    if states:
        for place, column in enumerate(state):
            row = f"for (int i = {place}; i < {states}; i += {size}) seen[{seen} + i]"
            begin.append(f"{row} = p->begun ? splat(p->past[{commands} + i]) : x_{column};")
        move += [f"for (int i = {states}; h && i-- > {size};) seen[{seen} + i] = seen[{seen - size} + i];"]
        move += [f"for (int i = 0; h && i < {size}; i++) seen[{seen} + i] = seen[i];"]
    if commands:
        begin += [f"for (int i = 0; i < {commands}; i++) seen[{sent} + i] = splat(p->begun ? p->past[i] : R(0.0));"]
        move += [f"for (int i = {commands}; h && i-- > 0;) seen[{sent} + i] = seen[{size} + i];"]
        first = f"for (int i = 0; h == 0 && !p->begun && i < {commands}; i++)"
        repeat += [f"{first} seen[{sent} + i] = seen[{size} + i];"]
    return begin, move, repeat


def packed(residual: Residual, most: int) -> NDArray[np.float32]:
    """Weights in the order of ``network.h``, whose tiles have at most so many outputs; the last one is filled up."""
    parts = []
    for weight, bias in residual.layers():
        rows = np.concatenate([bias[None].double().cpu().numpy(), weight.double().cpu().numpy()])
        outputs = rows.shape[1]
        tile = math.ceil(outputs / math.ceil(outputs / most))
        missing = -outputs % tile
        rows = np.pad(rows, ((0, 0), (0, missing)))
        parts += [rows[:, first : first + tile].reshape(-1) for first in range(0, rows.shape[1], tile)]
    return np.concatenate(parts).astype(np.float32)
