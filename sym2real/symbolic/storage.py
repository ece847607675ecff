"""A model as a folder: ``equations.json``, ``parameters.safetensors`` and ``module.pt``; no pickle of ours.

All files are written beside their places and then moved there, so a failure leaves the earlier model as it was. The
weights carry the hash of the equations they belong to: a folder mixed from two models is refused.
"""

import hashlib
import io
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from sym2real.errors import DataError, ModelError, Sym2RealError, reason
from sym2real.files import Kind, read_as, read_text, refuse_pipe, whole
from sym2real.symbolic.compile import compile_model
from sym2real.symbolic.equations import Equations

EQUATIONS, PARAMETERS, MODULE = "equations.json", "parameters.safetensors", "module.pt"
PARTS = (EQUATIONS, PARAMETERS, MODULE)
# Of a model with more than equations (sym2real.neural): what belongs together, what learned, an ensemble as base.
INVENTORY, RESIDUALS, ENSEMBLE = "model.json", ("residual.safetensors", "residual.json"), "ensemble.safetensors"
NEURAL = (INVENTORY, *RESIDUALS, ENSEMBLE)
TRAINING = "training.json"  # what a learned model was learned from, beside it
MOST_PROPOSED = 5  # models that an error names


def save_model(equations: Equations, folder: str | Path) -> Path:
    """Write a model folder; other files that the folder holds are left alone.

    ``module.pt`` opens with ``torch.jit.load`` in a process without this package and offers ``forward`` and
    ``rollout``.

    Raises:
        ModelError: when the equations cannot be compiled; nothing is written then.
        DataError: when there is no writing there.

    Examples:
        >>> sorted(file.name for file in save_model(car(wheelbase=0.3), "bicycle").iterdir())
        ['equations.json', 'module.pt', 'parameters.safetensors']
    """
    folder = Path(folder)
    module = script_file(compile_model(equations))
    write_files(folder, {MODULE: module, **equation_content(equations)})
    remove_all(folder, NEURAL)
    return folder


def equation_content(equations: Equations) -> dict[str, bytes]:
    """Name of every file that makes equations again, with what it holds."""
    source = equations.to_json()
    values = torch.tensor(list(equations.parameters.values()), dtype=torch.float64)
    return {PARAMETERS: save({"parameters": values}, {"equations": _digest(source)}), EQUATIONS: source.encode()}


def script_file(module: torch.jit.ScriptModule) -> bytes:
    """A file for ``torch.jit.load``; torch's own writing to a path ends the process where the disk is full."""
    memory = io.BytesIO()
    torch.jit.save(module, memory)
    return memory.getvalue()


def write_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write every file before the first one takes its place; the last one does so last.

    Raises:
        DataError: when there is no writing there.
    """
    with ExitStack() as stack:
        places = {name: stack.enter_context(whole(folder / name)) for name in reversed([*files])}
        for name, content in files.items():
            places[name].write_bytes(content)


def remove_all(folder: Path, names: Iterable[str]) -> None:
    """Remove files of an earlier model that took no part in the new one.

    Raises:
        DataError: for one that cannot be removed.
    """
    for name in names:
        try:
            (folder / name).unlink(missing_ok=True)
        except OSError as error:
            raise DataError(folder / name, "a file that can be removed", reason(error)) from error


def is_part_of_model(file: str | Path) -> bool:
    """Whether a file is one of those that a saved model consists of."""
    place = Path(file).resolve()
    bases = (place.with_name(name) for name in (EQUATIONS, ENSEMBLE))
    return place.name in (*PARTS, *NEURAL, TRAINING) and any(map(Path.exists, bases))


def load_model(folder: str | Path, *, below: bool = False) -> Equations:
    """The equations of a model folder, with the parameter values that stand beside them.

    Args:
        folder: of the model.
        below: the equations below a residual, too; a model with one is refused else, as they are not the model.

    Raises:
        DataError: when a file is missing or cannot be read.
        ModelError: when the equations cannot be read or the weights belong to others.

    Examples:
        >>> save_model(car(wheelbase=0.3), "bicycle").name
        'bicycle'
        >>> load_model("bicycle").numbers["wheelbase"]
        0.3
    """
    folder = Path(folder)
    if not (folder / EQUATIONS).exists():
        raise _no_model(folder)
    learned = [name for name in (INVENTORY, *RESIDUALS) if (folder / name).exists()]
    if learned and not below:
        raise ModelError(f"{folder} has a residual on its equations ({learned[-1]}): open_model opens the whole")
    source = read_text(folder / EQUATIONS, "the equations of a saved model")
    try:
        equations = Equations.from_json(source)
    except Sym2RealError as error:
        raise ModelError(f"{folder / EQUATIONS}: {error}") from error
    tensors, metadata = read_tensors(folder / PARAMETERS, "the weights of a saved model")
    values = tensors.get("parameters", torch.empty(1, 1))
    if values.shape != (len(equations.parameters),) or metadata.get("equations") != _digest(source):
        raise ModelError(
            f"{folder / PARAMETERS}: expected the parameters of {EQUATIONS} beside it, found those of other equations; "
            "save the model again"
        )
    return replace(equations, parameters=dict(zip(equations.parameters, values.tolist(), strict=True)))


def read_tensors(file: Path, what: str) -> tuple[dict[str, Tensor], dict[str, str]]:
    """The tensors of a file by name, and what its header says.

    Raises:
        DataError: when it cannot be read.
    """
    try:
        refuse_pipe(file)
        with safe_open(file, framework="pt") as opened:
            tensors = {name: opened.get_tensor(name) for name in opened.keys()}  # noqa: SIM118 — no mapping
            return tensors, opened.metadata() or {}
    except (OSError, SafetensorError, UnicodeDecodeError) as error:
        raise DataError(file, what, reason(error)) from error


def training_of(folder: str | Path, kind: type[Kind]) -> Kind:
    """What a learned model was learned from, in a class of what is asked for; its defaults where the folder is silent.

    Raises:
        DataError: when it cannot be read.
    """
    file = Path(folder) / TRAINING
    return read_as(file, kind, "what a model was learned from") if file.exists() else kind()


@dataclass(frozen=True)
class _Rows:
    """What ``training.json`` says of the rows."""

    region: dict[str, tuple[float, float]] = field(default_factory=dict)


def training_region(folder: Path) -> dict[str, tuple[float, float]] | None:
    """Range of every column in the training rows of a model folder; None where it does not say.

    Raises:
        DataError: when ``training.json`` cannot be read.
    """
    return training_of(folder, _Rows).region or None


def _no_model(folder: Path) -> DataError:
    """The error for a folder without equations; it proposes the models that lie in it or one folder deeper."""
    inside = sorted(file.parent for depth in ("*", "*/*") for file in folder.glob(f"{depth}/{EQUATIONS}"))
    models = [str(path) for path in inside if not path.name.startswith(".")][:MOST_PROPOSED]
    actual = "none in it" if folder.is_dir() else "a file" if folder.exists() else "no such folder"
    hint = f"; did you mean {' or '.join(models)}?" if models else ""
    return DataError(folder, f"a model folder, which holds {EQUATIONS}", actual + hint)


def _digest(source: str) -> str:
    return hashlib.sha256(source.encode()).hexdigest()
