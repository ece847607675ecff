"""Base and findings on data that took no part in their fit: the ladder, and the gate that predictions must pass.

An effect can be beyond chance and change nothing that a user sees. So what was found must lower the error of free runs
(2 s, a car 5 s) by a tenth, in position or in attitude, on logs that were kept aside or that each fit left out; or that
of predictions as long as a controller's (0.8 s), because small disturbances decide where a car is after 5 s: a heading
measured 2° off takes half off the one error and 9.6 % off the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.diagnosis.data.windows import JUDGED, free_run_seconds
from sym2real.diagnosis.errors.rungs import Stage, horizons_for, ladder
from sym2real.diagnosis.estimate.fit import Fit
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.score.importance import by_importance
from sym2real.diagnosis.search.deviations import parameter_set
from sym2real.diagnosis.search.select import Selection
from sym2real.trajectory import Dataset

# Part of the error of a judged channel that must go; and the horizon (s) and the rise of a shorter prediction's error
# that show a finding to be spurious where no other error falls by as much.
LEAST_FALL = 0.10
JUDGED_AT, WORSE = 0.8, 0.02
# Where the part of a single log begins that the ladder is scored on.
LAST_THIRD = 2 / 3


@dataclass(frozen=True)
class Fall:
    """How much of an error goes: after so many s, in a channel, what part of it."""

    horizon: float
    channel: str
    part: float


@dataclass(frozen=True)
class Gate:
    """Held-out errors over a controller's horizon and over a free run.

    Args:
        before, after: of the base, and with all findings; None where there are none, or no log is long enough.
    """

    before: Stage | None = None
    after: Stage | None = None

    @property
    def best(self) -> Fall | None:
        """The error of position or attitude that falls most; None where nothing was judged."""
        if self.before is None or self.after is None:
            return None
        falls = [
            Fall(horizon, name, 1.0 - self.after.horizons[horizon][name].value / max(error.value, 1e-12))
            for horizon, errors in self.before.horizons.items()
            for name, error in errors.items()
            if name in JUDGED
        ]
        return max(falls, key=lambda one: one.part, default=None)

    @property
    def passed(self) -> bool:
        """Whether a tenth of an error goes; also where no log is long enough to say."""
        return self.best is None or self.best.part >= LEAST_FALL

    def to_dict(self) -> dict[str, Any] | None:
        """The entry of ``gate`` that ``sym2real diagnose --json`` prints; None where nothing was judged."""
        if self.before is None or self.after is None or self.best is None:
            return None
        return {
            "passed": self.passed,
            "best": asdict(self.best),
            "before": self.before.to_dict()["horizons"],
            "after": self.after.to_dict()["horizons"],
        }


@dataclass(frozen=True, eq=False)
class Steps:
    """The models of a ladder.

    Args:
        names: base, then what is added.
        sets: of each, a parameter set per fold ``# (folds, P)``.
        fold_of: fold of each log; None for one fold.
        last: the last effect added; None for the base alone.
        after: part of every log behind which predictions start, because the fit ends there.
    """

    names: tuple[str, ...]
    sets: tuple[Tensor, ...]
    fold_of: NDArray[np.int64] | None
    last: Candidate | None
    after: float

    @classmethod
    def of(cls, library: Library, selection: Selection, *, same: bool) -> Steps:
        """Base and first k findings.

        Args:
            library: effects in the equations that predict.
            selection: what was found.
            same: the logs that are scored are those of the fit: each by parameters that it took no part in; the last
                third of a single log by those of the rest.
        """
        names, sets, done = ["base"], [library.null[None]], list[Candidate]()
        alone = same and selection.problems.log_count == 1
        for one, fit in by_importance(selection):
            done.append(one)
            if same:
                steps = [_step_before_the_last_third(selection, fit)] if alone else _fold_steps(selection, fit)
            else:
                steps = [torch.zeros(len(fit.whole), dtype=torch.float64)]
            found = [parameter_set(selection, done, selection.problems.moved(fit, step)) for step in steps]
            names.append(f"+ {one.name}")
            sets.append(torch.stack(found))
        fold_of = _fold_of_log(selection) if same and not alone else None
        last = done[-1] if done else None
        return cls(tuple(names), tuple(sets), fold_of, last, LAST_THIRD if alone else 0.0)

    def horizons(self, data: Dataset, longest: float | None) -> tuple[float, ...]:
        """Horizons (s) that the scored part of the logs is long enough for."""
        return horizons_for(data, longest, self.after)

    def names_of(self, data: Dataset) -> tuple[str, ...]:
        """Of the logs that are scored."""
        return tuple(f"{log.name} (last third)" if self.after else log.name for log in data)

    def ladder(self, library: Library, data: Dataset, horizons: Sequence[float]) -> tuple[Stage, ...]:
        """Errors of every model at horizons (s)."""
        stages = list(zip(self.names, self.sets, strict=True))
        return tuple(ladder(library, data, stages, self.fold_of, horizons=horizons, after=self.after))

    def gate(self, library: Library, data: Dataset) -> Gate:
        """Errors of the first and the last model over a controller's horizon and over a free run."""
        wanted = self.horizons(data, free_run_seconds(data.layouts.state))
        if not wanted or self.last is None:
            return Gate()
        judged = sorted({min(wanted, key=lambda one: abs(one - JUDGED_AT)), wanted[-1]})
        pairs = [(self.names[place], self.sets[place]) for place in (0, -1)]
        return Gate(*ladder(library, data, pairs, self.fold_of, horizons=judged, after=self.after))


