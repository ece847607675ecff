"""What logs say of one effect, or of several together, and of others in their place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sym2real.diagnosis.errors.floor import Floor
from sym2real.diagnosis.errors.rungs import Rung
from sym2real.diagnosis.faults.fault import Fault
from sym2real.diagnosis.score.finding import Finding, applied
from sym2real.diagnosis.settings import SETTINGS
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
        figure: Figure = upward("ladder_plot")(self)
        return figure

    def _repr_html_(self) -> str:
        return str(upward("hypothesis_html")(self))

    @property
    def finding(self) -> Finding:
        """The effect; of several the one that predictions need most."""
        return self.findings[0]

    @property
    def summary(self) -> str:
        """One or two sentences a person reads."""
        names = " and ".join(finding.effect for finding in self.findings)
        lowered = f"{'it lowers' if len(self.findings) == 1 else 'together they lower'} the held-out loss by"
        undone = [fault.name for fault in self.faults if fault.effect in self.refused]
        rest = f", once the fault of the logs is undone ({', '.join(undone)})" if undone else ""
        sentence = f"{names}: {lowered} {_percent(self.gain)}{rest}"
        if self.unneeded and set(self.refused) == set(self.unneeded):
            small = f"predictions do not need {' or '.join(self.unneeded)}"
            return f"The logs show {sentence}, but {small}, and whole logs do not establish it{self._better}."
        if self.outdone:
            return f"The logs do not ask for {sentence}{self._better}, and leaves too little for it."
        if not self.supported:
            most = SETTINGS.gain_of(len(self.findings))
            if min(self.beside[key] for key in self.refused if key not in self.unneeded) > most:
                few = "too few independent pieces of these logs tell of it"
                why = f"but {few}, or its fit ends where no value is likely"
                return f"The logs do not establish {sentence}, {why}{self._refused}{self._better}."
            return f"The logs do not ask for {sentence}; up to {_percent(most)} is needed{self._refused}{self._better}."
        return f"The logs ask for {sentence}{self._better or self._others}."

    @property
    def _refused(self) -> str:
        """Of several, how much those that are not supported take."""
        several = self.refused if len(self.findings) > 1 else ()
        return "".join(f"; {key} lowers what the others leave by {_percent(self.beside[key])}" for key in several)

    @property
    def _better(self) -> str:
        """What does more in the place of one."""
        groups = {finding.effect: finding.group for finding in self.findings}
        for other in sorted(self.rivals, key=lambda other: other.instead_of not in self.outdone):
            more = other.gain > self.beside[other.instead_of] + SETTINGS.gain
            if other.better or (more and other.effect not in groups[other.instead_of]):
                place = "its place" if len(self.findings) == 1 else f"the place of {other.instead_of}"
                return f"; {other.effect} in {place} lowers it by {_percent(other.gain)}"
        return ""

    @property
    def _others(self) -> str:
        """What does as well as one."""
        if any(finding.doubtful for finding in self.findings):
            return "; commands that change between the rows of the logs do as well"
        if len(self.findings) == 1:
            return f"; {' or '.join(self.finding.alternatives[:3]) or 'no other effect'} does as well"
        alike = {finding.effect: finding.alternatives[:3] for finding in self.findings}
        clauses = [f"{' or '.join(group)} does as well as {key}" for key, group in alike.items() if group]
        return f"; {'; '.join(clauses) or 'no other effect does as well as one of them'}"

    def apply(self, equations: Equations) -> Equations:
        """The equations with the effects at their fitted values."""
        return applied(equations, self.findings)

    def to_dict(self) -> dict[str, Any]:
        """The object that ``sym2real add --fit … --json`` prints."""
        single = {"finding": self.finding.to_dict()} if len(self.findings) == 1 else {}
        return {"summary": self.summary, **single, **fields_of(self, without=("apart",))}


def _percent(part: float) -> str:
    return f"{100 * part:.3g} %"
