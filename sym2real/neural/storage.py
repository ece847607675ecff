"""Weights as files: safetensors with what they belong to in the header; expressions as JSON.

No pickle: a model from elsewhere runs no code.
"""

import json
from pathlib import Path
from typing import Any, TypeVar

from safetensors.torch import save

from sym2real.errors import DataError, Sym2RealError, reason
from sym2real.field import read_fields
from sym2real.files import read_object
from sym2real.layout import Layout, Layouts
from sym2real.neural.ensemble import Ensemble
from sym2real.neural.residual_mlp import ResidualMLP
from sym2real.neural.symbolic_residual import SymbolicResidual
from sym2real.symbolic import parse_expression, text
from sym2real.symbolic.storage import read_tensors

Network = TypeVar("Network", ResidualMLP, Ensemble)
FILE = "residual.safetensors"
BROKEN = (AttributeError, KeyError, TypeError, ValueError, RuntimeError, Sym2RealError)


def network_file(network: ResidualMLP | Ensemble) -> bytes:
    """The weights of a network, with what makes it again in the header."""
    weights = {name: tensor.contiguous() for name, tensor in network.state_dict().items()}
    columns: dict[str, Any] = _columns(network.columns)
    if isinstance(network, Ensemble):  # it puts its states back on the manifold that their fields say
        columns = {group: fields for group, fields in network.layouts.to_dict().items() if group in columns}
    content: bytes = save(weights, {"about": json.dumps({**columns, **network.about()})})
    return content


def load_residual(folder: str | Path) -> ResidualMLP:
    """The residual of a folder.

    Raises:
        DataError: when the file is missing or cannot be read.
    """
    return _network(Path(folder) / FILE, ResidualMLP, "the weights of a residual")


def load_ensemble(file: Path) -> Ensemble:
    """The ensemble of a file.

    Raises:
        DataError: when it is missing or cannot be read.
    """
    return _network(file, Ensemble, "the weights of an ensemble")


def _network(file: Path, kind: type[Network], what: str) -> Network:
    weights, header = read_tensors(file, what)
    try:
        about = json.loads(header["about"])
        layouts = _layouts({group: about.pop(group) for group in ("state", "action")})
        network = kind(layouts, **about)
        network.load_state_dict(weights)
    except BROKEN as error:
        raise DataError(file, what, reason(error)) from error
    return network


def expressions_file(residual: SymbolicResidual) -> bytes:
    """The expressions of a residual."""
    about = {**_columns(residual.columns), "residual": {c: text(e) for c, e in residual.expressions.items()}}
    return (json.dumps(about, indent=1) + "\n").encode()


def load_symbolic(file: Path) -> SymbolicResidual:
    """The residual of a file, whose text need not be trusted.

    Raises:
        DataError: when it is missing or cannot be read.
    """
    what = "the expressions of a residual"
    about = read_object(file, what)
    try:
        written = {column: parse_expression(str(source)) for column, source in about["residual"].items()}
        return SymbolicResidual(_layouts(about), written)
    except BROKEN as error:
        raise DataError(file, what, reason(error)) from error


def _columns(columns: tuple[tuple[str, ...], tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
    return dict(zip(("state", "action"), columns, strict=True))


def _layouts(about: dict[str, Any]) -> Layouts:
    return Layouts(_layout(about["state"]), _layout(about["action"]))


def _layout(columns: list[Any]) -> Layout:
    """Of fields, or of names alone, which the vocabulary knows."""
    return Layout(read_fields(columns)) if columns and isinstance(columns[0], dict) else Layout.of(columns)
