"""``sym2real show``: a model's equations, for people."""

from dataclasses import dataclass
from typing import Any

from rich.console import Console

from sym2real.cli.positionals import JsonFile, ModelPlace


@dataclass(frozen=True)
class Show:
    """Print what was learned on top of a model, the effects put into it, its equations, and what actions reach.

    Example: sym2real show runs/base --latex
    """

    model: ModelPlace
    latex: bool = False
    """Print LaTeX too."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Print the tables."""
        from sym2real.cli.model import folder_of, open_with_progress
        from sym2real.effects import noted
        from sym2real.experiments.learning import trained_dependence
        from sym2real.neural.describing import described
        from sym2real.neural.model_folder import below
        from sym2real.report.tables import dependence_table, equation_table, readable
        from sym2real.symbolic import Equations

        model = open_with_progress(self.model)
        base = below(model)
        learned = described(model)
        for line in learned.values():
            console.print(line, markup=False)
        if not isinstance(base, Equations):
            return {"dt": base.dt, "learned": learned}
        dependence = trained_dependence(folder_of(self.model))
        effects = noted(base)
        console.print(f"physical effects put into it: {'; '.join(effects) or 'none that it notes'}", markup=False)
        for key, values in base.filters:
            given = ", ".join(f"{name} = {readable(value)}" for name, value in values.items())
            console.print(f"{key} acts on whole series, outside the equations: {given}", markup=False)
        console.print(equation_table(base))
        if dependence:
            console.print(dependence_table(dependence))
        for note in base.notes:
            console.print(f"note: {note}", markup=False)
        latex = base.latex()
        if self.latex:
            for name, text in latex.items():
                console.print(f"{name} = {text}", soft_wrap=True, markup=False)
        return {
            "dt": base.dt,
            "effects": list(effects),
            "equations": base.text().splitlines(),
            "latex": latex,
            "nodes": base.complexity(),
            "dependence": dependence,
            "notes": list(base.notes),
            "learned": learned,
        }
