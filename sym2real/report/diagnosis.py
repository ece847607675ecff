"""What a diagnosis found, for the terminal: the sentence first, then findings, ladder, leftover and remarks."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table

from sym2real.diagnosis import Diagnosis, Finding
from sym2real.report.tables import number

STYLE = {"EFFECT": "bold yellow", "NOTHING_MISSING": "bold green", "UNEXPLAINED": "bold red", "CANNOT_TELL": "bold"}


def diagnosis_report(diagnosis: Diagnosis) -> RenderableType:
    """Everything a person reads of a diagnosis."""
    parts: list[RenderableType] = [f"[{STYLE[diagnosis.verdict]}]{diagnosis.verdict}[/] {escape(diagnosis.summary)}"]
    parts += [f"[red]fault[/] {fault.effect}: {escape(fault.evidence)}" for fault in diagnosis.faults]
    if diagnosis.findings:
        parts.append(findings_table(diagnosis.findings))
    if diagnosis.ladder:
        parts.append(ladder_table(diagnosis))
    if diagnosis.leftover is not None:
        left = diagnosis.leftover
        parts.append(f"left over: {left.channel} depends on {left.explained_by} (R² {left.r2:.2f}): {left.term}")
    parts += [f"[dim]note: {escape(note)}[/]" for note in diagnosis.notes]
    parts.append(f"[dim]{diagnosis.tried} hypotheses competed; {diagnosis.seconds:.0f} s[/]")
    return Group(*parts)


def findings_table(findings: tuple[Finding, ...]) -> Table:
    """One row per finding: values with intervals, share, what the data cannot tell it from, what to do."""
    table = Table(title="what the model lacks", title_justify="left", show_lines=True)
    for heading in ("effect", "value (95 %)", "share", "or, as far as this data tells", "what to do"):
        table.add_column(heading, overflow="fold")
    for finding in findings:
        values = "\n".join(
            f"{name} {number(one.value)} ({number(one.low)} … {number(one.high)}) {one.unit}"
            for name, one in finding.parameters.items()
        )
        rivals = [rival for rival in finding.group if rival != finding.effect]
        apart = f"\ntell apart: {finding.separate_by}" if finding.separate_by else ""
        name = f"{finding.effect} (provisional)" if finding.provisional else finding.effect
        table.add_row(name, values, f"{100 * finding.share:.0f} %", ", ".join(rivals) + apart, escape(finding.fix))
    return table


def ladder_table(diagnosis: Diagnosis) -> Table:
    """Held-out errors at the longest horizon: the base, then with one finding after the other."""
    horizon = max(diagnosis.ladder[0].horizons)
    table = Table(
        title=f"error {horizon:g} s ahead on {', '.join(diagnosis.held_out) or 'held-out data'}", title_justify="left"
    )
    table.add_column("model")
    channels = diagnosis.ladder[0].horizons[horizon]
    for channel, error in channels.items():
        table.add_column(f"{channel} {error.unit}", justify="right")
    for stage in diagnosis.ladder:
        errors = stage.horizons[horizon]
        cells = [f"{number(one.value)} ({number(one.low)} … {number(one.high)})" for one in errors.values()]
        table.add_row(stage.model, *cells)
    return table
