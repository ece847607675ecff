"""The fused step of MPPI: compiled text, its buffers and its threads."""

from __future__ import annotations

import ctypes
import math
import os
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from sympy import Expr
from torch import Tensor

from sym2real.control.fused_filters import FilterLines, memory_of
from sym2real.control.fused_problem import Fused, Sampling
from sym2real.control.fused_residual import Residual, packed, sizes_of
from sym2real.control.fused_text import fused_text
from sym2real.control.noise import smoothing
from sym2real.effects.filters import FilterState
from sym2real.native import library
from sym2real.robots.robot import Robot
from sym2real.symbolic import Equations

Single = NDArray[np.float32]
WORTH_ASKING, TRIALS = 160_000, 5  # sample-steps; calls per number of threads
_POINTER = ctypes.c_void_p
LINE = 64  # bytes: buffers start where a vector may


@dataclass(frozen=True)
class Sizes:
    """How much is sampled: rollouts, steps of each, threads that share the rollouts."""

    samples: int
    horizon: int
    threads: int = 1


class PlanArguments(ctypes.Structure):
    """``struct plan`` of plan.h."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("state", "inputs", "reference", "memory", "weights")),
        *((name, ctypes.c_void_p) for name in ("mean", "low", "high", "factor", "smooth", "price", "noise", "costs")),
        ("temperature", ctypes.c_float),
        ("correlation", ctypes.c_float),
        ("fresh", ctypes.c_float),
        ("seed", ctypes.c_uint32),
        ("call", ctypes.c_uint32),
        *((name, ctypes.c_int) for name in ("samples", "horizon", "draws", "begun")),
    )

    @classmethod
    def of(cls, robot: Robot, sampling: Sampling, sizes: Sizes, draws: int) -> PlanArguments:
        """Numbers of a sampling; addresses are filled in later."""
        settings = robot.mppi
        kept = math.exp(-robot.dt / settings.correlation) if sampling.colour == 1 else 0.0
        return cls(
            temperature=settings.temperature,
            correlation=kept,
            fresh=math.sqrt(1.0 - kept**2),
            samples=sizes.samples,
            horizon=sizes.horizon,
            draws=draws,
        )


class _Share(ctypes.Structure):
    _fields_ = (
        ("least", ctypes.c_float),
        ("total", ctypes.c_float),
        ("rejected", ctypes.c_int),
        ("unused", ctypes.c_int),
    )


class FusedStep:
    """One update of MPPI's mean in compiled code; every buffer is made once.

    Args:
        equations: with their parameter values.
        robot: limits, columns, control period; its ``mppi`` says how noise is coloured.
        cost: running cost over state, action and ``ref_<column>``.
        factor: C ``# (action, action)``, of the noise's covariance.
        sizes: of the sampling.
        filters: what actions go through.
        residual: a network that adds to the next state.

    Raises:
        CompilationError: when it cannot be compiled here.
        ModelError: when the equations, the cost or a filter have no fused form.
    """

    def __init__(
        self,
        equations: Equations,
        robot: Robot,
        cost: Expr,
        *,
        factor: Tensor,
        sizes: Sizes,
        filters: FilterState | None = None,
        residual: Residual | None = None,
    ) -> None:
        self.horizon, self.samples, self.filters = sizes.horizon, sizes.samples, filters
        self.shape = (sizes.horizon, len(robot.layouts.action))
        lines = FilterLines(filters, robot.layouts.action.columns, equations.dt)
        sampling = Sampling.of(robot.mppi, factor)
        sizes_of_layers = () if residual is None else sizes_of(residual)
        self.text = fused_text(Fused(equations, robot, cost, sampling, lines, sizes_of_layers))
        self._library = library(self.text)
        smooth = smoothing(self.horizon, robot.dt, robot.mppi).numpy() if sampling.colour == 2 else np.eye(self.horizon)
        self.state = _aligned(len(robot.layouts.state))
        self.inputs = _aligned(len(equations.layouts.inputs))
        self.costs = _aligned(self.samples)
        self._memory = _aligned(lines.size)
        self._constant = {
            "low": _aligned(robot.low),
            "high": _aligned(robot.high),
            "factor": _aligned(factor.double().cpu().numpy()),
            "smooth": _aligned(smooth),
            "weights": _aligned(0 if residual is None else packed(residual, self._library.tile())),
        }
        buffers = {"state": self.state, "inputs": self.inputs, "costs": self.costs, "memory": self._memory}
        self._plan = PlanArguments.of(robot, sampling, sizes, smooth.shape[1])
        for name, array in {**self._constant, **buffers}.items():
            setattr(self._plan, name, array.ctypes.data)
        self._address = ctypes.addressof(self._plan)
        self._library.plan_share.argtypes = (_POINTER, ctypes.c_int, ctypes.c_int, _POINTER, _POINTER, _POINTER)
        self._library.finish.argtypes = (_POINTER, ctypes.c_int, _POINTER, _POINTER, _POINTER)
        self._library.noise_of.argtypes = (_POINTER, _POINTER, _POINTER)
        self.threads = sizes.threads

    @property
    def threads(self) -> int:
        return len(self._shares)

    @threads.setter
    def threads(self, count: int) -> None:
        width = self._library.width()
        blocks = -(-self.samples // width)
        edges = [width * (blocks * i // count) for i in range(count)] + [self.samples]
        self._ranges = [pair for pair in pairwise(edges) if pair[0] < pair[1]]
        tracks = 2 * self.horizon + self._plan.draws
        count = len(self._ranges)
        self._scratch = [_aligned(tracks * self.shape[1] * width) for _ in range(count)]
        self._sums = _aligned(count * self.shape[0] * self.shape[1])
        self._shares = (_Share * count)()
        rows = self.shape[0] * self.shape[1]
        self._at = [  # addresses, found once: asking NumPy for one takes a microsecond
            (scratch.ctypes.data, self._sums.ctypes.data + 4 * i * rows, ctypes.addressof(self._shares[i]))
            for i, scratch in enumerate(self._scratch)
        ]
        self._others = ThreadPoolExecutor(count - 1, thread_name_prefix="mppi") if count > 1 else None

    def __call__(
        self,
        mean: Tensor,
        reference: int,
        draw: tuple[int, int],
        *,
        price: Tensor | None = None,
        noise: Tensor | None = None,
    ) -> tuple[Tensor, int]:
        """The new mean ``# (H, action)`` and the number of rollouts that were not finite.

        :attr:`state` and :attr:`inputs` are to be filled before; :attr:`costs` are filled after.

        Args:
            mean: of the last plan ``# (H, action)``, float32.
            reference: address of the references after each step ``# (H, state)``, float32, contiguous.
            draw: seed and number of the call, of the noise.
            price: λ Σ⁻¹ of the mean ``# (H, action)``, where noise is priced.
            noise: ``# (N, H, action)`` instead of noise of its own.
        """
        plan = self._plan
        mean = mean.contiguous()
        following = mean.clone()
        plan.mean, plan.reference = mean.data_ptr(), reference
        plan.seed, plan.call = draw[0] & 0xFFFFFFFF, draw[1] & 0xFFFFFFFF
        plan.price = None if price is None else price.data_ptr()
        plan.noise = None if noise is None else noise.data_ptr()
        if self.filters is not None:
            plan.begun = int(bool(self.filters.memories))
            self._memory[:] = memory_of(self.filters, self._memory.size)
        if self._others is None:
            self._run(0)
        else:
            waiting = [self._others.submit(self._run, i) for i in range(1, self.threads)]
            self._run(0)
            for one in waiting:
                one.result()
        share = ctypes.addressof(self._shares)
        rejected: int = self._library.finish(self._address, self.threads, self._at[0][1], share, following.data_ptr())
        return following, rejected

    def _run(self, thread: int) -> None:
        first, last = self._ranges[thread]
        self._library.plan_share(self._address, first, last, *self._at[thread])

    def noise(self, seed: int, call: int) -> Tensor:
        """The noise ``# (N, H, action)`` of a call."""
        plan = self._plan
        plan.seed, plan.call, plan.noise = seed & 0xFFFFFFFF, call & 0xFFFFFFFF, None
        found = np.empty((self.samples, *self.shape), dtype=np.float32)
        self._library.noise_of(self._address, self._at[0][0], found.ctypes.data)
        return torch.from_numpy(found)


def helpful_threads(step: FusedStep) -> int:
    """Two where this machine then takes a quarter less, else one; few samples are not worth asking."""
    if step.samples * step.horizon < WORTH_ASKING or (os.cpu_count() or 1) < 2:
        return 1
    seconds = {}
    rest, reference = torch.zeros(step.shape), np.zeros((step.horizon, step.state.size), dtype=np.float32)
    for count in (1, 2):
        step.threads = count
        durations = []
        for call in range(TRIALS):
            started = time.perf_counter()
            step(rest, reference.ctypes.data, (0, call))
            durations.append(time.perf_counter() - started)
        seconds[count] = min(durations)
    return 2 if seconds[2] < 0.75 * seconds[1] else 1


def _aligned(content: int | NDArray[np.floating]) -> Single:
    """A float32 array that starts at a cache line: of that size, zero, or a copy."""
    size = content if isinstance(content, int) else content.size
    raw = np.zeros(4 * size + LINE, dtype=np.uint8)
    start = -raw.ctypes.data % LINE
    array: Single = raw[start : start + 4 * size].view(np.float32)
    if not isinstance(content, int):
        array[:] = content.reshape(-1)
    return array
