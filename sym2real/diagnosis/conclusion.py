"""The answer in one word and one sentence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from sym2real.diagnosis.data.windows import JUDGED_AT, judged
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.faults.fault import Fault
from sym2real.diagnosis.score.finding import Finding
from sym2real.diagnosis.score.held_out import Fall, Gate
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.leftover import Leftover

Verdict = Literal["EFFECT", "NOTHING_MISSING", "UNEXPLAINED", "CANNOT_TELL"]


def verdict(
    faults: Sequence[Fault],
    findings: Sequence[Finding],
    leftovers: Sequence[Leftover],
    gate: Gate,
    problems: Problems,
    *,
    finished: bool = True,
) -> Verdict:
    """Which of the four answers the parts make; findings that do not improve long predictions are no answer.

    Fewer than ten independent blocks leave no test, and an unfinished search cannot say that nothing is missing, or
    that no effect explains what is left. A fault alone is the answer only where nothing is left once it is undone.
    Where predictions judge nothing, an effect is the answer if errors fall all the same or nothing else is missing.
    """
    unexplained = any(leftover.matters for leftover in leftovers)
    borne_out = gate.before is None or gate.foretold or gate.fallen
    established = bool(findings) and gate.passed and (borne_out or not unexplained)
    if problems.block_count < SETTINGS.fewest_pieces or not (finished or established):
        return "CANNOT_TELL"
    if established:
        return "EFFECT"
    if unexplained:
        return "UNEXPLAINED"
    if faults:
        return "EFFECT"
    return "CANNOT_TELL" if findings else "NOTHING_MISSING"


def summary(
    answer: Verdict,
    faults: Sequence[Fault],
    findings: Sequence[Finding],
    leftovers: Sequence[Leftover],
    *,
    gate: Gate,
    stages: Sequence[Stage],
    interrupted: str = "",
) -> str:
    """One sentence a person reads; ``interrupted`` is what was, search or scoring, if anything."""
    parts = []
    if faults:
        parts.append("the data show " + ", ".join(fault.name for fault in faults))
    provisional = any(finding.provisional for finding in findings)
    if findings:
        missing = "perhaps missing: " if provisional else "missing: "
        parts.append(missing + "; ".join(_one(finding) for finding in findings))
        fall = fall_of_error(stages)
        if fall is not None:
            parts.append(f"with it the {fall[0]} error on held-out pieces changes from {fall[1]:.3g} to {fall[2]:.3g}")
    parts += [f"{leftover.statement} is left ({leftover.measure})" for leftover in leftovers]
    if answer == "NOTHING_MISSING":
        parts.append("nothing is missing beyond noise and small disturbances")
    if findings and gate.best is not None and not gate.passed:
        parts.append(f"but {_risen(gate.worse[0]) if gate.worse else _failed(gate.best)}")
    if provisional or (answer == "CANNOT_TELL" and not findings and not interrupted):
        tested = ", so that no finding can be tested" if findings else ""
        pieces = f"{SETTINGS.fewest_pieces} independent pieces of a second (some 15 s)"
        parts.append(f"too little data: fewer than {pieces}{tested}")
    if interrupted:
        parts.append(f"{interrupted} was interrupted before it ended")
    sentence = "; ".join(parts)
    return sentence[:1].upper() + sentence[1:] + "."


def _failed(best: Fall) -> str:
    small = "falls by only {:.0f} %, too small to matter for predictions beside noise and disturbances"
    changed = small.format(100 * best.part) if best.part >= 0 else f"rises by {-100 * best.part:.0f} %"
    return (
        f"no held-out error falls by {100 * SETTINGS.error_fall:.0f} %: "
        f"that of {best.channel} after {best.horizon:g} s {changed}"
    )


def _risen(worst: Fall) -> str:
    return f"the held-out error of {worst.channel} after {worst.horizon:g} s rises by {-100 * worst.part:.0f} %"


def _one(finding: Finding) -> str:
    values = ", ".join(f"{name} {estimate.said}" for name, estimate in finding.parameters.items())
    others = [key for key in finding.group if key != finding.effect]
    return f"{finding.effect} ({values})" + (f", or {' or '.join(others[:3])}" if others else "")


def fall_of_error(stages: Sequence[Stage]) -> tuple[str, float, float] | None:
    """Channel, first and last error at the horizon that is judged of the channel that falls most."""
    if len(stages) < 2 or not stages[0].horizons or not any(stage.foretells for stage in stages):
        return None
    horizon = stages[0].nearest(JUDGED_AT)
    first, last = stages[0].horizons[horizon], stages[-1].horizons[horizon]
    channels = judged(first)
    best = min(channels, key=lambda channel: last[channel].value / max(first[channel].value, 1e-12))
    return f"{best} ({horizon:g} s)", first[best].value, last[best].value
