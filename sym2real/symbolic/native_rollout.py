"""Rollouts by compiled C: torch tensors in and out."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import torch
from torch import Tensor

from sym2real.errors import ShapeError
from sym2real.native import library
from sym2real.symbolic.c_rollout import rollout_text
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.source import measured_inputs

DIMENSIONS = 8  # as in batch.h
_Strides = ctypes.c_longlong * DIMENSIONS


class _Operand(ctypes.Structure):
    _fields_ = (
        ("data", ctypes.c_void_p),
        ("batch", _Strides),
        ("step", ctypes.c_longlong),
        ("column", ctypes.c_longlong),
    )


class _Batch(ctypes.Structure):
    _fields_ = (
        ("state", _Operand),
        ("actions", _Operand),
        ("inputs", _Operand),
        ("parameters", _Operand),
        ("out", ctypes.c_void_p),
        ("sizes", _Strides),
        ("count", ctypes.c_longlong),
        ("horizon", ctypes.c_longlong),
        ("per_step", ctypes.c_longlong),
    )


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
        self._needed = measured_inputs(equations)
        made = library(rollout_text(equations, single=dtype == torch.float32))
        self._function: Callable[[object], None] = made.roll_out

    def __call__(
        self, state: Tensor, actions: Tensor, inputs: Tensor | None = None, parameters: Tensor | None = None
    ) -> Tensor:
        """States ``# (..., H, n)`` after each action; operands as of :func:`sym2real.symbolic.rollout`.

        Raises:
            ShapeError: when columns, steps, batches or dimensions do not fit, an operand lies on another device, or
                inputs are missing that the equations use.
        """
        if inputs is None and self._needed:
            raise ShapeError(f"the equations need their inputs: {', '.join(self._needed)}")
        values = self.values if parameters is None else parameters
        known = state.new_zeros(len(self.layouts.inputs)) if inputs is None else inputs
        per_step = known.dim() >= actions.dim()
        operands = [tensor.detach().to(self.dtype) for tensor in (state, actions, known, values)]
        self._check(operands, per_step)
        batches = [state.shape[:-1], actions.shape[:-2], known.shape[: -2 if per_step else -1], values.shape[:-1]]
        batch = require_broadcast(*batches)
        out = torch.empty((actions.shape[-2], len(self.layouts.state), *batch), dtype=self.dtype)
        if out.numel():
            places = ((), (-2, -1), (-2, -1) if per_step else (), ())
            laid_out = [_operand(o, b, bool(p)) for o, b, p in zip(operands, batches, places, strict=True)]
            sizes = _Strides(*(1,) * (DIMENSIONS - len(batch)), *batch)
            count = batch.numel()
            self._function(
                ctypes.byref(_Batch(*laid_out, out.data_ptr(), sizes, count, actions.shape[-2], int(per_step)))
            )
        return torch.movedim(out, [0, 1], [-2, -1])

    def _check(self, operands: list[Tensor], per_step: bool) -> None:
        actions, inputs = operands[1:3]
        layouts = self.layouts
        if actions.dim() < 2:
            raise ShapeError(f"expected actions (..., H, m), found the shape {tuple(actions.shape)}")
        wanted = (len(layouts.state), len(layouts.action), len(layouts.inputs), len(self.values))
        names = ("state", "action", "input", "parameter")
        for name, tensor, size in zip(names, operands, wanted, strict=True):
            if tensor.shape[-1] != size:
                raise ShapeError(f"expected {size} {name} columns, found {tensor.shape[-1]}")
            if tensor.device.type != "cpu":
                raise ShapeError(f"expected the {name} on the processor, found it on {tensor.device}")
            if tensor.dim() > DIMENSIONS:
                raise ShapeError(f"expected at most {DIMENSIONS} dimensions of the {name}, found {tensor.dim()}")
        if per_step and inputs.shape[-2] != actions.shape[-2]:
            raise ShapeError(f"expected inputs for {actions.shape[-2]} steps, found {inputs.shape[-2]}")


def require_broadcast(*batches: torch.Size) -> torch.Size:
    """The shape that batch dimensions broadcast to.

    Raises:
        ShapeError: where they do not.
    """
    try:
        return torch.Size(torch.broadcast_shapes(*batches))
    except RuntimeError as error:
        found = ", ".join(str(tuple(batch)) for batch in batches)
        raise ShapeError(f"expected batches that broadcast, found {found}") from error


def _operand(tensor: Tensor, batch: torch.Size, stepped: bool) -> _Operand:
    """Strides of a tensor; those of its batch stand last, as broadcasting has them."""
    strides = [0] * (DIMENSIONS - len(batch))
    for place, size in enumerate(batch):
        strides.append(tensor.stride(place) if size > 1 else 0)
    step = tensor.stride(-2) if stepped else 0
    return _Operand(tensor.data_ptr(), _Strides(*strides), step, tensor.stride(-1))
