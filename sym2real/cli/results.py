"""The files that ``diagnose`` and ``add --fit`` leave, and what goes when another diagnosis takes its place."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import Console

from sym2real.cli.output import title_of, write_json
from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis
from sym2real.effects import as_simulated
from sym2real.effects.visible import visible_state
from sym2real.errors import DataError, Sym2RealError
from sym2real.experiments.learning import FROM_LOGS
from sym2real.files import read_by, read_object
from sym2real.plants import MujocoPlant, save_plant
from sym2real.plants.plant_file import PARTS as PLANT_PARTS
from sym2real.report.html.page import Page
from sym2real.robots.own import robot_of
from sym2real.symbolic import Equations
from sym2real.symbolic.storage import PARTS, save_model

ANSWER, PAGE, FILES = "diagnosis.json", "report.html", "files"


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
        console: prints where it is, or why there is none.

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


def write_diagnosis(
    base: Equations, data: Dataset, diagnosis: Diagnosis, out: Path, console: Console
) -> tuple[dict[str, Any], Page | None]:
    """Write the answer, its page and, where something is established, model and simulator; Ctrl-C ends that.

    Args:
        base, data, diagnosis: the model, the logs and what they tell of it.
        out: the folder.
        console: prints where things are.

    Returns:
        What ``diagnosis.json`` holds: the diagnosis and, relative to the folder, the other files. The page, where it
        was made.
    """
    remove_earlier(out)
    written: list[str] = []
    page: Page | None = None
    result = {**diagnosis.to_dict(), FILES: written}
    write_json(result, out / ANSWER)  # what took minutes, before what takes seconds
    try:
        from sym2real.report.html.pages import diagnosis_page
        from sym2real.report.html.render import write_page

        for file in _models(base, diagnosis, out, console):
            written.append(file.relative_to(out).as_posix())
        page = diagnosis_page(base, data, diagnosis, title_of(out, "diagnosed"))
        written.append(write_page(page, out / PAGE).name)
        console.print(f"{ANSWER} and {PAGE} in {out}", markup=False)
    except KeyboardInterrupt:
        console.print(f"interrupted: {ANSWER} is in {out}, not all of the other files", markup=False)
    finally:
        write_json(result, out / ANSWER)
    return result, page


def _models(base: Equations, diagnosis: Diagnosis, out: Path, console: Console) -> Iterator[Path]:
    informed = diagnosis.apply(base) if diagnosis.findings else None
    if informed is not None and diagnosis.established:
        model = save_model(informed, out / "model")
        yield from (model / name for name in PARTS)
        console.print(f"model with it in {model}", markup=False)
        if diagnosis.predicts_better:
            best = save_model(diagnosis.apply(base, for_prediction=True), out / "model_prediction")
            yield from (best / name for name in PARTS)
            console.print(f"model that predicts best in {best}", markup=False)
        yield from write_simulator(informed, out / "simulator", console)
    elif informed is not None:
        few = any(finding.provisional for finding in diagnosis.findings)
        why = "too little data to test it" if few else "what was found is not established"
        console.print(f"{why}: no model or simulator was written; `sym2real add` makes one", markup=False)


def remove_earlier(out: Path) -> None:
    """Remove the files that the diagnosis in a folder says it wrote, and folders then empty; nothing that is read."""
    try:
        names = read_object(out / ANSWER, "an earlier diagnosis").get(FILES, [])
    except DataError:
        return
    for name in names if isinstance(names, list) else []:
        file = out / str(name)
        if file.resolve().is_relative_to(out.resolve()) and file.is_file() and not read_by(file):
            file.unlink()
            if file.parent != out and not any(file.parent.iterdir()):
                file.parent.rmdir()
