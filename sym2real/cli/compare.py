"""``sym2real compare``: how far a model's predictions are from logs."""

from dataclasses import dataclass
from typing import Any, Literal

from rich.console import Console

from sym2real.cli.of_logs import OfLogs
from sym2real.cli.positionals import HtmlFile, JsonFile, Logs, ModelPlace


@dataclass(frozen=True)
class Compare(OfLogs):
    """Compare a model's predictions with recorded logs: one step, k steps and free run, beside "hold".

    Windows start every 0.1 s, are driven by what the log says was sent, and are measured at their end.

    Example: sym2real compare runs/base flight.csv --spec flight.toml --report compared.html
    """

    model: ModelPlace
    logs: Logs
    """Logs: CSV, Parquet, bags, MCAP, ULog."""
    start: Literal["smoothed", "measured"] = "smoothed"
    """Start windows from the last ten rows, smoothed, or from the measured row."""
    report: HtmlFile = None
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Print the report, write the page."""
        from sym2real.cli.model import folder_of, logs_for, open_with_progress
        from sym2real.cli.output import title_of, write_report
        from sym2real.diagnosis import compare
        from sym2real.diagnosis.faults.mistakes.lost_commands import with_lost_commands
        from sym2real.neural.model_folder import below
        from sym2real.report.comparison import comparison_report
        from sym2real.report.html.pages import comparison_page
        from sym2real.symbolic import Equations
        from sym2real.symbolic.storage import training_region

        model = open_with_progress(self.model)
        data = logs_for(below(model), self.logs, self.naming, upsample=not isinstance(model, Equations))
        data = with_lost_commands(model, data) if isinstance(model, Equations) else data
        comparison = compare(model, data, start=self.start, region=training_region(folder_of(self.model)))
        console.print(comparison_report(comparison))
        result = comparison.to_dict()
        if self.report:
            page = comparison_page(model, data, comparison, title_of(self.model, "compared"))
            result["report"] = write_report(page, self.report, console)
        return result
