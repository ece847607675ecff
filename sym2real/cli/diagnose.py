"""``sym2real diagnose``: which physical effect a model lacks, from logs."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from rich.console import Console

from sym2real.cli.of_logs import OfFit
from sym2real.cli.positionals import HtmlFile, JsonFile, Logs, ModelPlace


@dataclass(frozen=True)
class Diagnose(OfFit):
    """Name the physical effect that a model lacks, or say that nothing is missing, or that the data cannot tell.

    Every effect of the catalogue that the model can be given competes; what is found is tested on data that took no
    part in its fit. With the model of a registered robot the base is first calibrated in its plain simulator.
    Several logs of different manoeuvres tell more than one long one; `sym2real plan` says beforehand what a manoeuvre
    can show. Once the progress line says that it searches, Ctrl-C ends what is being done there (the search, scoring,
    manoeuvres, drawing) and keeps what is done; earlier it ends without an answer.

    With --out: diagnosis.json and a page, report.html; where what was found passes the gate, also the model with it,
    in model/, and the robot with it, in simulator/. Where values fitted to predictions, open loop to --horizon, predict
    logs better that the fit left out, a second model has these, in model_prediction/: model/ says what is,
    model_prediction/ predicts best. Files that an earlier diagnosis left there are removed.

    Example: sym2real diagnose runs/base flight1.csv flight2.csv --spec flight.toml --out runs/diagnosis
    """

    FOLDERS: ClassVar = ("model", "model_prediction", "simulator")

    model: ModelPlace
    logs: Logs
    """Logs (CSV, Parquet, bags, MCAP, ULog); several of different manoeuvres tell more than one."""
    out: Path | None = None
    """Folder for diagnosis.json, report.html, the informed model and the simulator with what was found."""
    report: HtmlFile = None
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Diagnose, print the report, write the files."""
        from sym2real.cli.model import equations_below, folder_of, require_another_folder
        from sym2real.cli.output import title_of, write_report
        from sym2real.cli.progress import stages_progress
        from sym2real.cli.results import PAGE, plain_simulator, write_diagnosis
        from sym2real.diagnosis import data_report, diagnose
        from sym2real.effects.catalogue import require_patterns
        from sym2real.report.diagnosis import diagnosis_report, term_command
        from sym2real.report.html.pages import diagnosis_page
        from sym2real.symbolic.storage import training_region

        require_patterns(self.exclude)
        if self.out:
            require_another_folder(self.model, self.out / "model")
        base, about_model = equations_below(self.model, console)
        data, options = self.read(base, self.logs)
        about_data = data_report(data, base).remarks
        for line in about_data:
            console.print(f"data: {line}", style="dim", markup=False)
        with stages_progress() as on_progress:
            diagnosis = diagnose(
                base,
                data,
                plain_simulator(base),
                **options,
                region=training_region(folder_of(self.model)),
                on_progress=on_progress,
                finish_on_interrupt=True,
            )
        diagnosis = replace(diagnosis, notes=(*about_model, *diagnosis.notes))
        page_at = self.out / PAGE if self.out else self.report
        console.print(diagnosis_report(diagnosis, [*about_data, *about_model], page_at))
        if diagnosis.proposal is not None:
            console.print("to try what is proposed:")
            console.print(term_command(diagnosis.proposal, self.model), markup=False, soft_wrap=True)
        result, page = diagnosis.to_dict(), None
        if self.out:
            result, page = write_diagnosis(base, data, diagnosis, self.out, console)
        if self.report:
            title = title_of(self.model, "diagnosed")
            page = replace(page, title=title) if page else diagnosis_page(base, data, diagnosis, title)
            result["report"] = write_report(page, self.report, console)
        return result
