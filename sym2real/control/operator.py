"""The fused step as a torch operator, for MPPI and for scripted modules alike::

    mean, costs, rejected = torch.ops.sym2real.plan(mppi.kernel, state, inputs, reference, mean, steps, seed, call)

Its further arguments and all shapes are those of :class:`~sym2real.control.fused_arguments.Call`. Out come the new mean
``# (H, action)``, the costs ``# (N,)`` and how many rollouts were not finite; where none was finite, the shifted mean
comes back. Other shapes, precisions or devices raise ShapeError, an unknown kernel UnknownNameError.
"""

from __future__ import annotations

from itertools import count
from typing import Any
from weakref import WeakValueDictionary

import torch
from torch import Tensor

from sym2real.control.fused import FusedStep
from sym2real.control.fused_arguments import Call
from sym2real.control.fused_gpu import FusedGpuStep
from sym2real.errors import UnknownNameError

KERNELS: WeakValueDictionary[str, FusedStep | FusedGpuStep] = WeakValueDictionary()
_NUMBERS = count(1)


def registered(step: FusedStep | FusedGpuStep) -> str:
    """Name under which the operator finds a step, for as long as somebody keeps it."""
    name = f"plan {next(_NUMBERS)}"
    KERNELS[name] = step
    return name


def _by_name(kernel: str, *operands: Any) -> tuple[Tensor, Tensor, int]:
    found = KERNELS.get(kernel)
    if found is None:
        raise UnknownNameError("kernel", kernel, tuple(KERNELS))
    return found(Call(*operands))


_OPERATORS = torch.library.Library("sym2real", "FRAGMENT")
_OPERATORS.define(
    "plan(str kernel, Tensor state, Tensor inputs, Tensor reference, Tensor mean, int steps, int seed, int call,"
    " Tensor? noise=None, Tensor? memory=None, Tensor? past=None) -> (Tensor, Tensor, int)"
)
for _device in ("CPU", "CUDA"):
    _OPERATORS.impl("plan", _by_name, _device)
plan = torch.ops.sym2real.plan.default
