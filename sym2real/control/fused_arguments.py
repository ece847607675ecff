"""What a compiled step of MPPI is given: the C structure, its constant numbers, and checks of the tensors of a call."""

import ctypes
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import ArrayLike, DTypeLike, NDArray
from torch import Tensor

from sym2real.control.fused_problem import Fused
from sym2real.control.noise import smoothing
from sym2real.errors import ShapeError

LINE = 64  # bytes: buffers start where a vector may


class Sizes(NamedTuple):
    """How much is sampled: rollouts, and steps of each."""

    samples: int
    horizon: int


class Call(NamedTuple):
    """What a step is given: float32, contiguous, on its device.

    Args:
        state: measured ``# (state,)``.
        inputs: held over the horizon ``# (inputs,)``.
        reference: after each step ``# (H, state)``.
        mean: of the last plan ``# (H, action)``.
        steps: by which it is shifted first; its last row is repeated.
        seed: of the kernel's own noise.
        call: the noise of every call is another one.
        noise: ``# (N, H, action)`` instead of the kernel's own.
        memory: of the command filters, in their order ``# (size,)``; None before anything was sent.
        past: commands that reached the robot, newest first, then states, as a residual sees them; None likewise.
        hidden: states that nobody measures ``# (hidden,)``; None where they begin with each sample's first action.
    """

    state: Tensor
    inputs: Tensor
    reference: Tensor
    mean: Tensor
    steps: int
    seed: int
    call: int
    noise: Tensor | None = None
    memory: Tensor | None = None
    past: Tensor | None = None
    hidden: Tensor | None = None

    @property
    def begun(self) -> bool:
        """Whether something was sent before."""
        return self.memory is not None or self.past is not None


class PlanArguments(ctypes.Structure):
    """``struct plan`` of plan.h."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("state", "inputs", "reference", "memory")),
        *((name, ctypes.c_void_p) for name in ("past", "hidden", "weights")),
        *((name, ctypes.c_void_p) for name in ("mean", "low", "high", "spread", "smooth", "noise", "costs")),
        ("temperature", ctypes.c_float),
        ("correlation", ctypes.c_float),
        ("fresh", ctypes.c_float),
        ("seed", ctypes.c_uint32),
        ("call", ctypes.c_uint32),
        *((name, ctypes.c_int) for name in ("samples", "horizon", "draws", "begun")),
    )


def arguments_of(step: Fused, sizes: Sizes, constants: Mapping[str, Tensor]) -> PlanArguments:
    """The structure with what stays the same from call to call; the constants must outlive it."""
    settings = step.robot.mppi
    kept = math.exp(-step.robot.dt / settings.correlation) if step.colour == 1 else 0.0
    return PlanArguments(
        temperature=settings.temperature,
        correlation=kept,
        fresh=math.sqrt(1.0 - kept**2),
        samples=sizes.samples,
        horizon=sizes.horizon,
        draws=constants["smooth"].shape[1],
        **{name: tensor.data_ptr() for name, tensor in constants.items()},
    )


def constants_of(step: Fused, horizon: int, weights: NDArray[np.float32] | None) -> dict[str, Tensor]:
    """Limits, standard deviations, matrix over the horizon and weights of a residual, in aligned memory."""
    knots = step.colour == 2
    smooth = smoothing(horizon, step.robot.dt, step.robot.mppi) if knots else torch.zeros(1, horizon)
    given = {
        "low": step.robot.low,
        "high": step.robot.high,
        "spread": step.robot.mppi.noise,
        "smooth": smooth.numpy(),
        "weights": np.zeros(0) if weights is None else weights,
    }
    return {name: aligned(np.asarray(values)) for name, values in given.items()}


class Operands:
    """Tensors of a call, checked: the kernel reads their memory as it lies.

    Args:
        step: what is computed.
        sizes: of the sampling.
        device: where tensors must be.
    """

    def __init__(self, step: Fused, sizes: Sizes, device: torch.device) -> None:
        actions, states = len(step.robot.layouts.action), len(step.robot.layouts.state)
        steps = (sizes.horizon, actions)
        self.device = device
        self.shapes: dict[str, tuple[int, ...]] = {
            "state": (states,),
            "inputs": (len(step.equations.layouts.inputs),),
            "reference": (sizes.horizon, states),
            "mean": steps,
            "noise": (sizes.samples, *steps),
            "memory": (step.filters.size,),
            "past": (0 if step.residual is None else step.residual.sizes[0] - states - actions,),
            "hidden": (len(step.equations.start),),
        }

    def pointer(self, name: str, tensor: Tensor | None) -> int | None:
        """Address of a tensor's numbers; None for None.

        Raises:
            ShapeError: for another shape, precision, device or order in memory.
        """
        if tensor is None:
            return None
        if tensor.shape != self.shapes[name]:
            raise ShapeError(f"{name}: expected the shape {self.shapes[name]}, found {tuple(tensor.shape)}")
        if tensor.dtype is not torch.float32 or tensor.device != self.device or not tensor.is_contiguous():
            actual = f"{tensor.dtype} on {tensor.device}{'' if tensor.is_contiguous() else ', strided'}"
            raise ShapeError(f"{name}: expected contiguous torch.float32 on {self.device}, found {actual}")
        return tensor.data_ptr()


def copy_of(values: ArrayLike, precision: DTypeLike) -> NDArray[Any]:
    """A copy of numbers.

    Raises:
        ShapeError: for anything else, and rows of different lengths.
    """
    try:
        return np.array(values, dtype=precision)
    except (TypeError, ValueError):
        raise ShapeError(f"state, inputs or command: expected numbers, found {values!r:.80}") from None


def single(values: ArrayLike, device: torch.device) -> Tensor:
    """A copy in single precision, on a device."""
    copied = torch.from_numpy(copy_of(values, np.float32))
    return copied if device.type == "cpu" else copied.to(device)


def aligned(content: int | NDArray[np.floating]) -> Tensor:
    """A float32 tensor on the processor that starts at a cache line: zeros of that size, or a copy."""
    shape = (content,) if isinstance(content, int) else content.shape
    raw = np.zeros(4 * math.prod(shape) + LINE, dtype=np.uint8)
    start = -raw.ctypes.data % LINE
    array = raw[start : start + 4 * math.prod(shape)].view(np.float32).reshape(shape)
    if not isinstance(content, int):
        array[:] = content
    return torch.from_numpy(array)
