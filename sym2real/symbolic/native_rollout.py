"""Rollouts by compiled C: torch tensors in and out."""

import ctypes

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import pad

from sym2real.errors import ShapeError
from sym2real.native import library
from sym2real.symbolic.c_rollout import rollout_text
from sym2real.symbolic.equations import Equations

# Samples of which a call is worth while: what differs along the first dimension alone is then laid out alone.
FEWEST = 64


class NativeRollout:
    """The rollout of equations as a compiled function.

    Args:
        equations: what to roll out; their parameter values stand in where a call gives none.
        dtype: float32 or float64.

    Raises:
        CompilationError: when it cannot be compiled here.
    """

    def __init__(self, equations: Equations, dtype: torch.dtype) -> None:
        self.dtype, self.layouts = dtype, equations.layouts
        self.values = torch.tensor(list(equations.parameters.values()), dtype=dtype)
        self._library = library(rollout_text(equations, single=dtype == torch.float32))
        self._library.roll_out.argtypes = (*(ctypes.c_void_p,) * 5, *(ctypes.c_longlong,) * 3)

    def __call__(
        self, state: Tensor, actions: Tensor, inputs: Tensor | None = None, parameters: Tensor | None = None
    ) -> Tensor:
        """States ``# (..., H, n)`` after each action; operands as of :func:`sym2real.symbolic.rollout`."""
        values = self.values if parameters is None else parameters
        known = state.new_zeros(len(self.layouts.inputs)) if inputs is None else inputs
        per_step = known.dim() >= actions.dim()
        own = [(state, 1), (actions, 2), (known, 1 + per_step), (values, 1)]  # and dimensions that are no batch
        batch = require_broadcast(*(tensor.shape[: tensor.dim() - size] for tensor, size in own))
        apart = len(batch) > 1 and batch.numel() > FEWEST * batch[0]
        spread = [
            tensor.detach().to("cpu", self.dtype).expand(*batch[:apart] or (1,), *batch[apart:], *tensor.shape[-size:])
            for tensor, size in own
        ]
        whole = torch.empty((actions.shape[-2], len(self.layouts.state), batch.numel()), dtype=self.dtype)
        laid_out = list[Tensor]()
        for number, place in enumerate(whole.tensor_split(len(spread[0]), dim=-1)):
            count = place.shape[-1]
            padded = count + -count % self._library.width()
            laid_out = [
                laid_out[i] if number and not tensor.stride(0) else _laid_out(tensor[number], own[i][1], count, padded)
                for i, tensor in enumerate(spread)
            ]
            out = torch.empty(*place.shape[:2], padded, dtype=self.dtype)
            places = [tensor.data_ptr() for tensor in (*laid_out, out)]
            self._library.roll_out(*places, padded, len(out), per_step)
            place.copy_(out[..., :count])
        return torch.movedim(whole.unflatten(-1, batch) if batch else whole[..., 0], [0, 1], [-2, -1])


def _laid_out(tensor: Tensor, size: int, count: int, padded: int) -> Tensor:
    """Columns over samples ``# (..., padded)``, one after the other."""
    columns = tensor.reshape(count, *tensor.shape[-size:]).movedim(0, -1)
    return pad(columns, [0, padded - count]).contiguous()


def require_broadcast(*batches: torch.Size) -> torch.Size:
    """The shape that batch dimensions broadcast to.

    Raises:
        ShapeError: where they do not.
    """
    try:
        return torch.Size(np.broadcast_shapes(*batches))
    except ValueError as error:
        shapes = ", ".join(str(tuple(batch)) for batch in batches)
        raise ShapeError(f"expected batches that broadcast, found {shapes}") from error
