"""``sym2real add``: a model with a physical effect in it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tyro
from rich.console import Console


@dataclass(frozen=True)
class Add:
    """Put a physical effect of known size into a model's equations.

    ``sym2real effects NAME`` says what an effect's parameters are. What is not given stays at its null value.

    Example: sym2real add runs/base added_mass value=0.005 --out runs/heavier
    """

    model: tyro.conf.Positional[str]
    """A model folder, or a robot's name (its base is learned once and cached)."""
    effect: tyro.conf.Positional[str]
    """KIND or KIND:COLUMN, as `sym2real effects` lists them."""
    values: tyro.conf.Positional[tuple[str, ...]]
    """PARAMETER=VALUE, in the unit that the catalogue gives."""
    out: Path
    """Folder of the new model."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    def run(self, console: Console) -> dict[str, Any]:
        """Compose, print, write."""
        from sym2real.cli.chosen_effects import number_of, split
        from sym2real.cli.model import open_with_progress
        from sym2real.effects import compose, effect
        from sym2real.report.tables import equation_table
        from sym2real.symbolic import save_model

        equations = open_with_progress(self.model, console)
        chosen = effect(self.effect, equations)
        values = {name: number_of(name, text) for name, text in map(split, self.values)}
        changed = compose(equations, [(chosen, values)])
        save_model(changed, self.out)
        console.print(equation_table(changed))
        for note in changed.notes:
            console.print(f"note: {note}", markup=False)
        console.print(f"{chosen.key}: {chosen.summary}", markup=False)
        console.print(f"model in {self.out}")
        return {"model": self.out, "effect": chosen.key, "values": values, "latex": changed.latex()}
