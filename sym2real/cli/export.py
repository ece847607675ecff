"""``sym2real export``: a model as a file for other programs."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

import tyro
from rich.console import Console

from sym2real.cli.positionals import JsonFile, ModelPlace


@dataclass(frozen=True)
class Export:
    """Write a model as a file that other programs open.

    torchscript: torch.jit.load, from Python or C++, without this package. torch-export: a torch.export program (.pt2).
    python: one standalone module that needs torch alone. latex: the equations for a paper. A model with networks goes
    whole into torchscript and torch-export; the other two hold equations only. Beside it OUT.json says how it is
    called, what the columns are, and what of the model acts outside a step: filters, hidden states, sensors.

    Example: sym2real export runs/base python --out model.py
    """

    OUT_IS_FILE: ClassVar[bool] = True

    model: ModelPlace
    format: tyro.conf.Positional[Literal["torchscript", "torch-export", "python", "latex"]]
    """What to write."""
    out: Path
    """The file to write."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Write the file."""
        from sym2real.cli.model import open_with_progress
        from sym2real.neural import export
        from sym2real.neural.model_folder import below
        from sym2real.symbolic import Equations
        from sym2real.symbolic.exporting import interface_of
        from sym2real.symbolic.interface import outside_notes

        model = open_with_progress(self.model)
        export(model, self.format, self.out)
        console.print(f"{self.format} in {self.out}, its columns in {interface_of(self.out)}", markup=False)
        base = below(model)
        outside = outside_notes(base) if isinstance(base, Equations) else ()
        for line in outside:
            console.print(f"note: {line}", markup=False)
        return {"format": self.format, "file": self.out, "interface": interface_of(self.out), "notes": list(outside)}
