"""What networks' inputs are shifted and scaled by, and weights carried from one such scaling to another."""

from __future__ import annotations

from collections.abc import Container, Sequence
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
        kept: places of what is seen among raw columns ``# (seen,)``.
    """

    mean: Tensor
    scale: Tensor
    output: Tensor
    kept: Tensor

    @classmethod
    def of(cls, raw: Tensor, layouts: Sequence[Layout], output: Tensor, unseen: Container[str] = ()) -> Normal:
        """Mean and size of rows ``# (rows, raw)`` whose columns are those of the layouts, one after the other.

        The columns of a field have one scale, their root mean square, and not what they deviate from their mean: a
        height that was held, or a steering that hardly varied on a circle, is not blown up until its noise looks like
        motion and what a planner tries looks like nothing that was ever seen.

        Args:
            raw, layouts: rows and what their columns are.
            output: what outputs are scaled by ``# (n,)``.
            unseen: columns that networks do not see.
        """
        squares, parts, kept, place = raw.square().mean(0), list[Tensor](), list[int](), 0
        for field in (field for layout in layouts for field in layout.fields):
            own = [place + number for number, column in enumerate(field.columns) if column not in unseen]
            place += len(field.columns)
            kept += own
            parts.append(squares[own].mean().sqrt().expand(len(own)))
        scale = torch.cat(parts)
        return cls(raw[:, kept].mean(0), torch.where(scale > 0, scale, 1.0), output, torch.tensor(kept))

    def __call__(self, raw: Tensor) -> Tensor:
        """Inputs as networks take them."""
        return (raw[:, self.kept] - self.mean) / self.scale

    @torch.no_grad()
    def begin_with(self, networks: Networks, raw: Sequence[Layer], which: Tensor) -> None:
        """Give some of the networks the weights of one over raw columns.

        Args:
            networks: altered in place.
            raw: weights ``# (in, out)`` and biases ``# (out,)`` over raw inputs and outputs.
            which: numbers of the networks ``# (some,)``.
        """
        layers = list(raw)
        weight, bias = layers[0]
        weight = weight[self.kept]
        layers[0] = (weight * self.scale[:, None], bias + self.mean @ weight)
        weight, bias = layers[-1]
        layers[-1] = (weight / self.output, bias / self.output)
        for (weight, bias), (new_weight, new_bias) in zip(networks.pairs(), layers, strict=True):
            weight[which], bias[which] = new_weight, new_bias

    @torch.no_grad()
    def write(self, layers: Sequence[Layer], residual: ResidualMLP, share: Tensor) -> None:
        """Give a residual the layers of a network over normalised columns, and of its outputs these shares ``# (n,)``.

        Its weights of columns that the network does not see are zero.
        """
        mean, scale = torch.zeros_like(residual.input_mean), torch.ones_like(residual.input_scale)
        values = {
            "input_mean": mean.index_copy(0, self.kept, self.mean),
            "input_scale": scale.index_copy(0, self.kept, self.scale),
            "output_scale": self.output * share,
        }
        first = layers[0][0]
        whole = first.new_zeros(len(mean), first.shape[1]).index_copy(0, self.kept, first)
        for place, (weight, bias) in enumerate([(whole, layers[0][1]), *layers[1:]]):
            values |= {f"linears.{place}.weight": weight.T, f"linears.{place}.bias": bias}
        residual.load_state_dict(values)
