"""What ``adapt`` is given as TARGET: a robot's simulator, the folder of one, or a folder of logs."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from sym2real.adaptation.target import MakeController
from sym2real.cli.chosen import chosen_task
from sym2real.cli.model import logs_for
from sym2real.dataset import Dataset
from sym2real.errors import ModelError, UnknownNameError
from sym2real.experiments.models import target_called
from sym2real.experiments.noisy_runs import NoisyPlant
from sym2real.logs import LogSpec
from sym2real.logs.reader import logs_of
from sym2real.neural.composed import Base
from sym2real.neural.model_folder import holds_model
from sym2real.plants.plant_file import PLANT
from sym2real.protocols import Plant
from sym2real.robots import ROBOTS, Robot
from sym2real.robots.own import robot_of
from sym2real.symbolic import Equations
from sym2real.tasks import Task


@dataclass(frozen=True, eq=False)
class Chosen:
    """A target, ready for :func:`sym2real.adaptation.loop.adapt`.

    Args:
        target: a plant, or recordings.
        task: what is flown; None with recordings.
        robot: None where the model names none that is known.
        controller: makes what flies a model; MPPI by default.
    """

    target: Plant | tuple[Dataset, ...]
    task: Task | None
    robot: Robot | None
    controller: MakeController | None = None


def chosen_target(
    base: Base, model: str, target: str, task: Sequence[str], *, spec: LogSpec | None, noise: bool
) -> Chosen:
    """What a user means by TARGET and TASK.

    Args:
        base: the model's equations or networks.
        model: as the user names it, for errors.
        target: a robot's name, the folder of a simulator, of a model for the plain robot that it is of, or of logs.
        task: to be flown, with its options behind it; nothing with logs.
        spec: how the logs' columns are named.
        noise: put sensor noise into the simulator.

    Raises:
        UnknownNameError: for a target or a task that does not exist.
        ModelError: for the plant of another robot, without a task to fly, or with an option that does not fit.
        DataError: for a log that cannot be read as one of this model's.
    """
    folder = Path(target)
    if not folder.exists() and target not in ROBOTS:
        raise UnknownNameError("target: neither a folder nor a robot", target, ROBOTS)
    simulated = holds_model(folder) or any((part / PLANT).exists() for part in (folder, folder / "simulator"))
    if folder.is_dir() and not simulated:
        for given, option in ((" ".join(task), "TASK"), (noise, "--noise")):
            if given:
                raise ModelError(f"{option}: nothing flies with the logs of {target}, found {given}")
        return _recordings(base, folder, spec)
    if spec is not None:
        raise ModelError(f"--spec is for logs; {target} is a simulator")
    if not task:
        raise ModelError(f"TASK: expected what to fly in {target}, such as circle, found nothing")
    robot = robot_of(base)
    if robot is None:
        raise ModelError(
            f"{model} names no registered robot ({', '.join(ROBOTS)}), so it cannot fly in {target}; "
            "give a folder of logs to adapt it to them"
        )
    plant = target_called(target, robot)
    return Chosen(NoisyPlant(plant) if noise else plant, chosen_task(task[0], task[1:], robot), robot)


def _recordings(base: Base, folder: Path, spec: LogSpec | None) -> Chosen:
    """Logs in the order of their names, one a round."""
    if not isinstance(base, Equations):
        raise ModelError(f"logs have the time step of equations; expected a model of some for {folder}, found networks")
    log_files = logs_of(folder, spec)
    logs_for(base, [folder], spec)  # no log may be there twice
    logs = tuple(logs_for(base, files, spec, upsample=True) for files in log_files)
    return Chosen(logs, None, robot_of(base))
