"""A residual network in the fused step: text for its sizes, weights as data (retraining compiles nothing)."""

from __future__ import annotations

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
    widest = -(-max(sizes[1:]) // 16) * 16  # room for whole tiles
    lines = ["APART void residual(const real *w, const v *x, v *y) {", f"    v a[{widest}], b[{widest}];"]
    here, there = "x", "a"
    for place, (inputs, outputs) in enumerate(pairwise(sizes)):
        last = place == len(sizes) - 2
        lines.append(f"    w = layer(w, {here}, {inputs}, {'y' if last else there}, {outputs}, {int(last)});")
        here, there = there, "b" if there == "a" else "a"
    return "\n".join([*lines, "}"])


def residual_lines(state: Sequence[str], actions: Sequence[str]) -> list[str]:
    """Statements of one step: ``residual_<column>`` of the state columns that a log holds, and the acting action."""
    columns = [*state, *actions]
    size = -(-len(state) // 16) * 16
    return [
        f"v seen[{len(columns)}] = {{{', '.join(f'x_{column}' for column in columns)}}}, left[{size}];",
        "residual(p->weights, seen, left);",
        *(f"const v residual_{column} = left[{i}];" for i, column in enumerate(state)),
    ]


def sizes_of(residual: Residual) -> tuple[int, ...]:
    """Inputs, widths of the hidden layers, outputs."""
    layers = residual.layers()
    return (layers[0][0].shape[0], *(weight.shape[1] for weight, _ in layers))


def packed(residual: Residual, tile: int) -> NDArray[np.float32]:
    """Weights in the order of ``network.h``; the last tile of a layer is filled up with zeros."""
    parts = []
    for weight, bias in residual.layers():
        rows = np.concatenate([bias[None].double().cpu().numpy(), weight.double().cpu().numpy()])
        missing = -rows.shape[1] % tile
        rows = np.pad(rows, ((0, 0), (0, missing)))
        parts += [rows[:, first : first + tile].reshape(-1) for first in range(0, rows.shape[1], tile)]
    return np.concatenate(parts).astype(np.float32)
