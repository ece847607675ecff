"""A physical effect into equations: at values that are known, or as a hypothesis that logs confirm or refuse.

add(base, "added_mass", {"value": 0.005})            "I taped 5 g on it"
add(base, "added_mass", fit=logs)                    how much is it?
try_effect(base, "added_mass", logs)                is it there at all, and what else explains the logs as well?
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from sym2real.diagnosis.calibrate import Calibration
from sym2real.diagnosis.candidates import Candidate, candidates
from sym2real.diagnosis.findings import Finding, findings
from sym2real.diagnosis.floor import Floor, floor_of_explained
from sym2real.diagnosis.groups import always_alike, as_good
from sym2real.diagnosis.held_out import Steps
from sym2real.diagnosis.ladder import Stage
from sym2real.diagnosis.library import Library
from sym2real.diagnosis.sanity import Fault
from sym2real.diagnosis.select import GAIN, Selection
from sym2real.diagnosis.separation import with_advice
from sym2real.diagnosis.significance import FEWEST_BLOCKS
from sym2real.diagnosis.weighing import OnProgress, check_and_filter, weigh
from sym2real.effects import Effect, compose, effect
from sym2real.errors import ModelError
from sym2real.plants import MujocoPlant
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset, Trajectory

Values = Mapping[str, float]
# A rival is worth a line from this part of the hypothesis's gain on, and the better answer where it gains more by this.
WORTH_A_LINE, BETTER = 0.5, 0.01
MOST_RIVALS = 5


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
        ladder, floor, held_out, notes, seconds: as of :class:`~sym2real.diagnosis.Diagnosis`.
    """

    finding: Finding
    supported: bool
    gain: float
    rivals: tuple[Rival, ...]
    faults: tuple[Fault, ...]
    ladder: tuple[Stage, ...]
    floor: tuple[Floor, ...]
    held_out: tuple[str, ...]
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
        return add(self.finding.bound(equations), self.finding.effect, self.finding.values)

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


def add(
    equations: Equations,
    what: str | Iterable[tuple[str, Values]],
    values: Values | None = None,
    *,
    fit: Dataset | Trajectory | None = None,
    plant: MujocoPlant | None = None,
) -> Equations:
    """The equations with an effect in them, or with several, which go in together in the order that physics allows.

    Args:
        equations: the base.
        what: key of an effect, or keys with their values.
        values: by parameter name, in SI units; what is not given stays at its null value.
        fit: logs that the values are fitted to instead; :func:`try_effect` says whether they ask for the effect.
        plant: the plain simulator that calibrates the base before a fit.

    Raises:
        UnknownNameError: for an effect or a parameter that does not exist.
        ModelError: when an effect does not apply, with the reason; when values are given and to be fitted.
    """
    if fit is not None:
        if values is not None or not isinstance(what, str):
            raise ModelError("expected values or logs to fit them to, found both")
        return try_effect(equations, what, fit, plant).apply(equations)
    chosen = [(what, values or {})] if isinstance(what, str) else what
    return compose(equations, [(effect(key, equations), given) for key, given in chosen])


def try_effect(
    equations: Equations,
    key: str,
    data: Dataset | Trajectory,
    plant: MujocoPlant | None = None,
    *,
    held_out: Dataset | None = None,
    exclude: Collection[str] = (),
    horizon: float | None = None,
    on_progress: OnProgress = lambda _: None,
) -> Tried:
    """Fit one effect to logs, alone, and hold it against every other effect in its place.

    Args:
        equations: the base.
        key: of the effect.
        data, plant, held_out, exclude, horizon, on_progress: as of :func:`~sym2real.diagnosis.diagnose`.

    Raises:
        UnknownNameError: for an effect that does not exist.
        ModelError: for an effect that does not apply, or whose parameters motion does not show.
        ShapeError: when no log is long enough, or columns differ.
    """
    started = time.perf_counter()
    _check_fittable(effect(key, equations), equations)
    weighed = weigh(equations, data, plant, exclude=exclude, include=(key,), on_progress=on_progress)
    own = _candidate(key, weighed.library, weighed.checked.data)
    on_progress(f"fitting {key}")
    selection = Selection(weighed.problems, (own,), weighed.origin)
    (scored,) = selection.ranked([], weighed.origin, [own])
    gain = selection.gain(scored)
    supported = gain > GAIN and selection.significant(scored.fit, own)
    selection.put([own], scored.fit)
    on_progress("trying other effects in its place")
    rivals = _rivals(selection, [one for one in weighed.tried if key not in one.keys])
    on_progress("scoring on held-out data")
    scored_logs = weighed.checked.data if held_out is None else check_and_filter(equations, held_out).data
    steps = Steps.of(weighed.library, selection, same=held_out is None)
    horizons = steps.horizons(scored_logs, horizon)
    finding = _finding(selection, rivals if supported else (), weighed.calibration)
    return Tried(
        finding=with_advice([finding], weighed.model, weighed.whitening, plant)[0],
        supported=supported,
        gain=gain,
        rivals=tuple(rival for rival in rivals if rival.gain > max(GAIN, WORTH_A_LINE * gain))[:MOST_RIVALS],
        faults=weighed.checked.faults,
        ladder=steps.ladder(weighed.library, scored_logs, horizons),
        floor=floor_of_explained(weighed.library, scored_logs, selection.fit.values, weighed.whitening, horizons),
        held_out=steps.names_of(scored_logs),
        notes=weighed.notes,
        seconds=time.perf_counter() - started,
    )


def _check_fittable(wanted: Effect, equations: Equations) -> None:
    reason = wanted.why_not(equations)
    if reason:
        raise ModelError(reason)
    # What is a choice (which rotor) or differs from log to log (a phase) has no derivative that a fit could follow.
    cannot = [one.name for one in wanted.parameters if one.per_log or (not one.fitted and one.null != 0.0)]
    if cannot:
        raise ModelError(f"{wanted.key}: expected values, found logs; its {', '.join(cannot)} cannot be fitted")


def _candidate(key: str, library: Library, data: Dataset) -> Candidate:
    """The effect as a hypothesis: as it competes, or with all its parameters where it would compete as one of two."""
    for one in candidates(library, data):
        if one.keys == (key,):
            return one
    return Candidate(key, (key,), tuple((slot,) for slot in library.indices(key)))


def _rivals(selection: Selection, others: list[Candidate]) -> tuple[Rival, ...]:
    """What brings how much in the place of the only effect chosen, the best first."""
    (own,) = selection.chosen
    rest, fit = selection.without(own)
    without = selection.problems.held_out(fit)
    gain = float((without - selection.held_out).sum())
    found = []
    for scored in selection.ranked(rest, fit.values, others):
        share = float((without - scored.held_out).sum()) / max(gain, 1e-12)
        alike = gain > 0.0 and as_good(share, scored.held_out - selection.held_out, selection.loss)
        found.append(
            Rival(
                selection.problems.problem.library.key(scored.candidate.name),
                1.0 - scored.loss / float(without.sum()),
                alike,
            )
        )
    return tuple(found)


def _finding(selection: Selection, rivals: Iterable[Rival], calibration: Calibration | None) -> Finding:
    (own,), problems = selection.chosen, selection.problems
    alike = (rival.effect for rival in rivals if rival.as_good)
    always = always_alike(own.name, problems.problem.library.equations)
    group = tuple(dict.fromkeys([*own.alike, *always, *alike]))
    provisional = problems.block_count < FEWEST_BLOCKS
    (found,) = findings(selection, {own.name: group}, problems.whitening.freedom, provisional, calibration)
    return found
