"""The pages of a comparison, of a diagnosis and of an adaptation."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from sym2real.adaptation import Adaptation
from sym2real.dataset import Dataset, Logs
from sym2real.diagnosis import Comparison, Diagnosis, compare
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.diagnosis.faults.sanity import check
from sym2real.report.adaptation import rounds_charts, rounds_table
from sym2real.report.diagnosis import gate_line, prediction_lines
from sym2real.report.horizons import ladder_charts
from sym2real.report.html.added import curves
from sym2real.report.html.formulas import formulas
from sym2real.report.html.observed import observe
from sym2real.report.html.page import Figures, Lines, Page, Part, Section
from sym2real.report.html.render import write_page
from sym2real.report.html.sections import accuracy, failing, missing, remaining
from sym2real.report.html.sentences import plain, sentence, sentences
from sym2real.report.html.variants import Given, Predicting, Switch, WithFindings
from sym2real.report.ladder import ladder_table
from sym2real.report.tables import number
from sym2real.symbolic import Equations


def comparison_page(model: Predicting, data: Dataset, comparison: Comparison, title: str) -> Page:
    """How good a model is on logs, and where it fails.

    Args:
        model: equations, or a model that predicts in float64.
        data: the logs of the comparison.
        comparison: what was found.
        title: of the page.
    """
    return model_page(Given((model,)), data, title, comparison)


def diagnosis_page(base: Equations, logs: Dataset, diagnosis: Diagnosis, title: str) -> Page:
    """All five questions.

    Args:
        base: the model that was diagnosed.
        logs: those of the diagnosis; the faults that it found are undone again.
        diagnosis: the diagnosis.
        title: of the page.
    """
    variants = WithFindings(base, diagnosis.findings) if diagnosis.findings else Given((base,))
    data, added = check(base, logs).data, _scored(diagnosis)
    comparison = compare(base, data)
    if diagnosis.where:
        comparison = replace(comparison, where=diagnosis.where)
    return model_page(variants, data, title, comparison, diagnosis.summary, added=added, diagnosis=diagnosis)


def adaptation_page(adaptation: Adaptation, title: str) -> Page:
    """The model that was given and the adapted one on logs that neither has learned from, and every round."""
    reports, on_top = adaptation.reports, adaptation.best
    models = tuple(adaptation.models[number] for number in (0, on_top))
    data = Dataset(log for logs in adaptation.logs[on_top:] for log in logs)
    best, switch = reports[on_top], Switch("what was learned", f"the model of round {on_top}")
    learned = f"from {best.learned.rows} rows" if on_top else "nothing: the model that was given is the best"
    horizon = f"{best.horizon:.3g} s ahead"
    summary = f"Learned {learned}; {horizon} it is {number(best.prediction, 2)} {best.unit} off on an unseen log."
    added = (Figures("Every round", rounds_charts(reports)), rounds_table(reports))
    return model_page(Given(models, (switch,)), data, title, compare(models[0], data), summary, added=added)


def model_page(
    variants: Given | WithFindings,
    data: Dataset,
    title: str,
    comparison: Comparison,
    summary: str = "",
    *,
    added: Sequence[Part] | None = None,
    diagnosis: Diagnosis | None = None,
) -> Page:
    """A model on logs and, where there is one, what it has become.

    Args:
        variants: models that predict.
        data: logs.
        title: of the page.
        comparison: of the model that is given.
        summary: of the page; the comparison's by default.
        added: what stands ahead of the curves where something was added; None where nothing was to be.
        diagnosis: its diagnosis, if there is one.
    """
    observed = observe(variants, data, comparison.start)
    drawn, good, facts = curves(observed), accuracy(comparison, observed), _facts(data)
    sections = [good if added is not None else replace(good, parts=(*good.parts, drawn)), failing(comparison, observed)]
    if diagnosis is not None:
        sections.append(missing(diagnosis))
        facts += [("hypotheses", str(diagnosis.tried)), ("time taken", f"{diagnosis.seconds:.0f} s")]
    if added is not None:
        equations = formulas(variants.base, variants.findings) if isinstance(variants, WithFindings) else []
        sections.append(Section("added", "What happens when it is added?", (*added, drawn, *equations)))
    return Page(
        title,
        summary or _summary(comparison),
        [*sections, remaining(comparison, diagnosis)],
        verdict="" if diagnosis is None else diagnosis.verdict.replace("_", " ").lower(),
        facts=facts,
        switches=variants.switches,
        logs=[(log.name or f"log {place}", log.time[-1] - log.time[0]) for place, log in enumerate(data, start=1)],
    )


def write_diagnosis_page(diagnosis: Diagnosis, base: Equations, logs: Logs, file: str | Path) -> Path:
    """Write the page of a diagnosis; the file.

    Args:
        diagnosis: the diagnosis.
        base: the model that was diagnosed.
        logs: those of the diagnosis.
        file: what to write.
    """
    page = diagnosis_page(base, long_enough(logs, base), diagnosis, f"{base.robot or 'model'}, diagnosed")
    return write_page(page, Path(file))


def _scored(diagnosis: Diagnosis) -> list[Part]:
    """What held-out data say of the findings."""
    parts: list[Part] = []
    if ladder := diagnosis.ladder:
        parts.append(Figures("One effect after the other, on held-out data", ladder_charts(ladder, diagnosis.floor)))
        parts.append(ladder_table(ladder, diagnosis.floor, diagnosis.held_out, apart=diagnosis.apart))
    if diagnosis.gate.best is not None:
        parts.append(Lines("", [sentence(plain(gate_line(diagnosis.gate, diagnosis.gate.best)))]))
    if diagnosis.prediction is not None:
        parts.append(Lines("Values fitted to predictions", sentences(map(plain, prediction_lines(diagnosis)))))
    return parts


def _facts(data: Dataset) -> list[tuple[str, str]]:
    rows, seconds = sum(map(len, data)), sum(len(log) * log.dt for log in data)
    return [("logs", str(len(data))), ("rows", str(rows)), ("length", f"{seconds:.0f} s"), ("step", f"{data.dt:.4g} s")]


def _summary(comparison: Comparison) -> str:
    errors = comparison.at(JUDGED_AT)
    name, first = next(iter(errors.errors.items()))
    return f"{errors.horizon:.3g} s ahead the model's {name} is {first.value:.2g} {first.unit} off (root mean square)."
