"""A residual as a file: weights in ``residual.safetensors``, columns, widths and length of the past in its header.

No pickle: a model from elsewhere runs no code.
"""

from __future__ import annotations

import json
from pathlib import Path

from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from sym2real.errors import DataError, reason
from sym2real.files import whole
from sym2real.layout import Layout, Layouts
from sym2real.neural.residual_mlp import ResidualMLP

FILE = "residual.safetensors"


def save_residual(residual: ResidualMLP, folder: str | Path) -> Path:
    """Write a residual into a model folder, whole or not at all.

    Raises:
        DataError: when there is no writing there.
    """
    target = Path(folder) / FILE
    state, action = residual.columns
    past = {"commands": residual.commands, "states": residual.states}
    about = json.dumps({"state": state, "action": action, "widths": residual.widths, **past})
    weights = {name: tensor.contiguous() for name, tensor in residual.state_dict().items()}
    with whole(target) as beside:
        save_file(weights, beside, {"about": about})
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
        past = {"commands": about.get("commands", 0), "states": about.get("states", 0)}
        residual = ResidualMLP(layouts, about["widths"], **past)
        residual.load_state_dict(weights)
    except (OSError, SafetensorError, KeyError, TypeError, ValueError, RuntimeError) as error:
        raise DataError(file, "the weights of a residual", reason(error)) from error
    return residual
