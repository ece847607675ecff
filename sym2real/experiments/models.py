"""A model by what a user calls it: a folder, or a robot's name, whose base is learned once and cached."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import platformdirs
from filelock import FileLock

from sym2real import __version__
from sym2real.errors import ModelError, UnknownNameError
from sym2real.files import make_folder
from sym2real.neural import Model, open_model as open_folder
from sym2real.neural.composed import Base, state_of
from sym2real.neural.model_folder import below, holds_model
from sym2real.plants import MujocoPlant, load_plant
from sym2real.plants.plant_file import PLANT
from sym2real.robots import ROBOTS, Robot
from sym2real.robots.own import robot_of
from sym2real.symbolic import Equations, load_model

if TYPE_CHECKING:
    from sym2real.adaptation import Progress
    from sym2real.experiments.learning import Learned


def open_model(name: str, on_progress: Callable[[Progress], None] = lambda _: None) -> Model:
    """The model of a folder, whole, or the base of a robot.

    Args:
        name: path of a folder that ``learn``, ``nominal``, ``add`` or ``adapt`` wrote, or a robot's name.
        on_progress: told what is going on when a robot's base has to be learned first.

    Raises:
        UnknownNameError: when it is neither.
        ModelError: when the folder does not hold a model, or one that cannot be of the robot that it names.
    """
    if Path(name).is_dir():
        model = open_folder(Path(name))
        _require_columns_of_its_robot(below(model), name)
        return model
    if Path(name).suffix.lower() == ".xml":
        raise ModelError(
            f"{name} is a robot's description: `sym2real nominal mjcf {name} --out FOLDER` makes its model"
        )
    if name not in ROBOTS:
        raise UnknownNameError("model: neither a folder nor a robot", name, ROBOTS)
    return cached_base(ROBOTS[name], on_progress)


def _require_columns_of_its_robot(base: Base, name: str) -> None:
    if getattr(base, "origin", None) is not None or base.robot not in ROBOTS:
        return
    columns, wanted = state_of(base).columns, ROBOTS[base.robot].layouts.state.columns
    if columns != wanted:
        raise ModelError(
            f"{name}: its model names the robot {base.robot}: expected the state {' '.join(wanted)}, "
            f"found {' '.join(columns)}"
        )


def robot_called(name: str) -> Robot:
    """A registered robot by its name, or the robot of a model folder.

    Raises:
        UnknownNameError: when it is neither.
        ModelError: for the folder of a model that does not say whose it is.
        DataError: for a folder without a model.
    """
    return described_robot(below(open_folder(Path(name))), name) if Path(name).is_dir() else ROBOTS[name]


def simulator_called(name: str) -> MujocoPlant:
    """The simulator of a folder, or the plain one of a robot's name or of a model folder.

    Raises:
        UnknownNameError, ModelError, DataError: as of :func:`robot_called` and :func:`~sym2real.load_plant`.
    """
    written = Path(name).is_dir() and not holds_model(Path(name))
    return load_plant(name) if written else MujocoPlant(robot_called(name))


def target_called(name: str, robot: Robot) -> MujocoPlant:
    """The simulator of that name, as a target of a robot's model.

    Raises:
        ModelError: for a robot of other columns or another control period, and for the folder of a model that has a
            simulator in it, which would be another one.
        UnknownNameError, DataError: as of :func:`simulator_called`.
    """
    inside = Path(name) / "simulator"
    if (inside / PLANT).exists():
        raise ModelError(f"{name} is a model; expected the simulator in it: {inside}")
    plant = simulator_called(name)
    if plant.robot.layouts != robot.layouts:
        raise ModelError(f"{name} is a {plant.robot.name}; the model is of a {robot.name}, of other columns")
    if plant.robot.dt != robot.dt:
        raise ModelError(f"{name}: expected the model's control period of {robot.dt:g} s, found {plant.robot.dt:g} s")
    return plant


def described_robot(base: Base, name: str) -> Robot:
    """The robot that a model is of; ``name`` is what the user calls the model.

    Raises:
        ModelError: for a model that does not say whose it is, or names a robot that nobody knows.
    """
    robot = robot_of(base)
    if robot is None:
        actual = f"one of {base.robot!r}" if base.robot else "one of numbers or logs alone, which no simulator flies"
        raise ModelError(
            f"{name}: expected the model of a robot that has a description, found {actual}; `sym2real learn "
            f"{next(iter(ROBOTS))} --out FOLDER` makes a model that `run` flies, `sym2real nominal mjcf` your own"
        )
    return robot


def cached_base(robot: Robot, on_progress: Callable[[Progress], None] = lambda _: None) -> Equations:
    """The base of a robot in its plain simulator, learned at the first call and kept in the user's cache."""
    folder = base_folder(robot)
    if not _is_there(folder):
        make_folder(folder.parent)
        with FileLock(f"{folder}.lock"):  # another process may learn it at the same time
            if not _is_there(folder):
                _learned(robot, folder, on_progress).save(folder)
    return load_model(folder)


def _is_there(folder: Path) -> bool:
    return (folder / "equations.json").exists()


def _learned(robot: Robot, folder: Path, on_progress: Callable[[Progress], None]) -> Learned:
    # Seconds to import, and needed once a robot.
    from sym2real.adaptation import StageOne  # noqa: PLC0415
    from sym2real.experiments.learning import (  # noqa: PLC0415
        from_description,
        learn_from_drives,
        learn_in_simulation,
    )

    count = robot.recipe.episodes
    if robot.recipe.base == "drives":
        return learn_from_drives(robot, count)
    if robot.recipe.base == "nominal":
        return from_description(robot)
    settings = StageOne(episodes=count, until_settled=False)
    return learn_in_simulation(robot, "beam", settings, folder / "episodes", on_progress)


def base_folder(robot: Robot) -> Path:
    """Where a robot's base is cached, or will be."""
    name = f"base-{robot.name}-{robot.recipe.episodes}-{robot.recipe.base}"
    return Path(platformdirs.user_cache_dir("sym2real")) / __version__ / name
