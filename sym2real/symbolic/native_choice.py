"""When a rollout goes to compiled C: equations are known, nobody asks for gradients, and there is enough to compute.

A model is compiled to C once it has been rolled out over :data:`MANY` steps, a call counting as :data:`CALL` of them,
which take torch about as long as the compiler takes; until then, and wherever there is no compiler, torch computes the
same but for rounding.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Any
from weakref import WeakKeyDictionary

import torch
from torch import Tensor

from sym2real.errors import CompilationError, ModelError
from sym2real.native import find_compiler
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.native_rollout import NativeRollout

LOGGER = logging.getLogger(__name__)
KINDS = ({torch.float32}, {torch.float64})
MANY = 400_000  # steps of single samples: 0.14 to 1.2 million, of an arm of seven joints and of a car
# Samples that take torch as long as to begin a step: 1,600 to 4,200 of a car, a quadrotor, a cart-pole, an arm.
CALL = 2000


@dataclass
class _Use:
    """How far a model has been rolled out, and its kernels; None for one that cannot be compiled."""

    steps: int = 0
    kernels: dict[torch.dtype, NativeRollout | None] = field(default_factory=dict)


_allowed = ContextVar("rollouts may go to C", default=True)


@contextmanager
def torch_alone() -> Iterator[None]:
    """Inside, torch computes every rollout."""
    before = _allowed.set(False)
    try:
        yield
    finally:
        _allowed.reset(before)


_uses: WeakKeyDictionary[Any, _Use] = WeakKeyDictionary()


def native_rollout(
    model: Any, state: Tensor, actions: Tensor, others: tuple[Tensor | None, ...]
) -> NativeRollout | None:
    """The kernel of a model for a rollout with these operands; None where torch is to compute it.

    Args:
        model: a compiled model that knows its equations; others are left to torch.
        state, actions: as of :func:`sym2real.symbolic.rollout`.
        others: inputs and parameters.
    """
    if not _allowed.get():
        return None
    equations = getattr(model, "equations", None)
    if not isinstance(model, torch.jit.ScriptModule) or not isinstance(equations, Equations):
        return None
    operands = [state, actions, *(tensor for tensor in others if tensor is not None)]
    tensors = [*operands, model.values]
    if any(tensor.device.type != "cpu" for tensor in tensors) or {tensor.dtype for tensor in operands} not in KINDS:
        return None
    if torch.is_grad_enabled() and any(tensor.requires_grad for tensor in tensors):
        return None
    use = _uses.setdefault(model, _Use())
    batches = [state.shape[:-1], actions.shape[:-2]]
    use.steps += (torch.broadcast_shapes(*batches).numel() + CALL) * actions.shape[-2]
    if use.steps >= MANY and state.dtype not in use.kernels:
        use.kernels[state.dtype] = _compiled(equations, state.dtype)
    return use.kernels.get(state.dtype)


def _compiled(equations: Equations, dtype: torch.dtype) -> NativeRollout | None:
    if find_compiler() is None:
        return None
    try:
        return NativeRollout(equations, dtype)
    except (CompilationError, ModelError) as error:
        LOGGER.warning("predictions stay with torch, which is slower than compiled C: %s", error)
        return None
