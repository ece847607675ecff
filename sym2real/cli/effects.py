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
    robot: Place | None = None
    """Robot whose effects are listed and whose numbers give units, bounds and scales: its name or a model folder; by
    default the first that has the effect, and the Crazyflie's catalogue."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Print the catalogue or the page."""
        from sym2real.effects import EFFECTS, Body, effect
        from sym2real.effects.catalogue import columns_of
        from sym2real.report.effects import catalogue_table, effect_page

        robot = self._robot()
        if self.name is None:
            kinds = [kind for kind in EFFECTS.values() if kind.fits(Body.of(robot))]
            console.print(catalogue_table(kinds, robot.title))
            return {"effects": [{"name": kind.name, "stage": kind.stage, "summary": kind.summary} for kind in kinds]}
        name, kind = self.name, EFFECTS[self.name.partition(":")[0]]
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

    def _robot(self) -> Robot:
        """The robot that is asked for, else the first that has the effect.

        Raises:
            ModelError: where the one that is asked for has not.
        """
        from sym2real.effects import EFFECTS, Body
        from sym2real.effects.catalogue import columns_of, keys, unknown_effect
        from sym2real.experiments.models import robot_called
        from sym2real.robots import ROBOTS

        asked = [] if self.robot is None else [robot_called(self.robot)]
        robots = asked or [*ROBOTS.values()]
        first = (*asked, ROBOTS["crazyflie"])[0]
        if self.name is None:
            return first
        kind, _, column = self.name.partition(":")
        if kind not in EFFECTS:
            raise unknown_effect(self.name, (key for robot in (*robots, *ROBOTS.values()) for key in keys(robot)))
        for robot in robots:
            if EFFECTS[kind].fits(Body.of(robot)) and (not column or column in columns_of(EFFECTS[kind], robot)):
                return robot
        if asked:
            raise ModelError(f"{self.robot} has no effect {self.name}")
        return first
