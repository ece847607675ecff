"""A diagnosis, or the test of one effect, for the terminal."""

import shlex
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table

from sym2real.diagnosis import Diagnosis, Fall, Fault, Finding, Gate, HypothesisTest, Term, Where
from sym2real.diagnosis.predict.competitors import NotTested
from sym2real.diagnosis.unexplained.disturbance_terms import name_of_earlier
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.effects.bound import NO_COLUMN
from sym2real.effects.few_words import in_few_words
from sym2real.effects.searching import SETTLED
from sym2real.logs.conditions import CHANGE_OF
from sym2real.report.ladder import ladder_table
from sym2real.report.leftover import measure, statement
from sym2real.report.tables import number, table_of

STYLE = {"EFFECT": "bold yellow", "NOTHING_MISSING": "bold green", "UNEXPLAINED": "bold red", "CANNOT_TELL": "bold"}
# A share goes by what statistics sees, the ladder by what a user does.
SHARES = "misfit: squared errors within a second, all channels against their noise; the ladder: errors further ahead"
TOO_FEW = "too few independent pieces of data for a test"
OTHER_FORM = "An effect stands for more than itself: its form, or another effect, is not what the robot has"
OF_COMMANDS = (CHANGE_OF, name_of_earlier(""))
BETWEEN_ROWS = "a controller that is faster than its log leaves the like: `nominal --dt` with its step takes that away"
NO_BETTER_THAN_HOLD = "no model predicts these logs better than that nothing changes, so tests over whole logs decide"


def diagnosis_report(
    diagnosis: Diagnosis, shown_before: Collection[str] = (), page: Path | None = None
) -> RenderableType:
    """Everything a person reads of a diagnosis.

    Args:
        diagnosis: what was found.
        shown_before: remarks on the data that the reader saw before the search, which are not repeated.
        page: file that will say why each effect was not tested, so that names will do here.
    """
    parts: list[RenderableType] = [f"[{STYLE[diagnosis.verdict]}]{diagnosis.verdict}[/] {escape(diagnosis.summary)}"]
    parts += fault_lines(diagnosis.faults)
    parts += where_lines(diagnosis.where)
    if diagnosis.findings:
        parts += ["", f"[bold]what the model lacks[/] [dim]({SHARES})[/]", findings_list(diagnosis.findings), ""]
    if diagnosis.ladder:
        parts.append(ladder_table(diagnosis.ladder, diagnosis.floor, diagnosis.held_out, apart=diagnosis.apart))
    if diagnosis.gate.best is not None:
        parts.append(gate_line(diagnosis.gate, diagnosis.gate.best))
    parts += prediction_lines(diagnosis) if diagnosis.predicts_better else []
    parts += leftover_lines(diagnosis.leftovers)
    parts += proposal_lines(diagnosis.proposal)
    parts += note_lines([note for note in diagnosis.notes if note not in shown_before])
    parts += [f"[dim]{escape(line)}[/]" for line in untested_lines(diagnosis, page)]
    parts.append(f"[dim]{misfit_line(diagnosis)}; {diagnosis.tried} hypotheses tested; {diagnosis.seconds:.0f} s[/]")
    return Group(*parts)


def diagnosis_in_short(diagnosis: Diagnosis) -> RenderableType:
    """Verdict, faults, findings and what is left, without the figures that bear them out."""
    parts: list[RenderableType] = [f"{diagnosis.verdict} {escape(diagnosis.summary)}"]
    parts += fault_lines(diagnosis.faults)
    if diagnosis.findings:
        parts.append(findings_list(diagnosis.findings))
    parts += leftover_lines(diagnosis.leftovers)
    return Group(*parts, *map(escape, untested_lines(diagnosis)))


def untested_lines(diagnosis: Diagnosis, page: Path | None = None) -> list[str]:
    """Effects of such a robot that were not tested, a line for every reason, or for all whose reasons stand on a page.

    What the checks of the data settle, and what is about a column that is not there, goes without saying.
    """
    left_out = [
        entry for entry in diagnosis.not_tried if entry.reason != SETTLED and not entry.reason.endswith(NO_COLUMN)
    ]
    if page is None or not left_out:
        return [f"not tested: {line}" for line in lines_by_reason(left_out)]
    return [f"not tested ({page} says why): {', '.join(in_few_words(entry.effect for entry in left_out))}"]


