"""What logs say of one effect, and of others in its place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sym2real.diagnosis.errors.floor import Floor
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.diagnosis.faults.sanity import Fault
from sym2real.diagnosis.score.finding import Finding, applied
from sym2real.diagnosis.search.select import GAIN
from sym2real.symbolic import Equations

# A rival is the better answer where its gain is larger by this.
BETTER = 0.01


@dataclass(frozen=True)
class Rival:
    """Another effect in the hypothesis's place.

    Args:
        effect: its key.
        gain: relative fall of the held-out whitened loss.
        as_good: the data cannot tell the two apart.
    """

    effect: str
    gain: float
    as_good: bool

    def to_dict(self) -> dict[str, Any]:
        """An entry of ``rivals`` in what ``sym2real add --fit … --json`` prints."""
        return dict(vars(self))


@dataclass(frozen=True)
class Tried:
    """What logs say of one effect.

    Args:
        finding: the effect with fitted values, intervals and what the data cannot tell it from.
        supported: its held-out gain is large enough, and larger than chance would make it.
        gain: relative fall of the held-out whitened loss.
        rivals: other effects in its place, the best first.
        faults: of the data, undone before the fit.
        ladder, floor, held_out, apart, notes, seconds: as of :class:`~sym2real.diagnosis.Diagnosis`.
    """

    finding: Finding
    supported: bool
    gain: float
    rivals: tuple[Rival, ...]
    faults: tuple[Fault, ...]
    ladder: tuple[Stage, ...]
    floor: tuple[Floor, ...]
    held_out: tuple[str, ...]
    apart: bool
    notes: tuple[str, ...]
    seconds: float

    @property
    def summary(self) -> str:
        """One sentence a person reads."""
        name, gain = self.finding.effect, _percent(self.gain)
        group = [key for key in self.finding.group if key != name]
        better = [one for one in self.rivals if one.gain > self.gain + BETTER and one.effect not in group]
        instead = f"; {better[0].effect} in its place lowers it by {_percent(better[0].gain)}" if better else ""
        if not self.supported:
            needed = f"{_percent(GAIN)} and more than chance are needed"
            return f"The logs do not ask for {name}: it lowers the held-out loss by {gain}, {needed}{instead}."
        others = "" if better else f"; {' or '.join(group[:3]) or 'no other effect'} does as well"
        return f"The logs ask for {name}: it lowers the held-out loss by {gain}{instead or others}."

    def apply(self, equations: Equations) -> Equations:
        """The equations with the effect at its fitted values."""
        return applied(equations, [self.finding])

    def to_dict(self) -> dict[str, Any]:
        """The object that ``sym2real add --fit … --json`` prints."""
        return {
            "summary": self.summary,
            "finding": self.finding.to_dict(),
            "supported": self.supported,
            "gain": self.gain,
            "rivals": [rival.to_dict() for rival in self.rivals],
            "faults": [fault.to_dict() for fault in self.faults],
            "ladder": [stage.to_dict() for stage in self.ladder],
            "floor": [one.to_dict() for one in self.floor],
            "held_out": list(self.held_out),
            "notes": list(self.notes),
            "seconds": self.seconds,
        }


def _percent(part: float) -> str:
    return f"{100 * part:.0f} %"
