"""From a robot description to symbolic equations, control, and the physical effect that a model misses.

The main path, in the order of its use::

    robot = ROBOTS["crazyflie"]
    plant = MujocoPlant(robot)
    base = learn_base(plant, tasks, engine=BeamSearch())
    model = compile_model(base)
    mppi = MPPI(model, robot, task)
    measured = run_episode(target, mppi, task)
    gap = compare(base, measured)

Names are imported on first use, so that ``import sym2real`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_OWNERS = {
    "ROBOTS": "robots",
    "Robot": "robots",
    "quadrotor": "robots",
    "car": "robots",
    "MujocoPlant": "plants",
    "ModelPlant": "plants",
    "EquationsPlant": "plants",
    "run_episode": "plants",
    "TASKS": "tasks",
    "Task": "tasks",
    "make_task": "tasks",
    "BeamSearch": "regression",
    "PySR": "regression",
    "Operon": "regression",
    "ENGINES": "regression",
    "Equations": "symbolic",
    "compile_model": "symbolic",
    "rollout": "symbolic",
    "save_model": "symbolic",
    "load_model": "symbolic",
    "MPPI": "control",
    "learn_base": "adaptation",
    "StageOne": "adaptation",
    "compare": "diagnosis",
    "read_log": "logs",
    "read_logs": "logs",
    "write_log": "logs",
    "inspect_logs": "logs",
    "LogSpec": "logs",
    "Trajectory": "trajectory",
    "Dataset": "trajectory",
    "Layout": "layout",
    "Layouts": "layout",
}

__all__ = [
    "ENGINES",
    "MPPI",
    "ROBOTS",
    "TASKS",
    "BeamSearch",
    "Dataset",
    "Equations",
    "EquationsPlant",
    "Layout",
    "Layouts",
    "LogSpec",
    "ModelPlant",
    "MujocoPlant",
    "Operon",
    "PySR",
    "Robot",
    "StageOne",
    "Task",
    "Trajectory",
    "car",
    "compare",
    "compile_model",
    "inspect_logs",
    "learn_base",
    "load_model",
    "make_task",
    "quadrotor",
    "read_log",
    "read_logs",
    "rollout",
    "run_episode",
    "save_model",
    "write_log",
]


def __getattr__(name: str) -> Any:
    if name in _OWNERS:
        return getattr(import_module(f"sym2real.{_OWNERS[name]}"), name)
    raise AttributeError(f"module 'sym2real' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
