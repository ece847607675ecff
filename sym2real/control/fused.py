"""The fused step of MPPI on a processor: compiled text and its buffers."""

import ctypes

import torch
from torch import Tensor

from sym2real.control.fused_arguments import Call, Operands, Sizes, aligned, arguments_of, constants_of
from sym2real.control.fused_problem import Fused
from sym2real.control.fused_residual import Residual, packed
from sym2real.control.fused_text import fused_text
from sym2real.native import library

PROCESSOR = torch.device("cpu")
_POINTER, _INT = ctypes.c_void_p, ctypes.c_int


class FusedStep:
    """One update of MPPI's mean in compiled C; scratch memory is made once.

    Args:
        step: what is computed.
        sizes: of the sampling.
        residual: the network whose sizes ``step`` names.

    Raises:
        CompilationError: when it cannot be compiled here.
        ModelError: when the equations, the cost or a filter have no fused form.
    """

    description = "a fused C kernel"

    def __init__(self, step: Fused, *, sizes: Sizes, residual: Residual | None = None) -> None:
        self.samples, self.horizon = sizes.samples, sizes.horizon
        self.shape = (sizes.horizon, len(step.robot.layouts.action))
        self._library = library(fused_text(step))
        weights = None if residual is None else packed(residual, self._library.tile())
        self._constants = constants_of(step, sizes.horizon, weights)
        self._plan = arguments_of(step, sizes, self._constants)
        self._operands = Operands(step, sizes, PROCESSOR)
        self.shapes = self._operands.shapes
        self._address = ctypes.addressof(self._plan)
        self._library.shifted.argtypes = (_POINTER, _POINTER, _INT, _POINTER)
        self._library.plan_all.argtypes = (_POINTER, _POINTER, _POINTER)
        self._library.noise_of.argtypes = (_POINTER, _POINTER, _POINTER)
        tracks = 2 * self.horizon + self._plan.draws
        self._scratch = aligned(tracks * self.shape[1] * self._library.width())
        self._scratch_address = self._scratch.data_ptr()

    def __call__(self, given: Call) -> tuple[Tensor, Tensor, int]:
        """The new mean ``# (H, action)``, costs ``# (N,)``, and the number of rollouts that were not finite."""
        plan, pointer = self._plan, self._operands.pointer
        costs, following = (torch.empty(size, dtype=torch.float32) for size in ((self.samples,), self.shape))
        for name in self.shapes:
            setattr(plan, name, pointer(name, getattr(given, name)))
        before, steps = plan.mean, min(max(given.steps, 0), self.horizon)
        plan.mean, plan.costs = following.data_ptr(), costs.data_ptr()
        plan.begun, plan.seed, plan.call = given.begun, given.seed, given.call
        self._library.shifted(self._address, before, steps, plan.mean)
        return following, costs, self._library.plan_all(self._address, self._scratch_address, plan.mean)

    def noise(self, seed: int, call: int) -> Tensor:
        """The noise ``# (N, H, action)`` of a call."""
        plan = self._plan
        plan.seed, plan.call, plan.noise = seed, call, None
        noise = torch.empty(self.samples, *self.shape, dtype=torch.float32)
        self._library.noise_of(self._address, self._scratch_address, noise.data_ptr())
        return noise
