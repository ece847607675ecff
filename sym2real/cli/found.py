"""What ``diagnose`` and ``add --fit`` share: the plain simulator, and the files that a result leaves."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rich.console import Console

from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, Tried
from sym2real.diagnosis.faults.sanity import check
from sym2real.effects import as_simulated
from sym2real.effects.visible import visible_state
from sym2real.errors import Sym2RealError
from sym2real.experiments.learning import FROM_LOGS
from sym2real.plants import MujocoPlant, save_plant
from sym2real.plants.plant_file import PARTS as PLANT_PARTS
from sym2real.robots.own import robot_of
from sym2real.symbolic import Equations


def plain_simulator(equations: Equations) -> MujocoPlant | None:
    """The simulator that a model was learned from, or that its numbers describe; None for robots that have none.

    None too for a model that was fitted to logs of a real robot: it is not the plain simulator's.
    """
    robot = robot_of(equations)
    if robot is None or FROM_LOGS in equations.notes:
        return None
    same = visible_state(equations) == robot.layouts.state and equations.layouts.action == robot.layouts.action
    return MujocoPlant(robot) if same else None


def write_simulator(informed: Equations, folder: Path, console: Console) -> tuple[Path, ...]:
    """The robot with all effects that the equations have as a simulator, where it has one.

    Args:
        informed: equations that hold the effects.
        folder: of the simulator.
        console: is told where it is, or why there is none.

    Returns:
        The files of the simulator.
    """
    plain = plain_simulator(informed)
    if plain is None:
        return ()
    try:
        description, plant = save_plant(plain.robot, as_simulated(informed), folder)
    except Sym2RealError as error:
        console.print(f"note: no simulator was written: {error}", style="dim", markup=False)
        return ()
    console.print(f"simulator with it in {description} and {plant}", markup=False)
    return tuple(folder / name for name in PLANT_PARTS if (folder / name).exists())


def write_figures(
    base: Equations, informed: Equations | None, data: Dataset, found: Diagnosis | Tried, folder: Path
) -> Iterator[Path]:
    """Figures of the base and the informed model on the logs, the faults of the data undone, one after the other."""
    from sym2real.report.drawing import draw_found

    models = {"base": base} if informed is None else {"base": base, "with what was found": informed}
    yield from draw_found(models, check(base, data).data, found, folder)
