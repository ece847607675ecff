"""Which way MPPI computes: one fused kernel where that is possible, torch everywhere."""

from __future__ import annotations

from typing import Literal

import sympy
import torch

from sym2real.effects.visible import visible_state
from sym2real.native import find_compiler
from sym2real.robots.robot import Robot
from sym2real.symbolic import Equations, read_back
from sym2real.tasks import Task

Backend = Literal["auto", "c", "torch"]
NO_COMPILER = "there is no C compiler here (install gcc or clang, or name one by CC)"


def equations_of(model: object) -> Equations | None:
    """The equations that a compiled model was made of, with the values that it has now; None for other models."""
    equations = getattr(model, "equations", None)
    if not isinstance(equations, Equations):
        return None
    if isinstance(model, torch.jit.ScriptModule) and equations.parameters:
        return read_back(model, equations)
    return equations


def why_not_fused(model: object, robot: Robot, task: Task, device: torch.device, dtype: torch.dtype) -> str:
    """Why the fused kernel cannot plan with this; empty where it can, as far as can be seen before compiling."""
    equations = equations_of(model)
    if equations is None:
        return "the model is not compiled from equations"
    if not isinstance(task.cost, sympy.Expr):
        return "the task's cost is no expression"
    if device.type != "cpu" or dtype != torch.float32:
        return f"it plans in float32 on the processor, not in {dtype} on {device.type}"
    if (visible_state(equations).columns, equations.layouts.action.columns) != (
        robot.layouts.state.columns,
        robot.layouts.action.columns,
    ):
        return "the model's columns are not the robot's"
    if equations.layouts.state != visible_state(equations) and isinstance(model, torch.jit.ScriptModule):
        return "the model expects hidden states from outside"
    return "" if find_compiler() else NO_COMPILER