def lines_by_reason(left_out: Iterable[NotTested]) -> Iterator[str]:
    """A line for every reason, with the effects that it holds for."""
    ordered = sorted(left_out, key=lambda entry: entry.reason)
    for reason, same in groupby(ordered, key=lambda entry: entry.reason):
        yield f"{', '.join(in_few_words(entry.effect for entry in same))}: {reason}"


def leftover_lines(leftovers: Sequence[Leftover]) -> list[str]:
    """What no effect explains, a line each."""
    lines = []
    for left in leftovers:
        words = f"{statement(left)} ({measure(left, ' on unseen logs')}): {left.term}"
        lines.append(f"[red]left over[/] {escape(words)}")
    if any(left.matters and left.explained_by.startswith(OF_COMMANDS) for left in leftovers):
        lines.append(f"[dim]{BETWEEN_ROWS}[/]")
    return lines


def gate_line(gate: Gate, best: Fall) -> str:
    """Whether held-out predictions become better by as much as they must, and none worse; nothing of mere noise."""
    if not gate.beats_hold:
        return f"[green]gate passed[/]: {NO_BETTER_THAN_HOLD}"
    verdict = "[green]gate passed[/]" if gate.passed else "[red]gate not passed[/]"
    risen = "".join(f"; that {rise.text}, beyond its interval" for rise in gate.worse)
    return f"{verdict}: the held-out error {best.text}{risen}"


def prediction_lines(diagnosis: Diagnosis) -> list[str]:
    """What a fit to predictions has changed: both sets of values, and errors of logs that each fit left out."""
    refit = diagnosis.prediction
    if refit is None:
        return []
    before, after = (stage.horizons[refit.horizon] for stage in (refit.before, refit.after))
    errors = [
        f"{name} {number(before[name].value)} → {number(after[name].value)} {before[name].unit}" for name in before
    ]
    text = f"errors {refit.horizon:.3g} s ahead of logs that the fit left out: {', '.join(errors)}"
    if not refit.kept:
        return [
            f"[dim]values fitted to predictions predict no better beyond chance, and were not kept ({escape(text)})[/]"
        ]
    values = [
        (finding.parameters[name], value, f"{finding.effect} {name}")
        for finding, own in zip(diagnosis.findings, refit.values, strict=True)
        for name, value in own.items()
    ]
    listed = "; ".join(f"{name} {number(value)} (physical {number(own.value)})" for own, value, name in values)
    beyond = [name for own, value, name in values if abs(value - own.value) > own.high - own.low]
    lines = [f"[green]other values predict better[/]: {escape(listed)}; {escape(text)}"]
    if beyond:
        names = escape(", ".join(beyond))
        lines.append(f"[yellow]further from the physical value than its interval is wide[/]: {names}. {OTHER_FORM}")
    return lines


def misfit_line(diagnosis: Diagnosis) -> str:
    """How much of what the base leaves is explained."""
    base, explained = diagnosis.misfit
    return f"misfit per degree of freedom {number(base)} → {number(explained)}; 1 is fully explained"


def proposal_lines(term: Term | None) -> list[str]:
    """A proposed term, if there is one."""
    if term is None:
        return []
    fall = f"lowers the whitened loss of pieces left out by {100 * term.gain:.1f} %"
    return [f"[yellow]proposed, unverified[/] {escape(term.expression)} beside {escape(term.channel)}: {fall}"]


def term_command(term: Term, model: str) -> str:
    """What puts a proposed term into a model, on one line, as a shell reads it."""
    return f'sym2real add {shlex.quote(model)} "term:{term.channel}={term.expression}" --out NEW'


