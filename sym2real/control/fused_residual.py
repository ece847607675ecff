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
        ...


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
    room = f"ROOM({max(sizes[1:])}) * BLOCKS"
    lines = ["APART void residual(const real *w, const v *x, v *y) {", f"    v a[{room}], b[{room}];"]
    here, there = "x", "a"
    for place, (inputs, outputs) in enumerate(pairwise(sizes)):
        last = place == len(sizes) - 2
        lines.append(f"    w = layer(w, {here}, {inputs}, {'y' if last else there}, {outputs}, {int(last)});")
        here, there = there, "b" if there == "a" else "a"
    return "\n".join([*lines, "}"])


def residual_lines(
    network: Network, state: Sequence[str], actions: Sequence[str]
) -> tuple[list[str], list[str], list[str]]:
    """Statements ahead of a rollout; of each step, a block's ahead of the network and behind it.

    Args:
        network: how much of the past it sees.
        state: columns that a log holds; ``residual_<column>`` is what the network adds to them.
        actions: columns; the network sees those that act.
    """
    columns = [*state, *actions]
    begin, move, repeat = _past_lines(network, len(state), len(actions))
    room = f"v seen[{network.sizes[0]} * BLOCKS], left[ROOM({len(state)}) * BLOCKS];"
    ahead = [f"seen[{i} * BLOCKS + b] = x_{column};" for i, column in enumerate(columns)]
    behind = [f"const v residual_{column} = left[{i} * BLOCKS + b];" for i, column in enumerate(state)]
    return [room, *begin], [*move, *ahead, *repeat], behind


def _past_lines(network: Network, size: int, actions: int) -> tuple[list[str], list[str], list[str]]:
    """Statements that begin the past, move it by the last row ahead of a new one, and repeat the first row in it."""
    commands, states = network.commands * actions, network.states * size
    sent, seen = size + actions, size + actions + commands

    def at(place: str) -> str:
        return f"seen[({place}) * BLOCKS + b]"

    begin, move, repeat = [], [], []
    if states:
        known = f"p->begun ? p->past[{commands} + i] : p->state[i % {size}]"
        begin += [f"EACH_BLOCK for (int i = 0; i < {states}; i++) {at(f'{seen} + i')} = splat({known});"]
        older = f"for (int i = {states}; h && i-- > {size};)"
        move += [f"{older} {at(f'{seen} + i')} = {at(f'{seen - size} + i')};"]
        move += [f"for (int i = 0; h && i < {size}; i++) {at(f'{seen} + i')} = {at('i')};"]
    if commands:
        known = "p->begun ? p->past[i] : R(0.0)"
        begin += [f"EACH_BLOCK for (int i = 0; i < {commands}; i++) {at(f'{sent} + i')} = splat({known});"]
        move += [f"for (int i = {commands}; h && i-- > 0;) {at(f'{sent} + i')} = {at(f'{size} + i')};"]
        first = f"for (int i = 0; h == 0 && !p->begun && i < {commands}; i++)"
        repeat += [f"{first} {at(f'{sent} + i')} = {at(f'{size} + i')};"]
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
