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

import ast
from importlib import import_module
from pathlib import Path

__version__ = "0.1.0"


def _owners() -> dict[str, str]:
    """Public name → the module that it is in, as the stub beside this file says."""
    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = (node for node in stub.body if isinstance(node, ast.ImportFrom))
    return {alias.name: str(node.module) for node in imports for alias in node.names}


_OWNERS = _owners()
__all__ = sorted(_OWNERS)  # noqa: PLE0605 — a list that is read


def __getattr__(name: str) -> object:
    if name in _OWNERS:
        return getattr(import_module(_OWNERS[name]), name)
    raise AttributeError(f"module 'sym2real' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
