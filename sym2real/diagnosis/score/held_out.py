"""Base and findings on data that took no part in their fit: the ladder, and the gate that predictions must pass.

An effect can be beyond chance and change nothing that a user sees. So what was found must lower the error of free runs
(2 s, a car 5 s) by a tenth, in position or in attitude, on logs that were kept aside or that each fit left out; or that
of predictions as long as a controller's (0.8 s), because small disturbances decide where a car is after 5 s: a heading
measured 2° off takes half off the one error and 9.6 % off the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.windows import judged
from sym2real.diagnosis.errors.rungs import HeldOut, Rung
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.score.importance import by_importance
from sym2real.diagnosis.search.needed import judged_horizons, left_out, left_out_sets
from sym2real.diagnosis.search.select import Selection, parameter_set
from sym2real.diagnosis.settings import SETTINGS
from sym2real.json_objects import fields_of, plain
from sym2real.logs.noise import SMALLEST_NOISE


@dataclass(frozen=True)
class Fall:
    """How much of an error goes: after so many s, in a channel, what part of it, and whether beyond chance."""

    horizon: float
    channel: str
    part: float
    surely: bool = True

    @property
    def text(self) -> str:
        """Which error it is and what becomes of it, for a sentence that begins with "the held-out error" or "that"."""
        changed = f"{'falls' if self.part >= 0 else 'rises'} by {100 * abs(self.part):.0f} %"
        chance = "" if self.surely or abs(self.part) < SETTINGS.worth_saying else ", within chance"
        return f"of {self.channel} after {self.horizon:.3g} s {changed}{chance}"


@dataclass(frozen=True)
class Gate:
    """Held-out errors over a controller's horizon and over a free run.

    Args:
        before, after: of the base, and with all findings; None where there are none, or no log is long enough.
    """

    before: Rung | None = None
    after: Rung | None = None

    @property
    def best(self) -> Fall | None:
        """The error of position or attitude that falls most, first beyond chance; None where nothing was judged."""
        return max(self._falls(), key=lambda fall: (fall.surely and fall.part > 0, fall.part), default=None)

    @property
    def worse(self) -> tuple[Fall, ...]:
        """Errors of position or attitude that rise beyond chance, the largest rise first.

        That is beyond both intervals, or by a tenth beyond that of the ratio. The interval of a single piece has no
        width: there a rise counts from a tenth on, as a fall does. What is worse than if nothing changed by both models
        does not count: a pole that falls.
        """
        rises = (fall for fall in self._falls() if fall.surely and fall.part < 0)
        return tuple(sorted(rises, key=lambda fall: fall.part))

    @property
    def fallen(self) -> bool:
        """Whether a tenth of an error goes, beyond chance, and none rises so."""
        return not self.worse and any(fall.surely and fall.part >= SETTINGS.worth_saying for fall in self._falls())

    @property
    def falling(self) -> set[str]:
        """Channels of which an error falls beyond chance."""
        return {fall.channel for fall in self._falls() if fall.surely and fall.part > 0}

    @property
    def passed(self) -> bool:
        """Whether errors fall; also where nothing can be predicted, and where nothing was judged."""
        return self.fallen or self.best is None or not self.beats_hold

    @property
    def beats_hold(self) -> bool:
        """Whether one of both predicts better than that nothing changes; else errors tell what noise grows to."""
        return any(stage is not None and stage.beats_hold for stage in (self.before, self.after))

    def _falls(self) -> Iterator[Fall]:
        """Every judged error's."""
        if self.before is None or self.after is None:
            return
        for horizon, errors in self.before.horizons.items():
            # Of these errors both models only tell what noise grows to.
            lost = {*self.before.worse.get(horizon, ())} & {*self.after.worse.get(horizon, ())}
            for name in judged(errors):
                error, after = errors[name], self.after.horizons[horizon][name]
                if max(error.value, after.value) <= SMALLEST_NOISE:  # it stands still
                    continue
                part, (low, high) = 1.0 - after.value / max(error.value, 1e-12), after.ratio_to(error)
                apart = error.low < error.high and after.low > error.high
                rises = low > 1.0 and name not in lost and (apart or part <= -SETTINGS.worth_saying)
                yield Fall(horizon, name, part, surely=rises or high < 1.0)

    def to_dict(self) -> dict[str, Any] | None:
        """The entry of ``gate`` that ``sym2real diagnose --json`` prints; None where nothing was judged."""
        if self.before is None or self.after is None or self.best is None:
            return None
        errors = {"before": self.before.to_dict()["horizons"], "after": self.after.to_dict()["horizons"]}
        changes = {"best": fields_of(self.best), "worse": plain(self.worse)}
        return {"passed": self.passed, "beats_hold": self.beats_hold, **changes, **errors}


@dataclass(frozen=True, eq=False)
class LadderModels:
    """The models of a ladder.

    Args:
        held: the logs that are scored.
        models: the base, then each with one effect more: name, and a parameter set per fold ``# (folds, P)``.
    """

    held: HeldOut
    models: Sequence[tuple[str, Tensor]]

    @classmethod
    def of(cls, library: Library, logs: Dataset, selection: Selection, *, same: bool) -> LadderModels:
        """Base and first k findings.

        Args:
            library: effects in the equations that predict.
            logs: that are scored.
            selection: what was found.
            same: the logs that are scored are those of the fit: each by parameters that it took no part in; the last
                third of a single log by those of the rest.
        """
        models, done = [("base", library.null[None])], list[Candidate]()
        for candidate, fit in by_importance(selection):
            done.append(candidate)
            sets = left_out_sets(selection, done, fit) if same else parameter_set(selection, done, fit.values)[None]
            models.append((f"+ {candidate.name}", sets))
        return cls(left_out(selection, library, logs) if same else HeldOut(library, logs), models)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the logs that are scored."""
        return tuple(f"{log.name} (last third)" if self.held.after else log.name for log in self.held.logs)

    def gate(self) -> Gate:
        """Errors of the first and the last model over a controller's horizon and over a free run."""
        ends = [self.models[0], self.models[-1]] if len(self.models) > 1 else []
        return Gate(*self.held.ladder(ends, judged_horizons(self.held)))
