"""The GPU's text: compiled by NVRTC without a GPU, run on the processor thread by thread, and on a GPU where one is."""

from __future__ import annotations

import ctypes
from dataclasses import replace

import pytest
import torch
from reference_models import flying, late, motor_lagged

from sym2real.control import MPPI
from sym2real.control.backend import fused_step
from sym2real.control.fused import FusedStep
from sym2real.control.fused_arguments import Call, PlanArguments, Sizes
from sym2real.control.fused_filters import FilterLines, memory_of
from sym2real.control.fused_gpu import FusedGpuStep
from sym2real.control.fused_problem import Fused
from sym2real.control.fused_residual import Network
from sym2real.control.fused_text import fused_text
from sym2real.effects.filters import FilterState
from sym2real.effects.visible import VisibleModel
from sym2real.errors import CompilationError, MissingDependencyError
from sym2real.native import find_compiler, library
from sym2real.native.nvrtc import compile_cuda
from sym2real.neural import ResidualMLP
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations, compile_model
from sym2real.tasks import make_task

NETWORK, MEMORY = ((20, 12), 0, 0), ((20, 12), 10, 2)  # widths, past commands and states
CASES = [
    (CRAZYFLIE, flying, ()),
    (CRAZYFLIE, CRAZYFLIE.nominal, ()),
    (CRAZYFLIE, motor_lagged, ()),
    (MUSHR, late, ()),
    (MUSHR, MUSHR.nominal, NETWORK),
    (MUSHR, late, MEMORY),
    (CRAZYFLIE, flying, MEMORY),
]
SAMPLES, HORIZON = 300, 30
SIZES = Sizes(SAMPLES, HORIZON)
# What CUDA has and C has not.
SHIM = r"""
#define __device__
#define __global__
#define __forceinline__ inline
#define __noinline__ __attribute__((noinline))
#define __float_as_uint(x) (((union { float f; unsigned int u; }){.f = (x)}).u)
#define __uint_as_float(x) (((union { float f; unsigned int u; }){.u = (x)}).f)
#define C_NAME __attribute__((visibility("default")))
float sqrtf(float), rintf(float), expf(float), logf(float), tanf(float), asinf(float), acosf(float), atanf(float);
float tanhf(float), sinhf(float), coshf(float), asinhf(float), acoshf(float), atanhf(float), floorf(float);
float ceilf(float), atan2f(float, float), powf(float, float), fmodf(float, float);
struct index {
    unsigned int x;
};
static struct index blockIdx, blockDim, threadIdx;
#define __launch_bounds__(n)
"""
# Thread by thread, as a launch of blocks would.
EVERY_THREAD = """
C_NAME void launch_{kernel}(int blocks, int threads, const struct plan *plan, real *tracks, real *draws) {{
    blockDim.x = threads;
    for (blockIdx.x = 0; blockIdx.x < blocks; blockIdx.x++)
        for (threadIdx.x = 0; threadIdx.x < threads; threadIdx.x++) {kernel}(*plan, tracks, draws);
}}
"""


class Shim:
    """What loads the GPU's text on the processor."""

    def __init__(self, text: str, device: torch.device) -> None:
        launches = "".join(EVERY_THREAD.format(kernel=kernel) for kernel in ("plan_samples", "noise_of"))
        self.library = library(SHIM + text + launches)

    def __call__(self, kernel: str, blocks: int, threads: int, plan: PlanArguments, *pointers: ctypes.c_void_p) -> None:
        getattr(self.library, f"launch_{kernel}")(blocks, threads, ctypes.byref(plan), *pointers)


class Case:
    """What both machines compute: the step, and what it is given."""

    def __init__(self, robot: Robot, equations: Equations, network: tuple) -> None:
        self.robot = robot
        self.residual = None
        if network:
            widths, commands, states = network
            self.residual = ResidualMLP(robot.layouts, widths, 1, commands, states)
            with torch.no_grad():
                self.residual.linears[-1].weight.normal_(0.0, 1e-3, generator=torch.Generator().manual_seed(2))
        self.filters = FilterState(equations) if equations.filters else None
        lines = FilterLines(self.filters, robot.layouts.action.columns, robot.dt)
        layers = None if self.residual is None else Network.of(self.residual)
        self.step = Fused(equations, robot, make_task("circle", robot).cost, lines, layers)

    def calls(self) -> list[Call]:
        """The first one, and one that follows it: shifted, with memory, with noise from outside."""
        robot, actions = self.robot, len(self.robot.rest)
        times = torch.arange(1, HORIZON + 1).double() * robot.dt
        reference = make_task("circle", robot).reference(times).float().contiguous()
        mean = torch.tensor(robot.rest).float().repeat(HORIZON, 1)
        inputs = torch.zeros(len(self.step.equations.layouts.inputs))
        first = Call(torch.tensor(robot.start).float(), inputs, reference, mean, steps=0, seed=3, call=5)
        generator = torch.Generator().manual_seed(4)
        memory = None
        if self.filters is not None:
            self.filters.remember(torch.tensor(0.5 * (robot.low + robot.high)))
            memory = torch.from_numpy(memory_of(self.filters)).float()
        past = None
        if self.step.residual is not None and self.residual.commands:
            lasting = self.step.residual.sizes[0] - len(robot.start) - actions
            past = torch.randn(lasting, generator=generator)
        noise = 0.1 * torch.randn(SAMPLES, HORIZON, actions, generator=generator)
        size = len(self.step.equations.start)
        hidden = 0.1 * torch.randn(size, generator=generator) if size else None
        sloped = mean + 0.01 * torch.arange(HORIZON)[:, None]
        return [first, first._replace(mean=sloped, steps=3, noise=noise, memory=memory, past=past, hidden=hidden)]

    def same(self, found: tuple, expected: tuple, tolerance: float) -> None:
        """Costs, and the means within the limits."""
        scale = torch.tensor(self.robot.high - self.robot.low)
        assert found[2] == expected[2] == 0
        torch.testing.assert_close(found[1].cpu(), expected[1], rtol=tolerance, atol=1e-4)
        assert float(((found[0].cpu() - expected[0]).abs() / scale).max()) < tolerance


