"""The fused step on a GPU: one kernel for all rollouts, then torch's soft-max and one product."""

import ctypes
from collections.abc import Callable

import torch
from torch import Tensor

from sym2real.control.fused_arguments import Call, Operands, Sizes, arguments_of, constants_of
from sym2real.control.fused_problem import Fused
from sym2real.control.fused_residual import Residual, packed
from sym2real.control.fused_text import fused_text
from sym2real.control.plan import importance_weights, shift
from sym2real.native.nvrtc import CudaModule

THREADS, TILE = 128, 16  # of a block; as in cuda.h
Module = Callable[..., None]


class FusedGpuStep:
    """One update of MPPI's mean on a CUDA device; the text is the processor's, one sample a thread.

    Args:
        step: what is computed.
        sizes: of the sampling.
        device: where tensors are and threads run.
        residual: the network whose sizes ``step`` names.
        load: text and device → ``module(kernel, blocks, threads, *arguments)``, which runs a kernel of the text.

    Raises:
        CompilationError: when it cannot be compiled or loaded here.
        MissingDependencyError: without NVRTC.
        ModelError: when the equations, the cost or a filter have no fused form.
    """

    description = "a fused CUDA kernel"

    def __init__(
        self,
        step: Fused,
        *,
        sizes: Sizes,
        device: torch.device,
        residual: Residual | None = None,
        load: Callable[[str, torch.device], Module] = CudaModule,
    ) -> None:
        self.samples, self.horizon, self.device = sizes.samples, sizes.horizon, device
        self.shape = (sizes.horizon, len(step.robot.layouts.action))
        self.text = fused_text(step, "gpu")
        self._module = load(self.text, device)
        weights = None if residual is None else packed(residual, TILE)
        constants = constants_of(step, sizes.horizon, weights)
        self._constants = {name: tensor.to(device) for name, tensor in constants.items()}
        self._plan = arguments_of(step, sizes, self._constants)
        self._operands = Operands(step, sizes, device)
        self.shapes = self._operands.shapes
        self._tracks = torch.empty(*self.shape, sizes.samples, device=device, dtype=torch.float32)
        self._draws = torch.empty(self._plan.draws, self.shape[1], sizes.samples, device=device, dtype=torch.float32)

    def __call__(self, given: Call) -> tuple[Tensor, Tensor, int]:
        """The new mean ``# (H, action)``, costs ``# (N,)``, and the number of rollouts that were not finite."""
        plan, pointer = self._plan, self._operands.pointer
        pointer("mean", given.mean)
        before = shift(given.mean, given.steps).contiguous()
        costs = torch.empty(self.samples, device=self.device, dtype=torch.float32)
        read = {**given._asdict(), "mean": before}
        for name in self.shapes:
            setattr(plan, name, pointer(name, read[name]))
        plan.costs, plan.begun = costs.data_ptr(), given.begun
        plan.seed, plan.call = given.seed, given.call
        self._run("plan_samples")
        weights = importance_weights(costs, plan.temperature)
        rejected = int((~costs.isfinite()).sum())
        return (before if rejected == self.samples else self._tracks @ weights), costs, rejected

    def noise(self, seed: int, call: int) -> Tensor:
        """The noise ``# (N, H, action)`` of a call."""
        plan = self._plan
        plan.seed, plan.call, plan.noise = seed, call, None
        self._run("noise_of")
        return self._tracks.movedim(-1, 0).contiguous()

    def _run(self, kernel: str) -> None:
        pointers = [ctypes.c_void_p(tensor.data_ptr()) for tensor in (self._tracks, self._draws)]
        self._module(kernel, -(-self.samples // THREADS), THREADS, self._plan, *pointers)
