"""``sym2real show``: a model's equations, for people."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import tyro
from rich.console import Console

from sym2real.cli.places import Place


@dataclass(frozen=True)
class Show:
    """Print the effects that were put into a model, its equations, and how strongly each action reaches its states.

    Example: sym2real show runs/base --latex
    """

    model: tyro.conf.Positional[Place]
    """A model folder, or a robot's name (its base is learned once and cached)."""
    latex: bool = False
    """Print LaTeX too."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    def run(self, console: Console) -> dict[str, Any]:
        """Print the tables."""
        from sym2real.cli.model import folder_of, open_with_progress
        from sym2real.effects import noted
        from sym2real.experiments.learning import trained_dependence
        from sym2real.report.tables import dependence_table, equation_table, readable

        equations = open_with_progress(self.model)
        dependence = trained_dependence(folder_of(self.model))
        effects = noted(equations)
        console.print(f"physical effects put into it: {'; '.join(effects) or 'none that it notes'}", markup=False)
        for key, values in equations.filters:
            given = ", ".join(f"{name} = {readable(value)}" for name, value in values.items())
            console.print(f"{key} acts on whole series, outside the equations: {given}", markup=False)
        console.print(equation_table(equations))
        if dependence:
            console.print(dependence_table(dependence))
        for note in equations.notes:
            console.print(f"note: {note}", markup=False)
        latex = equations.latex()
        if self.latex:
            for name, text in latex.items():
                console.print(f"{name} = {text}", soft_wrap=True, markup=False)
        return {
            "dt": equations.dt,
            "effects": list(effects),
            "equations": equations.text().splitlines(),
            "latex": latex,
            "nodes": equations.complexity(),
            "dependence": [asdict(row) for row in dependence],
            "notes": list(equations.notes),
        }
