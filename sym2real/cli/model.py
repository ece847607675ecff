"""What verbs share: opening a model with progress, and logs with the columns that the model needs."""

from collections.abc import Sequence
from hashlib import sha256
from math import inf
from pathlib import Path

from rich.console import Console

from sym2real.cli.progress import stage_one_progress
from sym2real.dataset import Dataset
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.data.start import ROWS
from sym2real.errors import DataError, ModelError
from sym2real.experiments.models import base_folder, open_model
from sym2real.layout import Layouts
from sym2real.logs import LogSpec
from sym2real.logs.dropouts import is_unasked
from sym2real.logs.grouping import visible
from sym2real.logs.reader import logs_of, read_each
from sym2real.logs.several_files import LogFiles
from sym2real.neural import Model
from sym2real.neural.composed import Base
from sym2real.neural.model_folder import below
from sym2real.robots import ROBOTS
from sym2real.robots.own import robot_of
from sym2real.symbolic import Equations
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import LARGEST_PLACE


def open_with_progress(name: str) -> Model:
    """The model of that name, whole; a robot's base is learned under a progress bar when it is not cached yet."""
    with stage_one_progress() as on_progress:
        return open_model(name, on_progress)


def equations_below(name: str, console: Console) -> tuple[Equations, tuple[str, ...]]:
    """The equations of the model of that name without what was learned on top, and what to say of it.

    Raises:
        ModelError: when networks alone make the model.
    """
    model = open_with_progress(name)
    equations = below(model)
    if not isinstance(equations, Equations):
        raise ModelError(f"{name}: expected a model of equations, found an ensemble of networks")
    if model is equations:
        return equations, ()
    note = f"{name} has a learned residual on its equations; this is about the equations below, without it"
    console.print(f"note: {note}", style="yellow", markup=False)
    return equations, (note,)


def columns_of(model: str) -> tuple[Layouts, dict[str, str], tuple[str, ...]]:
    """Columns that logs of a model hold, a folder or a robot's name; where known joints that actions move, and those
    that may go further than any sensor's unit tells.

    Raises:
        UnknownNameError: when it is neither.
        ModelError, DataError: for a folder without a model that can be opened.
    """
    base = None if model in ROBOTS and not Path(model).is_dir() else below(open_model(model))
    robot = ROBOTS[model] if base is None else robot_of(base)
    layouts = visible(ROBOTS[model].layouts if base is None else base.layouts)
    if robot is None:
        return layouts, {}, ()
    units, joints = layouts.state.units, layouts.state.joints
    ends = robot.ranges if joints else {}
    most = {joint: max(map(abs, ends[joint])) if joint in ends else inf for joint in joints}
    return layouts, robot.moved, tuple(joint for joint in joints if most[joint] > LARGEST_PLACE[units[joint]])


def folder_of(name: str) -> Path:
    """The folder of the model of that name; a robot's is in the cache."""
    return Path(name) if Path(name).is_dir() or name not in ROBOTS else base_folder(ROBOTS[name])


def require_another_folder(model: str, out: Path) -> None:
    """Refuse to write a model over the one that it is made from.

    Args:
        model: as the user names it, a folder or a robot.
        out: folder that the new model is to go to.

    Raises:
        ModelError: when it is the model's own folder, whichever way the two are written.
    """
    own = folder_of(model)
    if out.resolve() == own.resolve():
        raise ModelError(f"--out: the new model would replace {own}, which it is made from; name another folder")


def logs_for(
    base: Base,
    paths: Sequence[Path],
    spec: LogSpec | None,
    *,
    apart_from: Sequence[Path] = (),
    upsample: bool = False,
) -> Dataset:
    """Logs read with the columns and the time step of a model; hidden states are in no log.

    Args:
        base: the model, or what lies below its residual.
        paths: of the logs.
        spec: how their columns are named.
        apart_from: logs that are to be judged by these, so that none may be among them.
        upsample: whether slower logs get the model's step too, as a residual that was trained at it needs them.

    Raises:
        DataError: for a file that cannot be read as such, in which no stretch is long enough to predict anything, or
            that is given twice.
    """
    log_files = logs_of(paths, spec)
    _require_different([*(logs_of(apart_from, spec) if apart_from else []), *log_files])
    logs, read = list[Trajectory](), read_each(log_files, spec, base.layouts, base.dt, upsample=upsample)
    for files, pieces in zip(log_files, read, strict=True):
        longest = max(len(piece) for piece in pieces)
        if longest <= ROWS:
            lost = dict.fromkeys(note for piece in pieces for note in piece.notes if is_unasked(note))
            raise DataError(files[0], f"more than {ROWS} rows without a gap", "; ".join((f"{longest}", *lost)))
        logs += pieces
    return long_enough(Dataset(logs))


def _digest(log: LogFiles) -> bytes:
    """Of the content of a log's files; a ROS 2 bag is a folder."""
    inside = [file for path in log for file in (sorted(path.iterdir()) if path.is_dir() else [path])]
    return sha256(b"".join(file.read_bytes() for file in inside if file.is_file())).digest()


def _require_different(logs: Sequence[LogFiles]) -> None:
    """A log that counts twice makes a diagnosis surer than it may be, and one that scores its own fit says nothing."""
    seen: dict[bytes, LogFiles] = {}
    for log in logs:
        other = seen.setdefault(_digest(log), log)
        if other is not log:
            wanted = "every log once, and held-out logs that took no part in a fit"
            raise DataError(log[0], wanted, f"{other[0]} again")
