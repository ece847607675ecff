"""``sym2real experiment``: the paper's experiments as one reproducible study."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from sym2real.cli.numbers import Count, Seed
from sym2real.cli.positionals import ExperimentPlace, JsonFile
from sym2real.errors import ModelError

if TYPE_CHECKING:
    from sym2real.experiments.study.outcome import Outcome

LIST, ANSWER = "list", "outcome.json"
FIRST = "the base of a robot that nobody has learned here yet takes minutes first, and is kept"


@dataclass(frozen=True)
class RunExperiment:
    """Run an experiment of the paper, or cases of your own, and print its table beside what the paper says.

    Every answer is kept in OUT/answers as soon as it is there: an experiment that was stopped goes on where it was, and
    one that is complete prints its table at once. OUT/figure.png has the curves, OUT/outcome.json everything printed.

    Cases of your own are a TOML file like those in sym2real/experiments/cases: a robot, a task, and what the target has
    that the plain simulator lacks. `sym2real effects` lists the effects that it may have.

    For example:
      sym2real experiment list
      sym2real experiment sim2sim --out runs/sim2sim
      sym2real experiment mine.toml --out runs/mine --contestants sr-nn sr-effect --jobs 8
      sym2real experiment sim2sim --full --out runs/full --cluster tcp://10.0.0.5:8786
    """

    name: ExperimentPlace
    """An experiment, a file.toml with cases, or "list" to see what there is."""
    out: Path | None = None
    """Folder for the answers, the figure and the table."""
    full: bool = False
    """The paper's own size: 1024 samples, ensembles of 4 × (4 × 200) on every case, networks from scratch, PPO. By
    default what two cores do in two hours: fewer samples, neural bases on one case a robot, nothing fine-tuned."""
    cases: tuple[str, ...] = ()
    """Only these cases of a file."""
    contestants: tuple[str, ...] = ()
    """Only these ways to adapt (the list shows them)."""
    seeds: tuple[Seed, ...] = ()
    """Only these seeds; 1 2 3 by default."""
    jobs: Count = 2
    """Processes on this machine, each on one thread."""
    cluster: str = ""
    """Address of a dask scheduler whose workers run the jobs instead, for example tcp://10.0.0.5:8786."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Run what is missing, print the table, write the figure."""
        if self.name == LIST:
            return _list(console)
        if self.out is None:
            raise ModelError("expected --out FOLDER: every answer is kept there; `sym2real experiment list` needs none")
        from sym2real.cli.progress import sweep_progress
        from sym2real.cli.terminal import progress_console
        from sym2real.experiments.study.catalogue import experiment
        from sym2real.experiments.study.effort import FULL, QUICK
        from sym2real.experiments.study.sweep import run_sweep

        chosen = experiment(self.name, self.cases, self.contestants)
        effort = (FULL if self.full else QUICK).of_seeds(self.seeds)
        progress_console().print(f"preparing {self.name}; {FIRST}", style="dim", markup=False)
        jobs = chosen.jobs(effort)
        with sweep_progress(self.out) as on_progress:
            answers = run_sweep(jobs, self.out, workers=self.jobs, cluster=self.cluster, on_progress=on_progress)
        return _show(chosen.outcome(effort, answers), self.out, console)


def _show(outcome: Outcome, out: Path, console: Console) -> dict[str, Any]:
    """Print the table, write table and figure."""
    from sym2real.cli.output import write_json
    from sym2real.report.experiment import outcome_figure, outcome_table
    from sym2real.report.style import save

    console.print(outcome_table(outcome))
    for note in outcome.notes:
        console.print(note, style="dim", markup=False)
    rows = [dict(zip(outcome.columns, row, strict=True)) for row in outcome.rows]
    result: dict[str, Any] = {
        "rows": rows,
        **{name: value for name, value in vars(outcome).items() if name not in ("columns", "rows")},
    }
    if outcome.panels:
        result["figure"] = save(outcome_figure(outcome), out, "figure")
        console.print(f"curves in {result['figure']}", markup=False)
    write_json(result, out / ANSWER)
    return result


def _list(console: Console) -> dict[str, Any]:
    """What can be run, and who can be asked."""
    from sym2real.experiments.study.catalogue import experiment, experiment_names
    from sym2real.experiments.study.contestants import CONTESTANTS
    from sym2real.report.tables import compact_table

    about = {name: experiment(name).about for name in experiment_names()}
    titles = {key: contestant.title for key, contestant in CONTESTANTS.items()}
    for kind, rows in (("experiment", about), ("contestant", titles)):
        console.print(compact_table("", (kind, ""), rows.items(), left=(kind, "")))
    return {"experiments": about, "contestants": CONTESTANTS}
