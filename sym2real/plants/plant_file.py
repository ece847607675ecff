"""A changed robot as files: a description that any MuJoCo opens, and beside it what a description cannot hold.

``robot.xml`` has the masses, the centre of mass, the friction, the actuators' lags: everything that a change edits
before compilation. ``plant.toml`` names every effect with its values; the forces, command filters and sensors among
them act when :func:`load_plant` opens the folder. MuJoCo writes numbers with six digits.

``origin.json`` makes a robot again that no registry knows, without the effects.
"""

import json
import sys
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import mujoco

from sym2real.effects import effect
from sym2real.errors import DataError, ModelError, Sym2RealError, reason
from sym2real.files import read_as, read_text, read_toml, whole, write_text
from sym2real.plants.mujoco_plant import MujocoPlant, edited
from sym2real.robots import ROBOTS, Robot
from sym2real.robots.own import origin_of, robot_from
from sym2real.symbolic.serialise import Origin

DESCRIPTION, PLANT, ORIGIN = "robot.xml", "plant.toml", "origin.json"
PARTS = (DESCRIPTION, PLANT, ORIGIN)
HEADER = """\
# A simulated robot with effects. {description} holds what a body, a tyre or an actuator has; the effects' forces,
# command filters and sensors act where this folder is opened: sym2real simulate FOLDER TASK, or load_plant(FOLDER).
"""

Chosen = Iterable[tuple[str, Mapping[str, float]]]


def save_plant(robot: Robot, effects: Chosen, folder: str | Path) -> tuple[Path, Path]:
    """Write a robot with effects.

    Args:
        robot: the plain robot.
        effects: keys with their values by parameter name, SI units.
        folder: is made where it is missing.

    Returns:
        The description and the plant file.

    Raises:
        UnknownNameError: for an effect or parameter that does not exist.
        ModelError: for an effect that the simulated robot cannot have.
        DataError: when there is no writing there.
    """
    folder, given = Path(folder), [(key, dict(values)) for key, values in effects]
    origin = origin_of(robot)
    if origin is not None:
        robot = robot_from(origin)  # which needs no file beside its description
    changes = [effect(key, robot).inject(**values) for key, values in given]
    lines = [HEADER.format(description=DESCRIPTION), f'robot = "{robot.name}"', f'description = "{DESCRIPTION}"']
    lines += [] if origin is None else [f'origin = "{ORIGIN}"']
    for key, values in given:
        lines += ["", "[[effects]]", f"effect = {json.dumps(key)}"]
        lines += [f"{name} = {float(value)!r}" for name, value in values.items()]
    description = edited(robot, changes)
    description.compile()  # MuJoCo writes only what it has compiled
    with whole(folder / DESCRIPTION) as body, whole(folder / PLANT) as plant:
        body.write_text(description.to_xml(), encoding="utf-8")
        plant.write_text("\n".join(lines) + "\n", encoding="utf-8")
    if origin is not None:
        write_text(folder / ORIGIN, msgspec.json.encode(origin).decode())
    return folder / DESCRIPTION, folder / PLANT


def load_plant(folder: str | Path) -> MujocoPlant:
    """The simulated robot of a folder that :func:`save_plant` wrote; its files may have been edited since.

    Raises:
        DataError: when a file is missing or cannot be read, names a robot that does not exist or describes another one.
        ModelError: for an effect, parameter or value that does not exist or that the simulated robot cannot have.
    """
    file = Path(folder) / PLANT
    what = "a plant file: robot, description and [[effects]]"
    table = read_toml(file, what)
    try:
        robot, description = _robot(table, file.parent), file.parent / table["description"]
        chosen = [(str(entry.pop("effect")), entry) for entry in table.get("effects", [])]
    except (KeyError, AttributeError, TypeError) as error:
        raise DataError(file, what, reason(error)) from error
    if description.parent != file.parent:
        raise DataError(file, "a description beside the plant file", repr(table["description"]))
    # The description has been edited already: what is left of every effect acts while the simulation runs.
    try:
        changes = [replace(effect(key, robot).inject(**_numbers(key, values)), edit=None) for key, values in chosen]
    except Sym2RealError as error:
        raise ModelError(f"{file}: {error}") from error
    what = f"a MuJoCo description of a {robot.name}"
    try:
        return MujocoPlant(robot, changes, description=read_text(description, what))
    except (OSError, ValueError, mujoco.FatalError) as error:
        raise DataError(description, what, " ".join(reason(error).split())) from error


def _robot(table: Mapping[str, Any], folder: Path) -> Robot:
    """The plain robot: by its description where there is one, else the registered one of that name."""
    if "origin" not in table:
        return ROBOTS[table["robot"]]
    if table["origin"] != ORIGIN:
        raise DataError(folder / PLANT, f"origin = {ORIGIN!r}", f"{table['origin']!r:.80}")
    return robot_from(read_as(folder / ORIGIN, Origin, "what makes a robot"))


def _numbers(key: str, values: Mapping[str, Any]) -> dict[str, float]:
    for name, value in values.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ModelError(f"{key}: expected a number for {name}, found {value!r:.80}")
        if not abs(value) <= sys.float_info.max:
            raise ModelError(f"{key}: expected a finite number for {name}, found {value!r:.80}")
    return {name: float(value) for name, value in values.items()}
