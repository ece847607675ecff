"""What networks' inputs are shifted and scaled by, and weights carried from one such scaling to another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from sym2real.layout import Layout
from sym2real.neural.networks import Networks
from sym2real.neural.residual_mlp import ResidualMLP

Layer = tuple[Tensor, Tensor]


@dataclass(frozen=True, eq=False)
class Normal:
    """Inputs are shifted and scaled, outputs scaled.

    Args:
        mean, scale: of what is seen ``# (seen,)``.
        output: ``# (n,)``.
    """

    mean: Tensor
    scale: Tensor
    output: Tensor

    @classmethod
    def of(cls, seen: Tensor, layouts: Sequence[Layout], output: Tensor) -> Normal:
        """Mean and size of rows ``# (rows, seen)`` whose columns are those of the layouts, one after the other.

        The columns of a field have one scale, their root mean square, and not what they deviate from their mean: a
        height that was held, or a steering that hardly varied on a circle, is not blown up until its noise looks like
        motion and what a planner tries looks like nothing that was ever seen.
        """
        squares, parts, place = seen.square().mean(0), list[Tensor](), 0
        for field in (field for layout in layouts for field in layout.fields):
            own = squares[place : place + len(field.columns)]
            place += len(field.columns)
            parts.append(own.mean().sqrt().expand(len(own)))
        scale = torch.cat(parts)
        return cls(seen.mean(0), torch.where(scale > 0, scale, 1.0), output)

    def __call__(self, seen: Tensor) -> Tensor:
        """Inputs as networks take them."""
        return (seen - self.mean) / self.scale

    @torch.no_grad()
    def begin_with(self, networks: Networks, raw: Sequence[Layer]) -> None:
        """Give every network the weights of one over raw columns.

        Args:
            networks: altered in place.
            raw: weights ``# (in, out)`` and biases ``# (out,)`` over raw inputs and outputs.
        """
        layers = list(raw)
        weight, bias = layers[0]
        layers[0] = (weight * self.scale[:, None], bias + self.mean @ weight)
        weight, bias = layers[-1]
        layers[-1] = (weight / self.output, bias / self.output)
        for (weight, bias), (new_weight, new_bias) in zip(networks.pairs(), layers, strict=True):
            weight.copy_(new_weight)
            bias.copy_(new_bias)

    @torch.no_grad()
    def write(self, layers: Sequence[Layer], residual: ResidualMLP, on: Tensor) -> None:
        """Give a residual the layers of a network over normalised columns; zero where ``on`` ``# (n,)`` is false."""
        output = torch.where(on, self.output, 0.0)
        values = {"input_mean": self.mean, "input_scale": self.scale, "output_scale": output}
        for place, (weight, bias) in enumerate(layers):
            values |= {f"linears.{place}.weight": weight.T, f"linears.{place}.bias": bias}
        residual.load_state_dict(values)