def hypothesis_report(test: HypothesisTest) -> RenderableType:
    """Everything a person reads of effects that were held against logs."""
    verdict = "[bold green]SUPPORTED[/]" if test.supported else "[bold red]NOT SUPPORTED[/]"
    parts: list[RenderableType] = [f"{verdict} {escape(test.summary)}"]
    parts += fault_lines(test.faults)
    parts += [findings_list(test.findings), ""]
    if test.rivals:
        parts.append(alternatives_table(test))
    if test.ladder:
        parts.append(ladder_table(test.ladder, test.floor, test.held_out, apart=test.apart))
    parts += note_lines(test.notes)
    parts.append(f"[dim]{test.seconds:.0f} s[/]")
    return Group(*parts)


def fault_lines(faults: Sequence[Fault]) -> list[str]:
    """What is wrong with the data and was undone, a line each, and what to change."""
    return [f"[red]fault[/] {escape(fault.sentence)}; fix: {escape(fault.fix)}" for fault in faults]


def where_lines(where: Sequence[Where]) -> list[str]:
    """Where a model fails, a line each."""
    return [f"[bold]the model as given fails[/] {escape(region.statement)}" for region in where]


def note_lines(notes: Sequence[str]) -> list[str]:
    """Remarks on data and method, a line each."""
    return [f"[dim]note: {escape(note)}[/]" for note in notes]


def findings_list(findings: Sequence[Finding]) -> Table:
    """Per finding: values with intervals, share, what the data cannot tell it from, what to do."""
    table = Table.grid(padding=(0, 2, 0, 0))
    table.add_column(no_wrap=True, justify="right", style="dim")
    table.add_column(overflow="fold")
    for place, finding in enumerate(findings, start=1):
        few = f" (provisional: {TOO_FEW})" if finding.provisional else ""
        share = f"removes {'under 1' if finding.share < 0.01 else f'{100 * finding.share:.0f}'} % of the misfit"
        table.add_row(str(place), f"[bold]{escape(finding.effect)}[/]  {share}{few}")
        for name, estimate in finding.parameters.items():
            interval = interval_text(finding, name)
            table.add_row("", f"{escape(name)} = [bold]{escape(estimate.text)}[/]  [dim]{interval}[/]")
        for label, text in known_of(finding):
            table.add_row(label, escape(text))
    return table


def interval_text(finding: Finding, name: str) -> str:
    """How well a value is known: its interval, and what logs one by one say."""
    estimate, spread = finding.parameters[name], finding.log_spread.get(name)
    # Which rotor it is has no interval.
    known = [f"95 % {number(estimate.low)} … {number(estimate.high)}"] if estimate.low < estimate.high else []
    return ", ".join([*known, *([] if spread is None else [f"from log to log ± {number(spread, 2)}"])])


def known_of(finding: Finding) -> list[tuple[str, str]]:
    """What is known of a finding beside its values: label and text."""
    facts, others = [], finding.alternatives
    if finding.probability is not None:
        whose = ", of it or one of those below" if others else ""
        facts.append(("probability", f"{100 * finding.probability:.0f} % against none, and others in its place{whose}"))
    if others:
        facts.append(("or", f"{', '.join(in_few_words(others))}: these logs do not tell which"))
    if finding.separate_by:
        facts.append(("tell apart", finding.separate_by))
    return [*facts, ("fix", finding.fix)]


def alternatives_table(test: HypothesisTest) -> Table:
    """What other effects would do in the place of each of the hypothesis."""
    rows, hypothesis = [], "the hypothesis" if len(test.findings) == 1 else "the hypothesis, beside the others"
    for finding in test.findings:
        own = (finding.effect, f"{100 * test.beside[finding.effect]:.1f} %", hypothesis)
        rows.append(tuple(f"[bold]{escape(cell)}[/]" for cell in own))
        for other in (other for other in test.rivals if other.instead_of == finding.effect):
            remark = "cannot be told from it" if other.as_good else ""
            rows.append((escape(other.effect), f"{100 * other.gain:.1f} %", remark))
    return table_of("in its place", ("effect", "lowers the held-out loss by", ""), rows, left=("effect", ""))
