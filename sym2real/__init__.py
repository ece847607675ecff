"""From a robot description to symbolic equations, control, and the physical effect that a model misses.

The main path, in the order of its use::

    robot = ROBOTS["crazyflie"]
    base = learn_base(MujocoPlant(robot), tasks, BeamSearch(angles=robot.recipe.angles))
    log = run_episode(target, MPPI(compile_model(base), robot, task), task)  # or read_log("flight.csv")
    gap = compare(base, log)
    found = diagnose(base, log, MujocoPlant(robot))
    informed = found.apply(base)

Names are imported on first use, so that ``import sym2real`` costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sym2real.adaptation import StageOne as StageOne
    from sym2real.adaptation import learn_base as learn_base
    from sym2real.adaptation.adapt import Adapting as Adapting
    from sym2real.adaptation.adapt import adapt as adapt
    from sym2real.control import MPPI as MPPI
    from sym2real.data import example_flight as example_flight
    from sym2real.dataset import Dataset as Dataset
    from sym2real.diagnosis import add as add
    from sym2real.diagnosis import compare as compare
    from sym2real.diagnosis import diagnose as diagnose
    from sym2real.diagnosis import plan as plan
    from sym2real.diagnosis import try_effect as try_effect
    from sym2real.effects import EFFECTS as EFFECTS
    from sym2real.effects.catalogue import effect as effect
    from sym2real.experiments.standard_conditions import sensors as sensors
    from sym2real.layout import Layout as Layout
    from sym2real.layout import Layouts as Layouts
    from sym2real.logs import LogSpec as LogSpec
    from sym2real.logs import inspect_logs as inspect_logs
    from sym2real.logs import read_log as read_log
    from sym2real.logs import read_logs as read_logs
    from sym2real.logs import write_log as write_log
    from sym2real.neural import ResidualTraining as ResidualTraining
    from sym2real.plants import EquationsPlant as EquationsPlant
    from sym2real.plants import ModelPlant as ModelPlant
    from sym2real.plants import MujocoPlant as MujocoPlant
    from sym2real.plants import run_episode as run_episode
    from sym2real.regression import ENGINES as ENGINES
    from sym2real.regression import BeamSearch as BeamSearch
    from sym2real.regression import Operon as Operon
    from sym2real.regression import PySR as PySR
    from sym2real.robots import ROBOTS as ROBOTS
    from sym2real.robots import Robot as Robot
    from sym2real.robots import car as car
    from sym2real.robots import quadrotor as quadrotor
    from sym2real.symbolic import Equations as Equations
    from sym2real.symbolic import compile_model as compile_model
    from sym2real.symbolic import load_model as load_model
    from sym2real.symbolic import rollout as rollout
    from sym2real.symbolic import save_model as save_model
    from sym2real.tasks import TASKS as TASKS
    from sym2real.tasks import Task as Task
    from sym2real.tasks import make_task as make_task
    from sym2real.trajectory import Trajectory as Trajectory

__version__ = "0.1.0"

_NAMES = {
    "adaptation": ("StageOne", "learn_base"),
    "adaptation.adapt": ("Adapting", "adapt"),
    "control": ("MPPI",),
    "data": ("example_flight",),
    "diagnosis": ("add", "compare", "diagnose", "plan", "try_effect"),
    "effects": ("EFFECTS",),
    "effects.catalogue": ("effect",),
    "experiments.standard_conditions": ("sensors",),
    "layout": ("Layout", "Layouts"),
    "logs": ("LogSpec", "inspect_logs", "read_log", "read_logs", "write_log"),
    "neural": ("ResidualTraining",),
    "plants": ("EquationsPlant", "ModelPlant", "MujocoPlant", "run_episode"),
    "regression": ("ENGINES", "BeamSearch", "Operon", "PySR"),
    "robots": ("ROBOTS", "Robot", "car", "quadrotor"),
    "symbolic": ("Equations", "compile_model", "load_model", "rollout", "save_model"),
    "tasks": ("TASKS", "Task", "make_task"),
    "trajectory": ("Trajectory",),
    "dataset": ("Dataset",),
}
_OWNERS = {name: owner for owner, names in _NAMES.items() for name in names}

__all__ = sorted(_OWNERS)  # noqa: PLE0605 — the names above, which the tests hold against the imports


def __getattr__(name: str) -> object:
    from importlib import import_module  # noqa: PLC0415 — it would be a name of the package

    if name in _OWNERS:
        return getattr(import_module(f"sym2real.{_OWNERS[name]}"), name)
    raise AttributeError(f"module 'sym2real' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
