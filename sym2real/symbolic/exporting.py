"""Equations as files for other programs."""

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from torch.export import Dim, ExportedProgram

from sym2real.errors import ModelError
from sym2real.files import whole
from sym2real.registry import Registry
from sym2real.symbolic.compile import build_module, compile_model
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.interface import interface
from sym2real.symbolic.printing import latex_lines
from sym2real.symbolic.source import model_source
from sym2real.symbolic.storage import is_part_of_model, script_file


def exported_program(equations: Equations) -> ExportedProgram:
    """``torch.export`` program of one step with a dynamic batch dimension, in float32.

    Its arguments are state ``# (N, n)``, action ``# (N, m)`` and, where the equations have inputs, inputs ``# (N, k)``.
    """
    layouts = equations.layouts
    module = build_module(equations).to(torch.float32)
    sizes = [size for size in (len(layouts.state), len(layouts.action), len(layouts.inputs)) if size]
    batch = Dim("batch", min=2)
    examples = tuple(torch.ones(4, size) for size in sizes)
    names = ("state", "action", "inputs")[: len(sizes)]
    return torch.export.export(module, examples, dynamic_shapes={name: {0: batch} for name in names})


def latex_document(equations: Equations) -> str:
    """LaTeX ``align`` lines: quantities, next state columns with a prime, and what is measured where that differs."""
    return "\\begin{align}\n" + " \\\\\n".join(latex_lines(equations)) + "\n\\end{align}\n"


def program_file(program: ExportedProgram) -> bytes:
    """A file for ``torch.export.load``."""
    memory = io.BytesIO()  # as of script_file
    torch.export.save(program, memory)
    return memory.getvalue()


EXPORTS: Registry[Callable[[Equations], bytes]] = Registry(
    "export format",
    {
        "torchscript": lambda equations: script_file(compile_model(equations)),
        "torch-export": lambda equations: program_file(exported_program(equations)),
        "python": lambda equations: model_source(equations).encode(),
        "latex": lambda equations: latex_document(equations).encode(),
    },
)


def export(equations: Equations, format: str, path: str | Path) -> Path:
    """Write the model in a format of :data:`EXPORTS`, and its columns, filters and starts beside it as JSON.

    Both files appear whole or not at all; the second has ``.json`` behind the first one's name.

    Raises:
        UnknownNameError: when there is no such format.
        ModelError: when the equations cannot be compiled, or a file of a saved model would be written over.
        DataError: when there is no writing there.
    """
    arguments = ", ".join(name for name, layout in equations.layouts.groups.items() if len(layout))
    return write_export(Path(path), EXPORTS[format](equations), {**called(format, arguments), **interface(equations)})


def called(format: str, arguments: str) -> dict[str, str]:
    """How a file of a format is opened and called, for its interface; nothing of one that is read."""
    known = {
        "python": f"Dynamics()({arguments}) of the module: tensors of float32 (N, columns)",
        "torchscript": f"torch.jit.load(FILE)({arguments}): tensors of float32 (N, columns)",
        "torch-export": f"torch.export.load(FILE).module()({arguments}): tensors of float32 (N, columns), N at least 2",
    }
    return {"call": known[format]} if format in known else {}


def write_export(path: Path, content: bytes, about: dict[str, Any]) -> Path:
    """Write a model and beside it its interface, which must not replace a part of one; errors as of :func:`export`."""
    place = interface_of(path)
    if is_part_of_model(place):
        raise ModelError(f"{place} would be written beside {path} and is part of a model; name another file")
    with whole(path) as beside, whole(place) as described:
        beside.write_bytes(content)
        described.write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")
    return path


def interface_of(path: Path) -> Path:
    """Where the columns, filters and starts of an exported model stand."""
    return path.with_name(f"{path.name}.json")
