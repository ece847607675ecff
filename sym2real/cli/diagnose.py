"""``sym2real diagnose``: which physical effect a model lacks, from logs."""

from __future__ import annotations

import json as json_module
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tyro
from rich.console import Console

if TYPE_CHECKING:
    from sym2real.plants import MujocoPlant
    from sym2real.symbolic import Equations


@dataclass(frozen=True)
class Diagnose:
    """Name the physical effect that a model lacks, or say that nothing is missing, or that the data cannot tell.

    Every effect of the catalogue that the model can be given competes; what is found is tested on data that took no
    part in its fit. With the model of a registered robot the base is first calibrated in its plain simulator.

    Example: sym2real diagnose runs/base flight1.csv flight2.csv --spec flight.toml --out runs/diagnosis
    """

    model: tyro.conf.Positional[str]
    """A model folder, or a robot's name (its base is learned once and cached)."""
    logs: tyro.conf.Positional[tuple[Path, ...]]
    """Logs, CSV or Parquet; several of different manoeuvres tell more than one."""
    held_out: tuple[Path, ...] = ()
    """Logs that score the result; by default each log is scored by the fit without it."""
    spec: str | None = None
    """How the logs' columns are named: a shipped specification's name or a TOML file."""
    exclude: tuple[str, ...] = ()
    """Effects that are not to be tried (KIND or KIND:COLUMN)."""
    horizon: float | None = None
    """Longest horizon of the error ladder in s."""
    calibrate: bool = True
    """Calibrate the base in the robot's plain simulator first."""
    out: Path | None = None
    """Folder for diagnosis.json and the model with the findings in it."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    def run(self, console: Console) -> dict[str, Any]:
        """Diagnose, print the report, write the files."""
        from sym2real.cli.model import logs_for, open_with_progress
        from sym2real.diagnosis import diagnose
        from sym2real.report.diagnosis import diagnosis_report
        from sym2real.symbolic import save_model

        equations = open_with_progress(self.model, console)
        data = logs_for(equations, self.logs, self.spec)
        held_out = logs_for(equations, self.held_out, self.spec) if self.held_out else None
        plant = self._plant(equations)
        with console.status("starting") as status:
            found = diagnose(
                equations,
                data,
                plant,
                held_out=held_out,
                exclude=self.exclude,
                horizon=self.horizon,
                on_progress=status.update,
            )
        console.print(diagnosis_report(found))
        result = found.to_dict()
        if self.out:
            self.out.mkdir(parents=True, exist_ok=True)
            beside = self.out / ".diagnosis.json.tmp"
            beside.write_text(json_module.dumps(result, indent=1))
            beside.replace(self.out / "diagnosis.json")
            if found.findings:
                save_model(found.apply(equations), self.out / "model")
            console.print(f"diagnosis.json and the informed model in {self.out}")
        return result

    def _plant(self, equations: Equations) -> MujocoPlant | None:
        from sym2real.plants import MujocoPlant
        from sym2real.robots import ROBOTS

        known = equations.robot in ROBOTS and ROBOTS[equations.robot].layouts == equations.layouts
        return MujocoPlant(ROBOTS[equations.robot]) if self.calibrate and known else None
