"""Weights as files: safetensors with what they belong to in the header; expressions as JSON.

No pickle: a model from elsewhere runs no code.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor, nn

from sym2real.errors import DataError, Sym2RealError, reason
from sym2real.files import read_object, refuse_pipe
from sym2real.layout import Layout, Layouts
from sym2real.neural.ensemble import Ensemble
from sym2real.neural.residual_mlp import ResidualMLP
from sym2real.neural.symbolic_residual import SymbolicResidual
from sym2real.symbolic import parse_expression, text

FILE = "residual.safetensors"
BROKEN = (OSError, SafetensorError, AttributeError, KeyError, TypeError, ValueError, RuntimeError, Sym2RealError)


def write_residual(residual: ResidualMLP, path: Path) -> None:
    """Write the weights of a residual."""
    past = {"commands": residual.commands, "states": residual.states}
    _write(residual, path, {**_columns(residual.columns), "widths": residual.widths, **past})


def load_residual(folder: str | Path) -> ResidualMLP:
    """The residual of a folder.

    Raises:
        DataError: when the file is missing or cannot be read.
    """
    file = Path(folder) / FILE
    try:
        about, weights = _read(file)
        past = {"commands": about.get("commands", 0), "states": about.get("states", 0)}
        residual = ResidualMLP(_layouts(about), about["widths"], **past)
        residual.load_state_dict(weights)
    except BROKEN as error:
        raise DataError(file, "the weights of a residual", reason(error)) from error
    return residual


def write_ensemble(ensemble: Ensemble, path: Path) -> None:
    """Write the weights of an ensemble."""
    sizes = {"members": ensemble.networks.count, "widths": ensemble.widths, "probabilistic": ensemble.probabilistic}
    _write(ensemble, path, {**_columns(ensemble.columns), **sizes, "dt": ensemble.dt, "robot": ensemble.robot})


def load_ensemble(file: Path) -> Ensemble:
    """The ensemble of a file.

    Raises:
        DataError: when it is missing or cannot be read.
    """
    try:
        about, weights = _read(file)
        ensemble = Ensemble(
            _layouts(about),
            about["members"],
            about["widths"],
            probabilistic=about["probabilistic"],
            dt=float(about["dt"]),
            robot=str(about["robot"]),
        )
        ensemble.load_state_dict(weights)
    except BROKEN as error:
        raise DataError(file, "the weights of an ensemble", reason(error)) from error
    return ensemble


def write_symbolic(residual: SymbolicResidual, path: Path) -> None:
    """Write the expressions of a residual."""
    about = {**_columns(residual.columns), "residual": {c: text(e) for c, e in residual.expressions.items()}}
    path.write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")


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
    return Layouts(Layout.of(about["state"]), Layout.of(about["action"]))


def _write(module: nn.Module, path: Path, about: dict[str, Any]) -> None:
    weights = {name: tensor.contiguous() for name, tensor in module.state_dict().items()}
    path.write_bytes(save(weights, {"about": json.dumps(about)}))


def _read(file: Path) -> tuple[dict[str, Any], dict[str, Tensor]]:
    refuse_pipe(file)
    with safe_open(file, framework="pt") as opened:
        about = json.loads((opened.metadata() or {})["about"])
        return about, {name: opened.get_tensor(name) for name in opened.keys()}  # noqa: SIM118 — no mapping
