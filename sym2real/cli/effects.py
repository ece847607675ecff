"""``sym2real effects``: the catalogue of physical effects, and the page of one."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from sym2real.cli.places import Place
from sym2real.cli.positionals import JsonFile, OptionalName
from sym2real.errors import ModelError


@dataclass(frozen=True)
class Effects:
    """List the physical effects that a robot may have and a model may lack, or print the page of one.

    For example:
      sym2real effects --robot mushr
      sym2real effects wind
    """

    name: OptionalName = None
    """KIND or KIND:COLUMN; the whole catalogue by default."""
    robot: Place | None = None
    """Robot whose effects are listed and whose numbers give units, bounds and scales: its name or a model folder; by
    default the first that has the effect, and the Crazyflie's catalogue."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Print the catalogue or the page."""
        from sym2real.effects import EFFECTS, Body, effect
        from sym2real.effects.body import Describable
        from sym2real.effects.catalogue import keys, unknown_effect
        from sym2real.experiments.models import open_model, robot_called
        from sym2real.neural.model_folder import below
        from sym2real.report.effects import catalogue_table, effect_page
        from sym2real.robots import ROBOTS
        from sym2real.symbolic import Equations

        robots: list[Describable] = [*ROBOTS.values()]
        if self.robot is not None:
            whole = below(open_model(self.robot)) if Path(self.robot).is_dir() else None
            robots = [whole if isinstance(whole, Equations) else robot_called(self.robot)]
        usual = ROBOTS["crazyflie"] if self.robot is None else robots[0]
        if self.name is None:
            kinds = [kind for kind in EFFECTS.values() if kind.fits(Body.of(usual))]
            console.print(catalogue_table(kinds, getattr(usual, "title", str(self.robot))))
            return {"effects": [{"name": kind.name, "stage": kind.stage, "summary": kind.summary} for kind in kinds]}
        name = self.name.removesuffix(":")  # as the catalogue has those that need a column
        if name.partition(":")[0] not in EFFECTS:
            if self.name in ROBOTS or Path(self.name).is_dir():
                wanted = f"sym2real effects --robot {self.name}"
                raise ModelError(f"expected an effect, found {self.name}: `{wanted}` lists what that robot may have")
            raise unknown_effect(self.name, (key for robot in (*robots, *ROBOTS.values()) for key in keys(robot)))
        fitting = ((key, robot) for robot in robots for key in keys(robot) if name in (key, key.partition(":")[0]))
        key, robot = next(fitting, (name, None))
        if robot is None and self.robot is not None:
            raise ModelError(f"{self.robot} has no effect {self.name}")
        chosen = effect(key, robot or usual)
        console.print(effect_page(chosen))
        texts = ("formula", "summary", "confused_with", "shown_by", "fix")
        return {
            "name": chosen.key,
            **{name: getattr(chosen.of, name) for name in texts},
            "parameters": chosen.parameters,
            "group": list(chosen.group),
        }
