"""Errors of rollouts over several steps from every row of a log, by the recursion of ``leftover``."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from sym2real.neural.leftover import Leftover

# What a step changes by less than this share of the state's own change is rounding, whatever column it stands in.
FLOOR = 1e-5


def rolled_errors(error: Tensor, carried: Tensor, starts: Tensor, steps: int, first: Tensor | None = None) -> Tensor:
    """Errors ``# (steps, windows, t, count)`` after each step of every window, from the measured row on.

    Args:
        error: one-step errors of ``count`` models ``# (rows, t, count)``.
        carried: A ``# (rows, t, t)``.
        starts: first row of every window ``# (windows,)``; its ``steps`` rows follow each other.
        steps: of a window; 1 for the one-step error.
        first: in place of the error of every window's first row ``# (windows, t, count)``.
    """
    at = error[starts] if first is None else first
    errors = [at]
    for step in range(1, steps):
        at = torch.baddbmm(error[starts + step], carried[starts + step], at)
        errors.append(at)
    return torch.stack(errors)


@dataclass(frozen=True, eq=False)
class Scales:
    """What errors and residuals are divided by.

    Args:
        error: of the base after each step of a window, root mean square ``# (steps, 1, t, 1)``.
        residual: size of a useful residual of each state column ``# (n,)``.
    """

    error: Tensor
    residual: Tensor

    @classmethod
    def of(cls, rows: Leftover, starts: Tensor, steps: int) -> Scales:
        """Scales of the base's errors.

        What a model lacks in every step stays in the mean of one-step errors over a window, and noise of the measured
        state does not: a residual's scale is the least that such a mean is of, over all lengths up to the window's.
        Errors after many steps would not do: they hardly grow in what brakes itself, as a rate that a loop commands.
        """
        errors = rolled_errors(rows.error[..., None], rows.carried, starts, steps)
        floor = FLOOR * rows.change.square().mean(0).sqrt() + torch.finfo(torch.float32).tiny
        error = torch.maximum(errors.square().mean(1, keepdim=True).sqrt(), floor[:, None])
        window = rows.error[starts[:, None] + torch.arange(steps)]
        means = window.cumsum(1) / torch.arange(1, steps + 1)[:, None]
        per_step = torch.maximum(means.square().mean(0).sqrt().amin(0), floor)
        return cls(error, _columns_of(rows, per_step))


def _columns_of(rows: Leftover, tangent: Tensor) -> Tensor:
    """A scale per tangent component as one per state column: half an angle moves a quaternion's columns."""
    parts = []
    for field, places in zip(rows.layout.fields, rows.layout.tangent_places, strict=True):
        own = tangent[list(places)]
        if field.kind != "vector":
            size = own.square().mean().sqrt() * (0.5 if field.kind == "quaternion" else 1.0)
            own = size.expand(len(field.columns))
        parts.append(own)
    return torch.cat(parts)
