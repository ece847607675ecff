"""What is missing? Every effect with its probability, values and intervals, what replaces it, what decides."""

from sym2real.diagnosis import Diagnosis, Finding
from sym2real.effects import EFFECTS
from sym2real.report.diagnosis import TOO_FEW, fault_lines, interval_text, known_of
from sym2real.report.html.page import Card, Cards, Lines, Part, Section
from sym2real.report.html.sentences import plain, sentence

QUESTION = "What is missing?"


def missing(diagnosis: Diagnosis) -> Section:
    """Section of what was found."""
    parts: list[Part] = []
    if diagnosis.findings:
        parts.append(Cards("Effects that the model lacks", [_card(finding) for finding in diagnosis.findings]))
    else:
        parts.append(Lines("", ["No effect was found that the model lacks."]))
    if diagnosis.faults:
        faults = [sentence(plain(line)) for line in fault_lines(diagnosis.faults)]
        parts.append(Lines("Wrong with the data, and undone where the logs tell how", faults))
    return Section("missing", QUESTION, parts)


def _card(finding: Finding) -> Card:
    facts = [("removes", f"{100 * finding.share:.0f} % of the squared error beyond noise")]
    if finding.provisional:
        facts.append(("provisional", TOO_FEW))
    for name, estimate in finding.parameters.items():
        interval = interval_text(finding, name)
        facts.append((name, f"{estimate.text} ({interval})" if interval else estimate.text))
    about = EFFECTS[finding.effect.partition(":")[0]].summary
    return Card(finding.effect, about, [*facts, *known_of(finding)], finding.share)
