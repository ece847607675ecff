"""The neural baseline of the paper: an ensemble of four multilayer perceptrons, 4 × 200, that predict the next state.

::

    s' = normalise(s + mean over members of r_i(z) · output_scale),   z = ((s, a) - mean) / scale

A probabilistic ensemble also predicts the logarithm of the variance of each column, held between two learned bounds by
softplus. Source: K. Chua et al., "Deep reinforcement learning in a handful of trials using probabilistic dynamics
models" (PETS), NeurIPS 2018, appendix A.1.
"""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn.functional import softplus

from sym2real.errors import ShapeError
from sym2real.layout import Layouts
from sym2real.neural.manifold import manifold_of
from sym2real.neural.networks import PAPER, Networks
from sym2real.neural.residual_mlp import joined
from sym2real.symbolic.predicting import Predicting


class Ensemble(Predicting, nn.Module):
    """Next state ``# (..., n)`` for state ``# (..., n)`` and action ``# (..., m)``.

    Args:
        layouts: state and action columns.
        members: networks.
        widths: of each network's hidden layers.
        seed: of the first weights.
        probabilistic: predict variances too.
        dt: control period in s; 0 where nobody says.
        robot: name of the robot, if it is a known one.

    Raises:
        ShapeError: without a member, or with a hidden layer of no unit.
    """

    input_mean: Tensor
    input_scale: Tensor
    output_scale: Tensor

    def __init__(
        self,
        layouts: Layouts,
        members: int = 4,
        widths: Sequence[int] = PAPER,
        seed: int = 0,
        *,
        probabilistic: bool = False,
        dt: float = 0.0,
        robot: str = "",
    ) -> None:
        super().__init__()
        if min((members, *widths)) < 1:
            raise ShapeError(f"expected members and hidden layers of at least one unit, found {members}, {(*widths,)}")
        self.layouts, self.dt, self.robot = layouts, float(dt), str(robot)
        self.columns = (layouts.state.columns, layouts.action.columns)
        self.widths, self.probabilistic = tuple(int(width) for width in widths), probabilistic
        self.size, self.manifold = len(layouts.state), manifold_of(layouts.state)
        seen = self.size + len(layouts.action)
        self.networks = Networks((seen, *widths, self.size * (2 if probabilistic else 1)), members, seed)
        self.register_buffer("input_mean", torch.zeros(seen))
        self.register_buffer("input_scale", torch.ones(seen))
        self.register_buffer("output_scale", torch.ones(self.size))
        if probabilistic:  # of the logarithm of variances in units of output_scale²
            self.lowest = nn.Parameter(torch.full((self.size,), -10.0))
            self.highest = nn.Parameter(torch.full((self.size,), 0.5))
        self.float()  # whatever the program's own precision is

    def about(self) -> dict[str, Any]:
        """Arguments, beside its columns, that make an ensemble of this shape."""
        sizes = {"members": self.networks.count, "widths": self.widths, "probabilistic": self.probabilistic}
        return {**sizes, "dt": self.dt, "robot": self.robot}

    def members(self, state: Tensor, action: Tensor) -> Tensor:
        """Change of the state that each member predicts ``# (members, ..., n)``."""
        return self.outputs(state, action)[..., : self.size] * self.output_scale

    def outputs(self, state: Tensor, action: Tensor) -> Tensor:
        """What the networks say in scaled columns ``# (members, ..., n)``; probabilistic ones say 2n."""
        both = joined([state, action])
        values = self.networks(((both - self.input_mean) / self.input_scale).reshape(-1, both.shape[-1]))
        outputs: Tensor = values.reshape(values.shape[:1] + both.shape[:-1] + values.shape[-1:])
        return outputs

    def forward(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        """Next state on the manifold; leading dimensions broadcast."""
        following: Tensor = self.manifold(state + self.members(state, action).mean(dim=0))
        return following

    def log_variance(self, outputs: Tensor) -> Tensor:
        """Logarithm of the variance in scaled columns ``# (members, ..., n)``, of what a probabilistic one says."""
        raw = outputs[..., self.size :]
        below = self.highest - softplus(self.highest - raw)
        return self.lowest + softplus(below - self.lowest)
