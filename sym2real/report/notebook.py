"""What a notebook shows of an answer: the terminal's tables as HTML, and its figure."""

from collections.abc import Mapping
from io import BytesIO, StringIO

from matplotlib.figure import Figure
from rich.console import Console, RenderableType

from sym2real.adaptation.loop import Adaptation
from sym2real.diagnosis import Comparison, Diagnosis, HypothesisTest, Plan
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.errors import ModelError
from sym2real.report.adaptation import rounds_figure
from sym2real.report.comparison import comparison_report
from sym2real.report.diagnosis import diagnosis_in_short, diagnosis_report, hypothesis_report
from sym2real.report.figures import charts_figure, path_figure, predictions_figure
from sym2real.report.horizons import comparison_charts, ladder_charts
from sym2real.report.html.variants import Predicting
from sym2real.report.plan import plan_report
from sym2real.trajectory import Trajectory

WIDTH = 110  # letters, as wide as a notebook's cell
PAGE = '<pre style="white-space:pre;overflow-x:auto;line-height:1.25;font-family:monospace">{code}</pre>'


def log_plot(log: Trajectory, models: Mapping[str, Predicting]) -> Figure:
    """The path of a log; with models, measured against predicted.

    Raises:
        ShapeError: with models, when the log is too short to predict.
    """
    if not models:
        return _shown(path_figure(log))
    return _shown(predictions_figure(models, long_enough(log, next(iter(models.values())))[0]))


def adaptation_plot(adapted: Adaptation) -> Figure:
    """Errors by round."""
    return _shown(rounds_figure(adapted.reports))


def comparison_plot(comparison: Comparison) -> Figure:
    """Error of every channel over the horizon, beside "hold", the mean and what the sensors' noise alone makes."""
    return _shown(charts_figure(comparison_charts(comparison)))


def ladder_plot(scored: Diagnosis | HypothesisTest) -> Figure:
    """Held-out error of every channel over the horizon for every stage, down to noise and disturbances.

    Raises:
        ModelError: where nothing was scored.
    """
    if not scored.ladder:
        raise ModelError("expected errors on held-out data to draw, found none: nothing was scored")
    charts = ladder_charts(scored.ladder, scored.floor)
    return _shown(charts_figure(charts, "held-out error, one effect after the other"))


def comparison_html(comparison: Comparison) -> str:
    """The tables of a comparison."""
    return _html(comparison_report(comparison))


def diagnosis_html(diagnosis: Diagnosis) -> str:
    """Everything that the terminal says of a diagnosis."""
    return _html(diagnosis_report(diagnosis))


def diagnosis_text(diagnosis: Diagnosis) -> str:
    """The short form of it as plain text."""
    console = Console(file=StringIO(), record=True, emoji=False, width=WIDTH, color_system=None)
    console.print(diagnosis_in_short(diagnosis))
    return "\n".join(line.rstrip() for line in console.export_text().splitlines())


def hypothesis_html(test: HypothesisTest) -> str:
    """Everything that the terminal says of a hypothesis."""
    return _html(hypothesis_report(test))


def plan_html(plan: Plan) -> str:
    """The table of a plan."""
    return _html(plan_report(plan))


def _html(report: RenderableType) -> str:
    console = Console(file=StringIO(), record=True, emoji=False, width=WIDTH, force_terminal=True)
    console.print(report)
    return console.export_html(inline_styles=True, code_format=PAGE)


def _shown(figure: Figure) -> Figure:
    """The figure with the method that notebooks ask for: without pyplot none draws it."""

    def png() -> bytes:
        with BytesIO() as image:
            figure.savefig(image, format="png", dpi=96)
            return image.getvalue()

    vars(figure)["_repr_png_"] = png
    return figure
