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

    Effects = Sequence[tuple[str, Mapping[str, float]]]


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


def write_model_and_simulator(informed: Equations, effects: Effects, folder: Path, console: Console) -> None:
    """The informed model into ``folder/model``, the robot with the effects into ``folder/simulator``."""
    from sym2real.effects import with_noted
    from sym2real.symbolic import save_model

    save_model(with_noted(informed, effects), folder / "model")
    console.print(f"model with it in {folder / 'model'}", markup=False)
    write_simulator(informed, effects, folder / "simulator", console)


def write_simulator(informed: Equations, effects: Effects, folder: Path, console: Console) -> None:
    """The robot with the effects as a simulator, where it has one.

    Args:
        informed: equations that hold the effects; their inputs say what the values refer to.
        effects: keys and values.
        folder: of the simulator.
        console: is told where it is, or why there is none.
    """
    from sym2real.effects.voltage import VOLTAGE
    from sym2real.errors import ModelError
    from sym2real.plants import save_plant

    plain = plain_simulator(informed)
    if plain is None:
        return
    try:
        if VOLTAGE in informed.layouts.inputs and any(key == "battery_sag" for key, _ in effects):
            raise ModelError("its battery has no voltage that the thrust could sag with")
        description, plant = save_plant(plain.robot, effects, folder)
    except ModelError as error:
        console.print(f"note: no simulator was written: {error}", style="dim", markup=False)
        return
    console.print(f"simulator with it in {description} and {plant}", markup=False)


def write_figures(
    base: Equations, informed: Equations | None, data: Dataset, found: Diagnosis | Tried, folder: Path
) -> list[Path]:
    """Figures of the base and the informed model on the logs, with the faults of the data undone."""
    from sym2real.diagnosis.sanity import check
    from sym2real.report.drawing import draw_found

    models = {"base": base} if informed is None else {"base": base, "with what was found": informed}
    return draw_found(models, check(base, data).data, found, folder)
