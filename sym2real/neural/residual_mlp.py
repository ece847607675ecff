"""A multilayer perceptron that predicts what equations leave over of the next state.

::

    r = b_L + W_L relu(… relu(b_1 + W_1 z)),   z = ((s, a, past) - mean) / scale,   residual = r · output_scale

It begins at zero: an untrained residual changes nothing. Source: the paper, "Residual learning" (4 × 200, ReLU). The
paper's sees no past; a delay of several periods or a state that is not measured cannot be learned without.
"""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor, nn

from sym2real.errors import ShapeError
from sym2real.generator import generator_of
from sym2real.layout import Layouts


def joined(parts: list[Tensor]) -> Tensor:
    """Side by side in the last dimension; leading ones broadcast."""
    batch = torch.ops.aten.broadcast_tensors([part[..., :1] for part in parts])[0].shape[:-1]
    return torch.cat([part.expand(batch + part.shape[-1:]) for part in parts], dim=-1)


class ResidualMLP(nn.Module):
    """Residual of the next state ``# (..., n)`` for state ``# (..., n)``, action ``# (..., m)`` and what went before.

    Args:
        layouts: state and action columns; inputs are not seen.
        widths: of the hidden layers; the paper's are four of 200.
        seed: of the first weights.
        commands: past commands that it sees, as sent.
        states: past states that it sees.

    Raises:
        ShapeError: without a hidden layer, or for less than no past.
    """

    input_mean: Tensor
    input_scale: Tensor
    output_scale: Tensor

    def __init__(
        self, layouts: Layouts, widths: Sequence[int] = (64, 64), seed: int = 0, commands: int = 0, states: int = 0
    ) -> None:
        super().__init__()
        if not widths or min(widths) < 1:
            raise ShapeError(f"expected at least one hidden layer of at least one unit, found {tuple(widths)}")
        if min(commands, states) < 0:
            raise ShapeError(f"expected no negative number of past rows, found {commands} commands, {states} states")
        self.columns = (layouts.state.columns, layouts.action.columns)
        self.widths = tuple(int(width) for width in widths)
        self.commands, self.states = commands, states
        size = len(layouts.state)
        seen = size * (1 + states) + len(layouts.action) * (1 + commands)
        self.register_buffer("input_mean", torch.zeros(seen))
        self.register_buffer("input_scale", torch.ones(seen))
        self.register_buffer("output_scale", torch.ones(size))
        self.linears = nn.Sequential(*(nn.Linear(i, o) for i, o in zip((seen, *widths), (*widths, size), strict=True)))
        self._begin(seed)
        self.float()  # whatever the program's own precision is

    def about(self) -> dict[str, Any]:
        """Arguments, beside its columns, that make a residual of this shape."""
        return {"widths": self.widths, "commands": self.commands, "states": self.states}

    def _begin(self, seed: int) -> None:
        generator = generator_of(seed)
        with torch.no_grad():
            for linear in self._linears():
                bound = (6.0 / linear.in_features) ** 0.5  # K. He et al., ICCV 2015, for ReLU
                linear.weight.uniform_(-bound, bound, generator=generator)
                linear.bias.zero_()
            self._linears()[-1].weight.zero_()

    def _linears(self) -> list[nn.Linear]:
        return [linear for linear in self.linears if isinstance(linear, nn.Linear)]

    def forward(self, state: Tensor, action: Tensor, past: Tensor | None = None) -> Tensor:
        """Residual ``# (..., n)``; leading dimensions broadcast.

        Args:
            state: ``# (..., n)``.
            action: ``# (..., m)``.
            past: commands from the newest to the oldest, then states likewise ``# (..., commands·m + states·n)``;
                the present row, repeated, where there is none.
        """
        behind = [action] * self.commands + [state] * self.states if past is None else [past]
        values = (joined([state, action] + behind) - self.input_mean) / self.input_scale  # noqa: RUF005 — TorchScript
        for place, linear in enumerate(self.linears):
            values = linear(values if place == 0 else torch.relu(values))
        return values * self.output_scale

    def layers(self) -> list[tuple[Tensor, Tensor]]:
        """Weights ``# (in, out)`` and biases ``# (out,)`` over raw state, action and past; ReLU in between."""
        layers = [(linear.weight.detach().T.clone(), linear.bias.detach().clone()) for linear in self._linears()]
        weight, bias = layers[0]
        layers[0] = (weight / self.input_scale[:, None], bias - (self.input_mean / self.input_scale) @ weight)
        weight, bias = layers[-1]
        layers[-1] = (weight * self.output_scale, bias * self.output_scale)
        return layers
