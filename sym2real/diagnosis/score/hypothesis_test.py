"""What logs say of one effect, or of several together, and of others in their place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sym2real.diagnosis.errors.floor import Floor
from sym2real.diagnosis.errors.rungs import Rung
from sym2real.diagnosis.faults.fault import Fault
from sym2real.diagnosis.score.finding import Finding, applied
from sym2real.json_objects import fields_of
from sym2real.symbolic import Equations
from sym2real.upward import upward

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Alternative:
    """Another effect in the hypothesis's place.

    Args:
        effect: its key.
        gain: relative fall of the held-out whitened loss.
        as_good: the data cannot tell the two apart.
        instead_of: the effect in whose place it was fitted, beside the others.
        better: it surely does more.
    """

    effect: str
    gain: float
    as_good: bool
    instead_of: str
    better: bool = False


@dataclass(frozen=True)
class HypothesisTest:
    """What logs say of one effect, or of several that are one hypothesis.

    Args:
        findings: the effects with fitted values, intervals and what the data cannot tell them from.
        supported: a search would announce each: its held-out gain beside the others is large enough, larger than chance
            would make it, and predictions need it, or whole logs establish it.
        gain: relative fall of the held-out whitened loss by all of them.
        beside: the same of each beside the others, by effect.
        refused: those that are not supported.
        unneeded: those of them that are beyond chance, but that predictions do not need.
        outdone: those in whose place another effect does more, and leaves them nothing to do beside it.
        rivals: other effects in the place of each, the best first.
        faults: of the data, undone before the fit.
        ladder, floor, held_out, apart, notes, seconds: as of :class:`~sym2real.diagnosis.Diagnosis`.
    """

    findings: tuple[Finding, ...]
    supported: bool
    gain: float
    beside: Mapping[str, float]
    refused: tuple[str, ...]
    unneeded: tuple[str, ...]
    outdone: tuple[str, ...]
    rivals: tuple[Alternative, ...]
    faults: tuple[Fault, ...]
    ladder: tuple[Rung, ...]
    floor: tuple[Floor, ...]
    held_out: tuple[str, ...]
    apart: bool
    notes: tuple[str, ...]
    seconds: float

    def __repr__(self) -> str:
        return f"<HypothesisTest: {self.summary}>"

    def plot(self) -> Figure:
        """Held-out error over the horizon, one effect after the other: a figure of matplotlib."""
        return upward("ladder_plot")(self)

    def _repr_html_(self) -> str:
        return str(upward("hypothesis_html")(self))

    @property
    def finding(self) -> Finding:
        """The effect; of several the one that predictions need most."""
        return self.findings[0]

    @property
    def summary(self) -> str:
        """One or two sentences a person reads."""
        return str(upward("hypothesis_summary")(self))

    def apply(self, equations: Equations) -> Equations:
        """The equations with the effects at their fitted values."""
        return applied(equations, self.findings)

    def to_dict(self) -> dict[str, Any]:
        """The object that ``sym2real add --fit … --json`` prints."""
        single = {"finding": self.finding.to_dict()} if len(self.findings) == 1 else {}
        return {"summary": self.summary, **single, **fields_of(self, without=("apart",))}
