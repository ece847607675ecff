"""The fused step on a GPU: one kernel for all rollouts, then torch's soft-max and one product."""

from __future__ import annotations

import ctypes

import torch
from torch import Tensor

from sym2real.control.fused import PlanArguments, Sizes
from sym2real.control.fused_filters import memory_of
from sym2real.control.fused_problem import Fused
from sym2real.control.fused_text import fused_text
from sym2real.control.noise import smoothing
from sym2real.control.weights import weigh
from sym2real.effects.filters import FilterState
from sym2real.native.nvrtc import CudaFunction, compile_cuda

THREADS = 128


class FusedGpuStep:
    """One update of MPPI's mean on a CUDA device; the text is the processor's, one sample a thread.

    Args:
        step: what is computed.
        factor: C ``# (action, action)``.
        sizes: of the sampling.
        device: a CUDA device.
        filters: what actions go through.

    Raises:
        CompilationError: when it cannot be compiled or loaded here.
        MissingDependencyError: without NVRTC.
    """

    def __init__(
        self, step: Fused, *, factor: Tensor, sizes: Sizes, device: torch.device, filters: FilterState | None = None
    ) -> None:
        self.samples, self.horizon, self.filters, self.device = sizes.samples, sizes.horizon, filters, device
        robot, self.shape = step.robot, (sizes.horizon, len(step.robot.layouts.action))
        major, minor = torch.cuda.get_device_capability(device)
        ptx = compile_cuda(fused_text(step, "gpu"), f"compute_{major}{minor}")
        torch.zeros(1, device=device)  # makes the context current
        self._function = CudaFunction(ptx, "plan_samples")
        smooth = (
            smoothing(sizes.horizon, robot.dt, robot.mppi)
            if step.sampling.colour == 2
            else torch.zeros(1, sizes.horizon)
        )
        self._buffers = {
            "low": self._on_device(robot.low),
            "high": self._on_device(robot.high),
            "factor": self._on_device(factor),
            "smooth": self._on_device(smooth),
            "costs": torch.empty(sizes.samples, device=device),
        }
        self._tracks = torch.empty((*self.shape, sizes.samples), device=device)
        self._draws = torch.empty((smooth.shape[1], self.shape[1], sizes.samples), device=device)
        self._arguments = PlanArguments.of(robot, step.sampling, sizes, smooth.shape[1])

    def _on_device(self, values: object) -> Tensor:
        return torch.as_tensor(values, dtype=torch.float32).contiguous().to(self.device)

    @property
    def costs(self) -> Tensor:
        """Of the last step ``# (N,)``."""
        return self._buffers["costs"]

    def __call__(
        self, state: Tensor, inputs: Tensor, mean: Tensor, reference: Tensor, draw: tuple[int, int]
    ) -> tuple[Tensor, int]:
        """The new mean ``# (H, action)`` and the number of rollouts that were not finite; all tensors on the device."""
        memory = torch.zeros(1) if self.filters is None else torch.as_tensor(memory_of(self.filters, 1))
        given = {"state": state, "inputs": inputs, "mean": mean, "reference": reference, "memory": memory}
        kept = {**self._buffers, **{name: self._on_device(value) for name, value in given.items()}}
        for name, tensor in kept.items():
            setattr(self._arguments, name, tensor.data_ptr())
        self._arguments.begun = int(self.filters is not None and bool(self.filters.memories))
        self._arguments.seed, self._arguments.call = draw[0] & 0xFFFFFFFF, draw[1] & 0xFFFFFFFF
        pointers = [ctypes.c_void_p(tensor.data_ptr()) for tensor in (self._tracks, self._draws)]
        stream = torch.cuda.current_stream(self.device).cuda_stream
        self._function(-(-self.samples // THREADS), THREADS, stream, self._arguments, *pointers)
        weights = weigh(self.costs, self._arguments.temperature)
        rejected = int((~self.costs.isfinite()).sum())
        return (mean if rejected == self.samples else self._tracks @ weights), rejected
