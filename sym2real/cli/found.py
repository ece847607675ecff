"""What ``diagnose`` and ``add --fit`` share: the plain simulator, and the files that a result leaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

if TYPE_CHECKING:
    from sym2real.diagnosis import Diagnosis, Tried
    from sym2real.plants import MujocoPlant
    from sym2real.symbolic import Equations
    from sym2real.trajectory import Dataset


def plain_simulator(equations: Equations) -> MujocoPlant | None:
    """The simulator that a model was learned from, or that its numbers describe; None for robots that have none."""
    from sym2real.effects.visible import visible_state
    from sym2real.plants import MujocoPlant
    from sym2real.robots import ROBOTS

    if equations.robot not in ROBOTS:
        return None
    robot = ROBOTS[equations.robot]
    same = visible_state(equations) == robot.layouts.state and equations.layouts.action == robot.layouts.action
    return MujocoPlant(robot) if same else None


def write_model_and_simulator(
    base: Equations, effects: Sequence[tuple[str, Mapping[str, float]]], folder: Path, console: Console
) -> Equations:
    """The informed model into ``folder/model``, the robot with the effects into ``folder/simulator``."""
    from sym2real.diagnosis import add
    from sym2real.symbolic import save_model

    informed = add(base, effects)
    save_model(informed, folder / "model")
    console.print(f"model with it in {folder / 'model'}")
    write_simulator(base, effects, folder / "simulator", console)
    return informed


def write_simulator(
    base: Equations, effects: Sequence[tuple[str, Mapping[str, float]]], folder: Path, console: Console
) -> bool:
    """The robot with the effects as a simulator, where it has one; whether it was written."""
    from sym2real.errors import ModelError
    from sym2real.plants import save_plant

    plain = plain_simulator(base)
    if plain is None:
        return False
    try:
        description, plant = save_plant(plain.robot, effects, folder)
    except ModelError as error:
        console.print(f"note: no simulator was written: {error}", style="dim", markup=False)
        return False
    console.print(f"simulator with it in {description} and {plant}", markup=False)
    return True


def write_figures(
    base: Equations, informed: Equations | None, data: Dataset, found: Diagnosis | Tried, folder: Path
) -> list[Path]:
    """Figures of the base and the informed model on the logs, with the faults of the data undone."""
    from sym2real.diagnosis.sanity import check
    from sym2real.report.drawing import draw_found

    models = {"base": base} if informed is None else {"base": base, "with what was found": informed}
    return draw_found(models, check(base, data).data, found, folder)