def without_harm(
    library: Library, selection: Selection, data: Dataset, longest: float | None, *, same: bool
) -> tuple[Steps, tuple[Stage, ...]]:
    """The steps and their ladder, once every finding at their end that makes held-out predictions worse is dropped."""
    while True:
        steps = Steps.of(library, selection, same=same)
        stages = steps.ladder(library, data, steps.horizons(data, longest))
        if steps.last is None or not makes_worse(stages[-2:]):
            return steps, stages
        selection.put(*selection.without(steps.last))


def makes_worse(stages: Sequence[Stage]) -> bool:
    """Whether the second of two stages predicts position or attitude worse, and neither of them better by as much."""
    if len(stages) < 2 or not stages[0].horizons:
        return False
    horizon = stages[0].nearest(JUDGED_AT)
    before, after = stages[0].horizons[horizon], stages[1].horizons[horizon]
    changes = [after[c].value / max(before[c].value, 1e-12) for c in before if c in JUDGED]
    return min(changes) > 1.0 - WORSE and max(changes) > 1.0 + WORSE


def _fold_of_log(selection: Selection) -> NDArray[np.int64]:
    """Fold of every log: its place among those that have segments; a log without any has that of the one before it."""
    problem = selection.problems.problem
    places = np.searchsorted(np.unique(problem.segments.log), np.arange(len(problem.data)), side="right") - 1
    return np.maximum(places, 0)


def _fold_steps(selection: Selection, fit: Fit) -> list[Tensor]:
    """Per log, the step from the fit of all logs to that of the others."""
    log = torch.as_tensor(selection.problems.problem.segments.log)
    return [selection.problems.best_step(fit.of_segments(log != index)) for index in log.unique()]


def _step_before_the_last_third(selection: Selection, fit: Fit) -> Tensor:
    """The step from the fit of a whole log to that of its first two thirds."""
    segments, (log,) = selection.problems.problem.segments, selection.problems.problem.data
    inside = torch.as_tensor(segments.row + segments.length <= LAST_THIRD * len(log))
    if not inside.any():
        return torch.zeros(len(fit.whole), dtype=torch.float64)
    return selection.problems.best_step(fit.of_segments(inside))