@pytest.mark.parametrize(("robot", "make", "network"), CASES)
def test_nvrtc_compiles_it_for_old_and_new_devices(robot: Robot, make: object, network: tuple) -> None:
    text, first = fused_text(Case(robot, make(), network).step, "gpu"), make is flying and not network
    try:
        for architecture in ("sm_80", "sm_90") if first else ("sm_80",):
            code = compile_cuda(text, architecture)
            assert code.startswith(b"\x7fELF") and b".text.plan_samples" in code and b".text.noise_of" in code
    except MissingDependencyError as error:
        pytest.skip(str(error))
    if first:
        with pytest.raises(CompilationError, match="NVRTC failed"):
            compile_cuda(text.replace("plan_samples(const", "plan_samples(konst"), "sm_80")


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize(("robot", "make", "network"), CASES)
def test_thread_by_thread_it_says_what_the_processors_kernel_says(robot: Robot, make: object, network: tuple) -> None:
    """The host's code is the GPU's, and the threads run on the processor one after the other."""
    case = Case(robot, make(), network)
    here = FusedStep(case.step, sizes=SIZES, residual=case.residual)
    device = torch.device("cpu")
    there = FusedGpuStep(case.step, sizes=SIZES, device=device, residual=case.residual, load=Shim)
    torch.testing.assert_close(there.noise(3, 5), here.noise(3, 5), rtol=1e-5, atol=1e-6)
    for call in case.calls():
        case.same(there(call), here(call), 2e-5)
    broken = call._replace(state=torch.full_like(call.state, torch.nan))
    mean, costs, rejected = there(broken)
    assert rejected == SAMPLES and not costs.isfinite().any()
    torch.testing.assert_close(mean, here(broken)[0])


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device here")
@pytest.mark.parametrize(("robot", "make", "network"), CASES)
def test_a_gpu_plans_as_the_processor_does(robot: Robot, make: object, network: tuple) -> None:
    case = Case(robot, make(), network)
    here = FusedStep(case.step, sizes=SIZES, residual=case.residual)
    device = torch.device("cuda", 0)
    there = FusedGpuStep(case.step, sizes=SIZES, device=device, residual=case.residual)
    torch.testing.assert_close(there.noise(3, 5).cpu(), here.noise(3, 5), rtol=1e-4, atol=1e-5)
    for call in case.calls():
        moved = [one.to(device) if isinstance(one, torch.Tensor) else one for one in call]
        case.same(there(Call(*moved)), here(call), 1e-4)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device here")
def test_mppi_on_a_gpu_uses_it() -> None:
    task, robot = make_task("circle", CRAZYFLIE), replace(CRAZYFLIE, mppi=replace(CRAZYFLIE.mppi, samples=SAMPLES))
    there = MPPI(VisibleModel(flying()), robot, task, device="cuda", backend="c")
    here = MPPI(VisibleModel(flying()), robot, task, backend="c")
    for step in range(3):
        torch.testing.assert_close(
            torch.tensor(there.act(robot.start, step)), torch.tensor(here.act(robot.start, step)), rtol=0, atol=1e-3
        )


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device")
def test_without_a_gpu_its_step_says_what_is_missing() -> None:
    task = make_task("circle", MUSHR)
    with pytest.raises((CompilationError, MissingDependencyError)):
        case = Case(MUSHR, MUSHR.nominal(), ())
        FusedGpuStep(case.step, sizes=SIZES, device=torch.device("cuda", 0))
    assert isinstance(
        fused_step(compile_model(MUSHR.nominal()), MUSHR, task, device=torch.device("cpu"), sizes=SIZES, filters=None),
        FusedStep,
    )
