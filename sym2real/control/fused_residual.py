"""A residual network in the fused step: text for its sizes, weights as data (retraining compiles nothing)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from torch import Tensor


class Residual(Protocol):
    """What the kernel needs to know of a residual: layers over (state, action) with ReLU in between."""

    def layers(self) -> list[tuple[Tensor, Tensor]]:
        """Weights ``# (in, out)`` and biases ``# (out,)``."""
        ...


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


def residual_lines(state: Sequence[str], actions: Sequence[str]) -> tuple[list[str], list[str], list[str]]:
    """Declarations of a rollout; of each step, a block's statements ahead of the network and behind it.

    Args:
        state: columns that a log holds; ``residual_<column>`` is what the network adds to them.
        actions: columns; the network sees those that act.
    """
    columns = [*state, *actions]
    room = f"v seen[{len(columns)} * BLOCKS], left[ROOM({len(state)}) * BLOCKS];"
    ahead = [f"seen[{i} * BLOCKS + b] = x_{column};" for i, column in enumerate(columns)]
    behind = [f"const v x_{column} = seen[{i} * BLOCKS + b];" for i, column in enumerate(columns) if i >= len(state)]
    behind += [f"const v residual_{column} = left[{i} * BLOCKS + b];" for i, column in enumerate(state)]
    return [room], ahead, behind


def sizes_of(residual: Residual) -> tuple[int, ...]:
    """Inputs, widths of the hidden layers, outputs."""
    layers = residual.layers()
    return (layers[0][0].shape[0], *(weight.shape[1] for weight, _ in layers))


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
