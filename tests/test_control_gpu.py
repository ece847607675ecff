"""The GPU's text: compiled by NVRTC without a GPU, run on the processor thread by thread, and on a GPU where one is."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
import torch
from reference_models import flying, late

from sym2real.control.fused import FusedStep, PlanArguments, Sizes
from sym2real.control.fused_filters import FilterLines
from sym2real.control.fused_gpu import FusedGpuStep
from sym2real.control.fused_problem import Fused, Sampling
from sym2real.control.fused_text import fused_text
from sym2real.control.noise import covariance_factor, smoothing
from sym2real.effects.filters import FilterState
from sym2real.errors import CompilationError, MissingDependencyError
from sym2real.native import find_compiler, library
from sym2real.native.nvrtc import compile_cuda
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations
from sym2real.tasks import make_task

CASES = [(CRAZYFLIE, flying), (CRAZYFLIE, CRAZYFLIE.nominal), (MUSHR, late)]
SAMPLES, HORIZON = 300, 30
# Thread by thread, as a launch of enough blocks of 64 threads would.
EVERY_THREAD = """
C_NAME void launch(const struct plan *plan, real *tracks, real *draws) {
    blockDim.x = 64;
    for (blockIdx.x = 0; blockIdx.x * 64 < plan->samples; blockIdx.x++)
        for (threadIdx.x = 0; threadIdx.x < 64; threadIdx.x++) plan_samples(*plan, tracks, draws);
}
"""


def fused(robot: Robot, equations: Equations) -> tuple[Fused, FilterState | None, torch.Tensor]:
    filters = FilterState(equations) if equations.filters else None
    factor = covariance_factor(robot.mppi.noise).float()
    lines = FilterLines(filters, robot.layouts.action.columns, robot.dt)
    cost = make_task("circle", robot).cost
    return Fused(equations, robot, cost, Sampling.of(robot.mppi, factor), lines), filters, factor


def on_processor(robot: Robot, equations: Equations) -> tuple[FusedStep, torch.Tensor, np.ndarray, torch.Tensor]:
    """A step of the processor's kernel: itself, mean, references, new mean."""
    step, filters, factor = fused(robot, equations)
    kernel = FusedStep(equations, robot, step.cost, factor=factor, sizes=Sizes(SAMPLES, HORIZON), filters=filters)
    kernel.state[:] = robot.start
    mean = torch.tensor(robot.rest).float().repeat(HORIZON, 1)
    times = torch.arange(1, HORIZON + 1).double() * robot.dt
    reference = np.ascontiguousarray(make_task("circle", robot).reference(times).numpy(), dtype=np.float32)
    return kernel, mean, reference, kernel(mean, reference.ctypes.data, (3, 5))[0]


@pytest.mark.parametrize(("robot", "make"), CASES)
def test_nvrtc_compiles_it_for_old_and_new_devices(robot: Robot, make: object) -> None:
    text = fused_text(fused(robot, make())[0], "gpu")
    try:
        for architecture in ("compute_80", "compute_90"):
            ptx = compile_cuda(text, architecture)
            assert b".entry plan_samples" in ptx
            assert b".local" not in ptx or b"fma.rn.f32" in ptx
    except MissingDependencyError as error:
        pytest.skip(str(error))
    with pytest.raises(CompilationError, match="NVRTC failed"):
        compile_cuda(text.replace("plan_samples(const", "plan_samples(konst"))


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize(("robot", "make"), CASES)
def test_thread_by_thread_it_says_what_the_processors_kernel_says(robot: Robot, make: object) -> None:
    equations = make()
    kernel, mean, reference, expected = on_processor(robot, equations)
    step, _, factor = fused(robot, equations)
    shim = library("#define SHIM 1\n" + fused_text(step, "gpu") + EVERY_THREAD)
    smooth = smoothing(HORIZON, robot.dt, robot.mppi).float() if step.sampling.colour == 2 else torch.zeros(1, HORIZON)
    arguments = PlanArguments.of(robot, step.sampling, Sizes(SAMPLES, HORIZON), smooth.shape[1])
    arrays = {
        "state": robot.start, "inputs": np.zeros(max(1, len(equations.layouts.inputs))), "mean": mean.numpy(),
        "reference": reference, "low": robot.low, "high": robot.high, "factor": factor.numpy(),
        "smooth": smooth.numpy(), "costs": np.zeros(SAMPLES), "memory": np.zeros(64),
    }  # fmt: skip
    arrays = {name: np.ascontiguousarray(array, dtype=np.float32) for name, array in arrays.items()}
    for name, array in arrays.items():
        setattr(arguments, name, array.ctypes.data)
    arguments.seed, arguments.call = 3, 5
    tracks = np.zeros((HORIZON, len(robot.rest), SAMPLES), dtype=np.float32)
    draws = np.zeros((smooth.shape[1], len(robot.rest), SAMPLES), dtype=np.float32)
    pointers = [ctypes.c_void_p(array.ctypes.data) for array in (tracks, draws)]
    shim.launch(ctypes.byref(arguments), *pointers)
    np.testing.assert_allclose(arrays["costs"], kernel.costs, rtol=2e-5)
    weights = torch.softmax(-torch.from_numpy(arrays["costs"]).double() / robot.mppi.temperature, dim=0)
    found = torch.einsum("han,n->ha", torch.from_numpy(tracks).double(), weights)
    assert float(((found - expected).abs() / torch.tensor(robot.high - robot.low)).max()) < 2e-5


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device here")
@pytest.mark.parametrize(("robot", "make"), CASES)
def test_a_gpu_plans_as_the_processor_does(robot: Robot, make: object) -> None:
    equations = make()
    kernel, mean, reference, expected = on_processor(robot, equations)
    step, filters, factor = fused(robot, equations)
    device = torch.device("cuda")
    gpu = FusedGpuStep(step, factor=factor, sizes=Sizes(SAMPLES, HORIZON), device=device, filters=filters)
    inputs = torch.zeros(max(1, len(equations.layouts.inputs)))
    found, rejected = gpu(torch.tensor(robot.start), inputs, mean.to(device), torch.from_numpy(reference), (3, 5))
    assert rejected == 0
    np.testing.assert_allclose(gpu.costs.cpu().numpy(), kernel.costs, rtol=1e-4)
    assert float(((found.cpu() - expected).abs() / torch.tensor(robot.high - robot.low)).max()) < 1e-4
