"""The pages of a comparison and of a diagnosis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.text import Text

from sym2real.dataset import Dataset, Logs
from sym2real.diagnosis import Comparison, Diagnosis, compare
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.diagnosis.faults.sanity import check
from sym2real.report.diagnosis import gate_line
from sym2real.report.html.accuracy import accuracy
from sym2real.report.html.added import curves, ladder_charts, ladder_rows
from sym2real.report.html.arrays import Arrays
from sym2real.report.html.failing import failing
from sym2real.report.html.formulas import formulas
from sym2real.report.html.missing import missing
from sym2real.report.html.observed import Observed, observe
from sym2real.report.html.page import Figures, Formulas, Lines, Page, Part, Section
from sym2real.report.html.remaining import remaining
from sym2real.report.html.render import write_page
from sym2real.report.html.sentences import sentence
from sym2real.report.html.variants import Given, Predicting, Variants, WithFindings
from sym2real.symbolic import Equations

ADDED = "What happens when it is added?"


def comparison_page(model: Predicting, data: Dataset, comparison: Comparison, title: str) -> Page:
    """How good a model is on logs, and where it fails.

    Args:
        model: equations, or a model that predicts in float64.
        data: the logs of the comparison.
        comparison: what was found.
        title: of the page.
    """
    return model_page(Given((model,)), data, title, comparison=comparison)


def model_page(
    models: Given,
    data: Dataset,
    title: str,
    *,
    comparison: Comparison | None = None,
    summary: str = "",
    added: Section | None = None,
    arrays: Arrays | None = None,
) -> Page:
    """A model on logs and, where there is one, what it has become.

    Args:
        models: predict in float64.
        data: logs.
        title, summary: of the page.
        comparison: of the first model; made where it is none.
        added: section of what was added, which gets the curves.
        arrays: those that ``added`` draws.
    """
    arrays = arrays or Arrays()
    comparison = comparison or compare(models.models[0], data)
    observed, switched = _observed(models, data, comparison), bool(models.switches)
    drawn = curves(observed, arrays, switched=switched)
    good = accuracy(comparison, observed, arrays, switched=switched)
    sections = [
        good if added else replace(good, parts=(*good.parts, drawn)),
        failing(comparison, observed, arrays, switched=switched),
        *([replace(added, parts=(*added.parts, drawn))] if added else []),
        remaining(comparison, None),
    ]
    return Page(
        title,
        summary or _said(comparison),
        sections,
        facts=_facts(data),
        arrays=arrays,
        switches=models.switches,
        logs=_names(data),
    )


def diagnosis_page(base: Equations, data: Dataset, found: Diagnosis, title: str, notes: Sequence[str] = ()) -> Page:
    """All five questions.

    Args:
        base: the model that was diagnosed.
        data: logs, the faults that were found undone.
        found: the diagnosis.
        title: of the page.
        notes: further remarks.
    """
    arrays, comparison = Arrays(), compare(base, data)
    if found.where:
        comparison = replace(comparison, where=found.where)
    variants: Variants = WithFindings(base, found.findings) if found.findings else Given((base,))
    observed, switched = _observed(variants, data, comparison), bool(found.findings)
    sections = [
        accuracy(comparison, observed, arrays, switched=switched),
        failing(comparison, observed, arrays, switched=switched),
        missing(base, found.findings, found.faults),
        Section("added", ADDED, _added(variants, found, observed, arrays)),
        remaining(comparison, found, notes),
    ]
    facts = [*_facts(data), ("hypotheses", str(found.tried)), ("time taken", f"{found.seconds:.0f} s")]
    return Page(
        title,
        found.summary,
        sections,
        verdict=found.verdict.replace("_", " ").lower(),
        facts=facts,
        arrays=arrays,
        switches=variants.switches,
        logs=_names(data),
    )


def write_diagnosis_page(found: Diagnosis, base: Equations, logs: Logs, file: str | Path) -> Path:
    """Write the page of a diagnosis; the file.

    Args:
        found: the diagnosis.
        base: the model that was diagnosed.
        logs: those of the diagnosis; the faults that it found are undone again.
        file: what to write.
    """
    data = long_enough(logs, base)
    title = f"{base.robot or 'model'}, diagnosed"
    return write_page(diagnosis_page(base, check(base, data).data, found, title), Path(file))


def _added(variants: Variants, found: Diagnosis, observed: Observed, arrays: Arrays) -> list[Part]:
    parts: list[Part] = []
    if found.ladder:
        charts = ladder_charts(found.ladder, found.floor, arrays)
        parts.append(Figures("One effect after the other, on held-out data", charts))
        parts.append(ladder_rows(found.ladder, found.held_out, apart=found.apart))
    if found.gate.best is not None:
        parts.append(Lines("", [sentence(Text.from_markup(gate_line(found.gate, found.gate.best)).plain)]))
    parts.append(curves(observed, arrays, switched=bool(found.findings)))
    equations: list[Formulas] = formulas(variants) if isinstance(variants, WithFindings) else []
    return [*parts, *equations]


def _observed(variants: Variants, data: Dataset, comparison: Comparison) -> Observed:
    places = {log.name: index for index, log in enumerate(data)}
    single = [(places[segment.log], segment.start) for segment in comparison.worst if segment.log in places]
    return observe(variants, data, comparison.start, single)


def _facts(data: Dataset) -> list[tuple[str, str]]:
    rows, seconds = sum(map(len, data)), sum(len(log) * log.dt for log in data)
    return [("logs", str(len(data))), ("rows", str(rows)), ("length", f"{seconds:.0f} s"), ("step", f"{data.dt:.4g} s")]


def _names(data: Dataset) -> list[str]:
    return [log.name or f"log {place}" for place, log in enumerate(data, start=1)]


def _said(comparison: Comparison) -> str:
    errors = comparison.at(JUDGED_AT) if comparison.horizons else comparison.one_step
    name, first = next(iter(errors.errors.items()))
    return f"{errors.horizon:.3g} s ahead the model's {name} is {first.value:.2g} {first.unit} off (root mean square)."
