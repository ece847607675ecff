"""A residual as a file: weights in ``residual.safetensors`` with columns and widths in its header; no pickle."""

from __future__ import annotations

import json
from pathlib import Path

from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from sym2real.errors import DataError
from sym2real.layout import Layout, Layouts
from sym2real.neural.residual_mlp import ResidualMLP

FILE = "residual.safetensors"


def save_residual(residual: ResidualMLP, folder: str | Path) -> Path:
    """Write a residual into a model folder, beside its place and then renamed."""
    target = Path(folder) / FILE
    target.parent.mkdir(parents=True, exist_ok=True)
    state, action = residual.columns
    about = json.dumps({"state": state, "action": action, "widths": residual.widths})
    beside = target.with_name(f".{FILE}.saving")
    save_file({name: tensor.contiguous() for name, tensor in residual.state_dict().items()}, beside, {"about": about})
    beside.replace(target)
    return target


def load_residual(folder: str | Path) -> ResidualMLP:
    """The residual of a model folder.

    Raises:
        DataError: when the file is missing or cannot be read.
    """
    file = Path(folder) / FILE
    try:
        with safe_open(file, framework="pt") as opened:
            about = json.loads((opened.metadata() or {})["about"])
            weights = {name: opened.get_tensor(name) for name in opened.keys()}  # noqa: SIM118 — no mapping
        layouts = Layouts(Layout.of(about["state"]), Layout.of(about["action"]))
        residual = ResidualMLP(layouts, about["widths"])
        residual.load_state_dict(weights)
    except (OSError, SafetensorError, KeyError, TypeError, ValueError, RuntimeError) as error:
        raise DataError(file, "the weights of a residual", str(error)) from error
    return residual
