"""A model with networks as a file for other programs, whole: base and residual."""

from pathlib import Path
from typing import Any

import torch
from torch.export import Dim

from sym2real.errors import ModelError
from sym2real.neural.composed import Composed
from sym2real.neural.ensemble import Ensemble
from sym2real.neural.model_folder import Model, as_composed
from sym2real.symbolic import Equations, export as export_equations
from sym2real.symbolic.exporting import called, program_file, write_export
from sym2real.symbolic.interface import columns_of, interface
from sym2real.symbolic.storage import script_file


def export(model: Model, format: str, path: str | Path) -> Path:
    """Write a model in a format of :data:`sym2real.symbolic.EXPORTS`; the file appears whole or not at all.

    Raises:
        UnknownNameError: when there is no such format.
        ModelError: when the model cannot be compiled, or the format has no place for networks.
        DataError: when there is no writing there.
    """
    if isinstance(model, Equations):
        return export_equations(model, format, path)
    if format not in ("torchscript", "torch-export"):
        raise ModelError(f"{format} holds equations; a model with networks is exported as torchscript or torch-export")
    composed = as_composed(model)
    content = script_file(composed.scripted) if format == "torchscript" else program_file(_program(composed))
    arguments = ", ".join(f"{name}={name}" for name in _sizes(composed))
    return write_export(Path(path), content, {**called(format, arguments), **_interface(composed)})


def _interface(model: Composed) -> dict[str, Any]:
    """Columns, and what acts outside a step; the past that the model sees, newest first, by its lengths."""
    below = model.below
    about = interface(below) if isinstance(below, Equations) else {"dt": below.dt, **columns_of(below.layouts)}
    return {**about, "past": dict(zip(("commands", "states"), model.past_rows, strict=True))}


def _program(model: Composed) -> torch.export.ExportedProgram:
    """One step with a dynamic batch dimension, in float32."""
    given = {name: torch.ones(4, size) for name, size in _sizes(model).items()}
    batch = Dim("batch", min=2)
    return torch.export.export(model.plain(), (), given, dynamic_shapes={name: {0: batch} for name in given})


def _sizes(model: Composed) -> dict[str, int]:
    """Arguments of the model that have columns, and their number."""
    below, (commands, states) = model.below, model.past_rows
    hidden = 0 if isinstance(below, Ensemble) else len(below.layouts.state) - len(model.layouts.state)
    layouts = model.layouts
    sizes = {
        "state": len(layouts.state) + hidden,
        "action": len(layouts.action),
        "inputs": len(layouts.inputs),
        "past": commands * len(layouts.action) + states * len(layouts.state),
    }
    return {name: size for name, size in sizes.items() if size}
