"""The answer in one word and one sentence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from sym2real.diagnosis.findings import Finding
from sym2real.diagnosis.fit import Problems
from sym2real.diagnosis.ladder import Stage
from sym2real.diagnosis.leftover import Leftover
from sym2real.diagnosis.sanity import Fault
from sym2real.diagnosis.significance import FEWEST_BLOCKS

Verdict = Literal["EFFECT", "NOTHING_MISSING", "UNEXPLAINED", "CANNOT_TELL"]

# Horizon (s) at which held-out errors are judged, and the rise that shows a finding to be spurious.
GATE_HORIZON = 0.8
WORSE = 0.02


def verdict(
    faults: Sequence[Fault], found: Sequence[Finding], leftover: Leftover | None, problems: Problems
) -> Verdict:
    """Which of the four answers the parts make."""
    if found or faults:
        return "EFFECT"
    if leftover is not None:
        return "UNEXPLAINED"
    return "NOTHING_MISSING" if problems.block_count >= FEWEST_BLOCKS else "CANNOT_TELL"


def summary(
    answer: Verdict,
    faults: Sequence[Fault],
    found: Sequence[Finding],
    leftover: Leftover | None,
    stages: Sequence[Stage],
) -> str:
    """One sentence a person reads."""
    parts = []
    if faults:
        parts.append("the data show " + ", ".join(fault.effect for fault in faults))
    if found:
        parts.append("missing: " + "; ".join(_one(finding) for finding in found))
        fall = fall_of_error(stages)
        if fall is not None:
            parts.append(f"with it the {fall[0]} error on held-out pieces changes from {fall[1]:.3g} to {fall[2]:.3g}")
    if leftover is not None:
        parts.append(f"{leftover.statement} is left (R² {leftover.r2:.2f})")
    if answer == "NOTHING_MISSING":
        parts.append("nothing is missing beyond noise and small disturbances")
    if answer == "CANNOT_TELL":
        parts.append(f"too little data: fewer than {FEWEST_BLOCKS} independent pieces of a second")
    sentence = "; ".join(parts)
    return sentence[:1].upper() + sentence[1:] + "."


def _one(finding: Finding) -> str:
    values = ", ".join(
        f"{name} {estimate.value:.3g} {estimate.unit}".strip() for name, estimate in finding.parameters.items()
    )
    others = [key for key in finding.group if key != finding.effect]
    return f"{finding.effect} ({values})" + (f", or {' or '.join(others[:3])}" if others else "")


def fall_of_error(stages: Sequence[Stage]) -> tuple[str, float, float] | None:
    """Channel, first and last error at the gate's horizon of the channel that falls most."""
    if len(stages) < 2 or not stages[0].horizons:
        return None
    horizon = min(stages[0].horizons, key=lambda one: abs(one - GATE_HORIZON))
    first, last = stages[0].horizons[horizon], stages[-1].horizons[horizon]
    channels = [channel for channel in first if channel in ("position", "attitude", "yaw")]
    best = min(channels, key=lambda channel: last[channel].value / max(first[channel].value, 1e-12))
    return f"{best} ({horizon:g} s)", first[best].value, last[best].value


def makes_worse(stages: Sequence[Stage]) -> bool:
    """Whether the second of two stages predicts neither position nor attitude better, and one of them worse."""
    if len(stages) < 2 or not stages[0].horizons:
        return False
    horizon = min(stages[0].horizons, key=lambda one: abs(one - GATE_HORIZON))
    before, after = stages[0].horizons[horizon], stages[1].horizons[horizon]
    changes = [after[c].value / max(before[c].value, 1e-12) for c in before if c in ("position", "attitude", "yaw")]
    return min(changes) > 1.0 and max(changes) > 1.0 + WORSE
