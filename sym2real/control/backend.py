"""Which way MPPI computes: one fused kernel where that is possible, torch everywhere."""

import inspect
import logging
from collections.abc import Callable
from typing import Literal, cast, get_args

import sympy
import torch
from torch import Tensor

from sym2real.control.fused import FusedStep
from sym2real.control.fused_arguments import Sizes
from sym2real.control.fused_filters import FilterLines
from sym2real.control.fused_gpu import FusedGpuStep
from sym2real.control.fused_problem import Fused
from sym2real.control.fused_residual import Network
from sym2real.effects.filters import FilterState
from sym2real.effects.visible import VisibleModel, visible_state
from sym2real.errors import CompilationError, MissingDependencyError, ModelError, ShapeError, UnknownNameError
from sym2real.native import find_compiler
from sym2real.protocols import DynamicsModel
from sym2real.robots.robot import Robot
from sym2real.symbolic import equations_of
from sym2real.tasks import Task

LOGGER = logging.getLogger(__name__)
Backend = Literal["auto", "c", "torch"]
BACKENDS: tuple[Backend, ...] = get_args(Backend)
Step = FusedStep | FusedGpuStep
NO_COMPILER = "there is no C compiler here (install gcc or clang, or name one by CC)"


def require_choices(backend: str, period: float) -> None:
    """Refuse what :class:`~sym2real.control.MPPI` cannot be asked for.

    Raises:
        UnknownNameError: for a backend that does not exist, with those that do.
        ShapeError: for a period in s that is not positive.
    """
    if not period > 0.0:
        raise ShapeError(f"expected a control period > 0 s, found {period!r}")
    if backend not in BACKENDS:
        raise UnknownNameError("backend", str(backend), BACKENDS)


def device_of(device: str | torch.device) -> torch.device:
    """A device that torch has here, by its number where there can be several.

    Raises:
        ModelError: for any other, with those that it has.
    """
    try:
        return torch.zeros(1, device=torch.device(device)).device
    except (RuntimeError, AssertionError, NotImplementedError, TypeError):
        here = ["cpu", *(f"cuda:{number}" for number in range(torch.cuda.device_count()))]
        raise ModelError(f"device: expected one that torch has here ({', '.join(here)}), found {device!r}") from None


def planned_with(model: DynamicsModel | Callable[[Tensor, Tensor], Tensor], dtype: torch.dtype) -> DynamicsModel:
    """A model over measured states that takes inputs.

    A plain ``(state, action)`` callable is given no inputs; hidden states of a compiled model start where its equations
    say, unless they stand behind the measured ones.

    Raises:
        ModelError: for what cannot be called.
    """
    if not callable(model):
        raise ModelError(
            f"expected a model that can be called, such as compile_model(equations), found {type(model).__name__}; "
            "sym2real.control.mppi_controller(equations, robot, task) plans with their delays and lags, too"
        )
    equations = equations_of(model)
    hidden = equations is not None and visible_state(equations) != equations.layouts.state
    if equations is not None and hidden and isinstance(model, torch.jit.ScriptModule):
        return VisibleModel(equations, dtype)
    plain = not isinstance(model, torch.nn.Module) and not hasattr(model, "rollout")
    if plain and len(inspect.signature(model).parameters) == 2:
        return lambda state, action, inputs=None: model(state, action)
    return cast(DynamicsModel, model)


def why_not_fused(model: object, robot: Robot, task: Task, device: torch.device, dtype: torch.dtype) -> str:
    """Why the fused kernel cannot plan with this; empty where it can, as far as can be seen before compiling."""
    equations = equations_of(model)
    if equations is None:
        return "the model is not compiled from equations"
    if not isinstance(task.cost, sympy.Expr):
        return "the task's cost is no expression"
    if device.type not in ("cpu", "cuda") or dtype != torch.float32:
        return f"it plans in float32 on the processor or a CUDA device, not in {dtype} on {device.type}"
    if (visible_state(equations).columns, equations.layouts.action.columns) != (
        robot.layouts.state.columns,
        robot.layouts.action.columns,
    ):
        return "the model's columns are not the robot's"
    return "" if device.type == "cuda" or find_compiler() else NO_COMPILER


def fused_step(
    model: object, robot: Robot, task: Task, *, device: torch.device, sizes: Sizes, filters: FilterState | None
) -> Step:
    """The kernel for a model, on a device.

    Args:
        model: with equations.
        robot: its ``mppi`` says how commands are sampled.
        task: its cost is an expression.
        device: where it runs.
        sizes: of the sampling.
        filters: what actions go through.

    Raises:
        CompilationError: when it cannot be compiled here.
        MissingDependencyError: for a CUDA device, without NVRTC.
        ModelError: when the equations, the cost or a filter have no fused form.
    """
    equations, cost = equations_of(model), task.cost
    if equations is None or not isinstance(cost, sympy.Expr):
        raise ModelError("a fused kernel needs equations and a cost that is an expression")
    residual = getattr(model, "residual", None)
    lines = FilterLines(filters, robot.layouts.action.columns, equations.dt)
    network = None if residual is None else Network.of(residual)
    step = Fused(equations, robot, cost, lines, network)
    if device.type == "cuda":
        return FusedGpuStep(step, sizes=sizes, device=device, residual=residual)
    return FusedStep(step, sizes=sizes, residual=residual)


def choose(backend: Backend, reason: str, fuse: Callable[[], Step]) -> tuple[Step | None, str]:
    """The fused step, or why there is none; said once in the log, as a warning where it should have been possible.

    Args:
        backend: what was asked for.
        reason: why it cannot be; empty where nothing speaks against it.
        fuse: makes it.

    Raises:
        ModelError: when the kernel was asked for and cannot be had.
    """
    fused, reason, level = None, "torch was asked for" if backend == "torch" else reason, logging.INFO
    if not reason:
        try:
            fused = fuse()
        except (CompilationError, MissingDependencyError, ModelError) as error:
            reason, level = str(error), logging.WARNING
    if fused is None and backend == "c":
        raise ModelError(f"the fused kernel cannot plan here: {reason}")
    LOGGER.log(level, "MPPI plans by %s", f"torch ({reason})" if fused is None else fused.description)
    return fused, reason
