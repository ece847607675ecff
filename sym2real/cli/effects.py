"""``sym2real effects``: the catalogue of physical effects, and the page of one."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from rich.console import Console

from sym2real.cli.places import Place
from sym2real.cli.positionals import JsonFile, OptionalName
from sym2real.errors import ModelError

if TYPE_CHECKING:
    from sym2real.robots import Robot


@dataclass(frozen=True)
class Effects:
    """List the physical effects that a robot may have and a model may lack, or print the page of one.

    For example:
      sym2real effects --robot mushr
      sym2real effects wind
    """

    name: OptionalName = None
    """KIND or KIND:COLUMN; the whole catalogue by default."""
    robot: Place = "crazyflie"
    """Robot whose effects are listed and whose numbers give units, bounds and scales: its name or a model folder."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Print the catalogue or the page."""
        from sym2real.effects import EFFECTS, Body, effect
        from sym2real.effects.catalogue import columns_of
        from sym2real.experiments.models import robot_called
        from sym2real.report.effects import catalogue_table, effect_page

        robot = robot_called(self.robot)
        if self.name is None:
            kinds = [kind for kind in EFFECTS.values() if kind.fits(Body.of(robot))]
            console.print(catalogue_table(kinds, robot.title))
            return {"effects": [{"name": kind.name, "stage": kind.stage, "summary": kind.summary} for kind in kinds]}
        name = self.name
        self._require_robot(name, robot)
        kind = EFFECTS[name.partition(":")[0]]
        if ":" not in name and kind.columns and kind.column_needed:
            name = f"{name}:{columns_of(kind, robot)[0]}"
        chosen = effect(name, robot)
        console.print(effect_page(chosen))
        return {
            "name": chosen.key,
            "formula": kind.formula,
            "summary": kind.summary,
            "confused_with": kind.confused_with,
            "shown_by": kind.shown_by,
            "fix": kind.fix,
            "parameters": [asdict(parameter) for parameter in chosen.parameters],
            "group": list(chosen.group),
        }

    def _require_robot(self, name: str, robot: Robot) -> None:
        """Refuse an effect that another robot has and this one has not."""
        from sym2real.effects import EFFECTS, Body
        from sym2real.effects.catalogue import columns_of, keys, unknown_effect
        from sym2real.robots import ROBOTS

        kind_name, _, column = name.partition(":")
        if kind_name not in EFFECTS:
            raise unknown_effect(name, (key for other in (robot, *ROBOTS.values()) for key in keys(other)))
        kind = EFFECTS[kind_name]

        def has(robot: Robot) -> bool:
            return kind.fits(Body.of(robot)) and (not column or column in columns_of(kind, robot))

        others = [] if has(robot) else [other.name for other in ROBOTS.values() if has(other)]
        if others:
            raise ModelError(
                f"{self.robot} has no effect {name}; `sym2real effects {name} --robot {others[0]}` shows it"
            )
