"""What logs say of a hypothesis, in one sentence or two."""

from sym2real.diagnosis import HypothesisTest
from sym2real.diagnosis.settings import SETTINGS


def hypothesis_summary(test: HypothesisTest) -> str:
    """Whether the logs ask for it, by how much, and what else would do."""
    names = " and ".join(finding.effect for finding in test.findings)
    lowered = f"{'it lowers' if len(test.findings) == 1 else 'together they lower'} the held-out loss by"
    undone = [fault.name for fault in test.faults if fault.effect in test.refused]
    rest = f", once the fault of the logs is undone ({', '.join(undone)})" if undone else ""
    sentence = f"{names}: {lowered} {_percent(test.gain)}{rest}"
    if test.unneeded and set(test.refused) == set(test.unneeded):
        small = f"predictions do not need {' or '.join(test.unneeded)}"
        return f"The logs show {sentence}, but {small}, and whole logs do not establish it{_better(test)}."
    if test.outdone:
        return f"The logs do not ask for {sentence}{_better(test)}, and leaves too little for it."
    if not test.supported:
        most = SETTINGS.gain_of(len(test.findings))
        if min(test.beside[key] for key in test.refused if key not in test.unneeded) > most:
            few = "too few independent pieces of these logs tell of it"
            why = f"but {few}, or its fit ends where no value is likely"
            return f"The logs do not establish {sentence}, {why}{_refused(test)}{_better(test)}."
        return f"The logs do not ask for {sentence}; up to {_percent(most)} is needed{_refused(test)}{_better(test)}."
    both = "; only a fit of both says how much of each there is" if any(other.better for other in test.rivals) else ""
    return f"The logs ask for {sentence}{_better(test) or _others(test)}{both}."


def _refused(test: HypothesisTest) -> str:
    """Of several, how much those that are not supported take."""
    several = test.refused if len(test.findings) > 1 else ()
    return "".join(f"; {key} lowers what the others leave by {_percent(test.beside[key])}" for key in several)


def _better(test: HypothesisTest) -> str:
    """What does more in the place of one."""
    groups = {finding.effect: finding.group for finding in test.findings}
    for other in sorted(test.rivals, key=lambda other: other.instead_of not in test.outdone):
        more = other.gain > test.beside[other.instead_of] + SETTINGS.gain
        if other.better or (more and other.effect not in groups[other.instead_of]):
            place = "its place" if len(test.findings) == 1 else f"the place of {other.instead_of}"
            return f"; {other.effect} in {place} lowers it by {_percent(other.gain)}"
    return ""


def _others(test: HypothesisTest) -> str:
    """What does as well as one."""
    if any(finding.doubtful for finding in test.findings):
        return "; commands that change between the rows of the logs do as well"
    if len(test.findings) == 1:
        return f"; {' or '.join(test.finding.alternatives[:3]) or 'no other effect'} does as well"
    alike = {finding.effect: finding.alternatives[:3] for finding in test.findings}
    clauses = [f"{' or '.join(group)} does as well as {key}" for key, group in alike.items() if group]
    return f"; {'; '.join(clauses) or 'no other effect does as well as one of them'}"


def _percent(part: float) -> str:
    return f"{100 * part:.3g} %"
