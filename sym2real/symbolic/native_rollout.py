"""Rollouts by compiled C: torch tensors in and out."""

import ctypes
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import torch
from torch import Tensor

from sym2real.errors import ShapeError
from sym2real.native import library
from sym2real.symbolic.c_rollout import rollout_text
from sym2real.symbolic.equations import Equations
from sym2real.threads import available_threads

WIDEST = 16  # samples of the widest vector there is: no vector belongs to two threads
FEWEST = 256  # samples that are worth a thread


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
        self._library.roll_out.argtypes = (*(ctypes.c_void_p,) * 6, *(ctypes.c_longlong,) * 6)

    def __call__(
        self, state: Tensor, actions: Tensor, inputs: Tensor | None = None, parameters: Tensor | None = None
    ) -> Tensor:
        """States ``# (..., H, n)`` after each action; operands as of :func:`sym2real.symbolic.rollout`."""
        values = self.values if parameters is None else parameters
        known = state.new_zeros(len(self.layouts.inputs)) if inputs is None else inputs
        per_step = known.dim() >= actions.dim()
        own = [(state, 1), (actions, 2), (known, 1 + per_step), (values, 1)]  # and dimensions that are no batch
        batch = require_broadcast(*(tensor.shape[: tensor.dim() - size] for tensor, size in own))
        operands = [_in_sets(tensor.detach().to("cpu", self.dtype), size, batch) for tensor, size in own]
        strides = torch.tensor([_strides(operand) for operand in operands])
        out = torch.empty((actions.shape[-2], len(self.layouts.state), batch.numel()), dtype=self.dtype)
        places = [tensor.data_ptr() for tensor in (*operands, out, strides)]
        sizes = operands[0].shape[1], batch.numel(), len(out), per_step
        first, *others = pairwise(edges_of(batch.numel()))
        with ThreadPoolExecutor(max(1, len(others))) as pool:  # begins a thread for each of the others, if any
            waiting = [pool.submit(self._library.roll_out, *places, *sizes, *part) for part in others]
            self._library.roll_out(*places, *sizes, *first)
        for part in waiting:
            part.result()
        return torch.movedim(out.unflatten(-1, batch) if batch else out[..., 0], [0, 1], [-2, -1])


def edges_of(samples: int) -> list[int]:
    """Where the parts begin and end that go to threads of their own, of about the same number of samples."""
    parts = max(1, min(available_threads(), samples // FEWEST))
    return [*(samples * part // parts // WIDEST * WIDEST for part in range(parts)), samples]


def _in_sets(tensor: Tensor, size: int, batch: torch.Size) -> Tensor:
    """An operand ``# (sets, samples, ...)``, as it lies in memory where it can.

    Args:
        tensor: with a batch that broadcasts.
        size: dimensions that are no batch.
        batch: what it broadcasts to; its last dimension are the samples.
    """
    own = tensor.shape[-size:]
    return tensor.expand(*batch, *own).reshape(batch[:-1].numel(), batch[-1] if batch else 1, *own)


def _strides(operand: Tensor) -> tuple[int, ...]:
    """Of sets, samples, steps and columns."""
    sets, samples, *steps, columns = operand.stride()
    return sets, samples, steps[0] if steps else 0, columns


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
