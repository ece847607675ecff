"""``sym2real inspect``: what a log seems to hold, and a proposed specification."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from rich.console import Console

from sym2real.cli.places import Place
from sym2real.cli.positionals import JsonFile, Logs
from sym2real.files import write_text


@dataclass(frozen=True)
class Inspect:
    """Say what logs seem to hold, with the evidence per column, and propose a specification that maps them.

    Nothing is decided behind your back: a suspected sign flip is written as a comment with its evidence. The last line
    is the `nominal` command for such a log. A robot of joints has columns of its own: with --model they are looked for
    by their names and numbers (q1, theta1, shoulder_vel, position[0], effort[0]), and what is missing is said.

    For example:
      sym2real inspect flight.csv --out flight.toml
      sym2real inspect swing.csv --model runs/arm --out swing.toml
    """

    OUT_IS_FILE: ClassVar[bool] = True

    logs: Logs
    """Logs of one kind: CSV, Parquet, bags, MCAP, ULog; files without a common column but stamps are one log."""
    columns: tuple[str, ...] = ()
    """Names of the columns of text files without a header, in their order."""
    model: Place | None = None
    """The model whose logs they are: a folder, or a robot's name."""
    out: Path | None = None
    """Write the proposed specification (TOML) here; printed otherwise."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Print the evidence, write or print the specification."""
        from sym2real.cli.nominal_line import NominalLine, nominal_line
        from sym2real.logs import inspect_logs
        from sym2real.report.tables import inspection_table

        of_model: tuple[Any, ...] = ()
        if self.model is not None:
            from sym2real.cli.model import columns_of

            of_model = columns_of(self.model)
        inspection = inspect_logs(self.logs, self.columns, *of_model)
        console.print(inspection_table(inspection))
        text = inspection.toml()
        if self.out:
            write_text(self.out, text)
            waiting = "fill in what its lines leave open, then " if inspection.waiting else ""
            console.print(f"specification in {self.out}; {waiting}use it with --spec {self.out}", markup=False)
        else:
            console.print(text, markup=False, soft_wrap=True)
        line = nominal_line(inspection, self.out) if self.model is None else NominalLine("")
        if line.command:
            console.print(f"first equations for it: {line.command}", markup=False, soft_wrap=True)
        for remark in line.remarks:
            console.print(f"note: {remark}", markup=False)
        flips = inspection.suspected_flips
        return {"columns": inspection.rows, "suspected_flips": flips, "spec": text, "nominal": line}
