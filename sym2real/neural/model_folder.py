"""A model as a folder, whatever it is made of: equations, an ensemble, or one of them with a residual on top.

Beside the files of equations (:mod:`sym2real.symbolic.storage`) stand ``ensemble.safetensors``,
``residual.safetensors`` or ``residual.json``, and ``model.json``, which names all files with their digests: a folder
that is mixed from two models is refused. ``module.pt`` is the whole, for programs without this package. No pickle.
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from sym2real.errors import DataError, ModelError, reason
from sym2real.files import read_object
from sym2real.neural.composed import Base, Composed
from sym2real.neural.ensemble import Ensemble
from sym2real.neural.residual_mlp import ResidualMLP
from sym2real.neural.storage import expressions_file, load_ensemble, load_residual, load_symbolic, network_file
from sym2real.neural.symbolic_residual import SymbolicResidual
from sym2real.symbolic import Equations, load_model, save_model as save_equations
from sym2real.symbolic.storage import (
    ENSEMBLE,
    EQUATIONS,
    INVENTORY,
    MODULE,
    NEURAL,
    PARAMETERS,
    RESIDUALS,
    equation_content,
    remove_all,
    script_file,
    write_files,
)

Model = Equations | Composed | Ensemble
NETWORK, EXPRESSIONS = RESIDUALS
WHAT = "the parts of a model with their digests"


def holds_model(folder: Path) -> bool:
    """Whether a folder is that of a model, of equations or of networks."""
    return any((folder / name).exists() for name in (EQUATIONS, INVENTORY, ENSEMBLE))


def below(model: Model) -> Base:
    """What lies below a model's residual; the model where it has none."""
    return model.below if isinstance(model, Composed) else model


def save_model(model: Model, folder: str | Path) -> Path:
    """Write a model folder; other files that the folder holds are left alone.

    Raises:
        ModelError: when the model cannot be compiled; nothing is written then.
        DataError: when there is no writing there.
    """
    folder = Path(folder)
    if isinstance(model, Equations):
        return save_equations(model, folder)
    files = {MODULE: script_file(as_composed(model).scripted), **content_of(model)}
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    listed = json.dumps({"files": digests}, indent=1) + "\n"
    write_files(folder, {**files, INVENTORY: listed.encode()})
    remove_all(folder, ({EQUATIONS, PARAMETERS, *NEURAL} - {INVENTORY}) - files.keys())
    return folder


def as_composed(model: Composed | Ensemble) -> Composed:
    """A model with rollouts for other programs: an ensemble alone has a residual of zero."""
    return model if isinstance(model, Composed) else Composed(model, SymbolicResidual(model.layouts, {}))


def content_of(model: Model) -> dict[str, bytes]:
    """Files of a model's folder that make it again: all but ``module.pt``, which follows from them."""
    base = below(model)
    files = equation_content(base) if isinstance(base, Equations) else {ENSEMBLE: network_file(base)}
    if not isinstance(model, Composed):
        return files
    if isinstance(model.residual, ResidualMLP):
        return files | {NETWORK: network_file(model.residual)}
    return files | {EXPRESSIONS: expressions_file(model.residual)}


def open_model(folder: str | Path) -> Model:
    """The model of a folder, whole: equations, or a module that has networks, as ``adapt`` writes it.

    A module predicts tensors of float32, ``model(state, action)``, with ``past`` where it sees that. :class:`MPPI`
    takes it as it is (equations through :func:`compile_model`), :func:`compare` takes both.

    Raises:
        DataError: when a file is missing or cannot be read.
        ModelError: when the files do not belong together.

    Examples:
        >>> folder = save_model(car(wheelbase=0.3), "bicycle")
        >>> open_model(folder).layouts.action.columns
        ('steer', 'speed')
    """
    folder = Path(folder)
    if not (folder / INVENTORY).exists():
        alone = [name for name in NEURAL if (folder / name).exists()]
        if alone:
            raise ModelError(f"{folder / alone[0]}: no {INVENTORY} beside it says which model it belongs to")
        return load_model(folder)
    listed = read_object(folder / INVENTORY, WHAT).get("files")
    if not isinstance(listed, dict):
        raise DataError(folder / INVENTORY, WHAT, repr(listed))
    _require_parts(folder, listed)
    base: Base = load_ensemble(folder / ENSEMBLE) if ENSEMBLE in listed else load_model(folder, below=True)
    if NETWORK in listed:
        return Composed(base, load_residual(folder))
    if EXPRESSIONS in listed:
        return Composed(base, load_symbolic(folder / EXPRESSIONS))
    return base


def _require_parts(folder: Path, listed: Mapping[str, object]) -> None:
    for name, digest in listed.items():
        if name not in (EQUATIONS, PARAMETERS, MODULE, *NEURAL):
            raise DataError(folder / INVENTORY, "names of a model's files", repr(name))
        if _digest(folder / name) != digest:
            raise ModelError(f"{folder / name} is not the file that {INVENTORY} beside it names; save the model again")


def _digest(file: Path) -> str:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise DataError(file, "a file of a saved model", reason(error)) from error
