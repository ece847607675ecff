"""Values that predict best: found effects fitted once more, open loop, as a controller or a simulation uses a model.

The search's fit is of likelihood: short pieces whose starts are free, and disturbances that no model foresees. Its
values are those of physics as far as the effects have the right form; where they have not, others predict better. Here
predictions start from estimated states and run to the horizon (simulation error: L. Ljung, System Identification, 2nd
ed., section 7.2). What is made small is the mean, over logs, of::

    mean over windows of ‖e‖  /  mean over windows of ‖e‖ when nothing changes

‖e‖ is the root mean square over a window's rows and judged channels, each in units of what it changes by. So kinds of
motion have equal weights, and no few windows decide. The weights of least squares are 1/‖e‖, anew in every round (P.
Holland, R. Welsch, "Robust regression using iteratively reweighted least-squares", Comm. Stat. A6, 1977).

The values are kept where logs that the refit left out are surely predicted better by a hundredth, and no channel
surely worse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import Segments, compared_fields
from sym2real.diagnosis.data.windows import JUDGED_AT, channel_name, judged
from sym2real.diagnosis.errors.rungs import Rung, windows_of
from sym2real.diagnosis.estimate.fit import Fit, Hypothesis, Problems
from sym2real.diagnosis.estimate.whitening import Whitening
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.score.finding import Finding, Scored
from sym2real.diagnosis.score.importance import by_importance
from sym2real.diagnosis.search.needed import by_others, left_out, left_out_sets, no_worse, parts_of_others
from sym2real.diagnosis.search.select import parameter_set
from sym2real.diagnosis.settings import SETTINGS
from sym2real.trajectory import Array

ROUNDS, MOST_WINDOWS, MOST_STARTS = 3, 1500, 3


@dataclass(frozen=True)
class PredictionRefit:
    """The values that predict best, and what they are worth.

    Args:
        horizon: s, up to which predictions were fitted.
        values: of every finding in its place, by parameter; none of one that is in doubt.
        before, after: errors of logs that each fit left out, with the findings' values and with these.
    """

    horizon: float
    values: tuple[dict[str, float], ...]
    before: Rung
    after: Rung

    @property
    def change(self) -> tuple[float, float, float]:
        """Factor by which errors at the horizon change, judged channels as a product, and its 95 % interval."""
        ratio, *drawn = self._size(self.after) - self._size(self.before)
        low, high = np.quantile(drawn, (0.025, 0.975))
        return float(np.exp(ratio)), float(np.exp(low)), float(np.exp(high))

    def _size(self, stage: Rung) -> Array:
        """Logarithm of the errors' product, as they are and as resampled ``# (1 + draws,)``."""
        errors = stage.horizons[self.horizon]
        rows = [[errors[name].value, *errors[name].resampled] for name in judged(errors)]
        return np.asarray(np.log(np.maximum(rows, 1e-12)).mean(axis=0))

    @property
    def kept(self) -> bool:
        """Whether errors of logs that were left out surely fall by a hundredth at the horizon, and none rises so.

        The interval of a single block has no width, and says nothing.
        """
        _, low, high = self.change
        return low < high < 1.0 - SETTINGS.negligible and self.after.beats_hold and no_worse(self.after, self.before)

    def of(self, findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
        """The findings with these values; their intervals are those of the others, and do not hold."""
        return tuple(finding.at(values) for finding, values in zip(findings, self.values, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """The entry of ``prediction`` in docs/method.md, "Answers as files"."""
        errors = {name: getattr(self, name).to_dict()["horizons"] for name in ("before", "after")}
        return {"horizon": self.horizon, "kept": self.kept, "values": list(self.values), **errors}


def refit_for_prediction(scored: Scored) -> PredictionRefit | None:
    """The found effects fitted to free predictions; None where logs are too few or too short, or nothing is sure."""
    prepared, selection = scored.result.prepared, scored.result.selection
    data, ordered = prepared.checked.data, [candidate for candidate, _ in by_importance(selection)]
    sure = [own for own, finding in zip(ordered, scored.findings, strict=True) if not finding.doubtful]
    held = left_out(selection, prepared.library, data)
    horizons = held.horizons(prepared.question.horizon or JUDGED_AT)
    if not (horizons and sure):
        return None
    horizon, start = horizons[-1], parameter_set(selection, sure, selection.fit.values)
    problem = Problem(prepared.library, data, _judged_windows(data, round(horizon / data.dt)))
    if not all(part.any() for part in parts_of_others(selection, problem.segments)):
        return None
    problems, fit = _fitted(problem, [Hypothesis(selection.free(sure), start), *selection.started(sure, start)])
    refitted = torch.stack(by_others(selection, fit, problems))
    stages = [("found", left_out_sets(selection, sure, selection.fit)), ("refitted", refitted)]
    names = [slot.parameter.name for slot in prepared.library.slots]
    values = ({names[slot]: float(fit.values[slot]) for slot in own.free} if own in sure else {} for own in ordered)
    return PredictionRefit(horizon, tuple(values), *held.ladder(stages, (horizon,)))


def _fitted(problem: Problem, starts: Sequence[Hypothesis]) -> tuple[Problems, Fit]:
    """The best fit from the best of several starts, as a delay has a valley at every row, with what weights it."""
    scale = Scale.of(problem.segments)

    def missed(at: Hypothesis | Fit) -> float:
        return scale.mean(problem.residuals(at.values[None])[0])

    def fitted(start: Hypothesis) -> tuple[Problems, Fit]:
        for _ in range(ROUNDS):
            problems = Problems(problem, scale.whitening(problem.residuals(start.values[None])[0]))
            (fit,) = problems.fit([start])
            start = replace(start, values=fit.values)
        return problems, fit

    return min(map(fitted, sorted(starts, key=missed)[:MOST_STARTS]), key=lambda pair: missed(pair[1]))


def _judged_windows(data: Dataset, steps: int) -> Segments:
    """Windows of which the channels are compared that predictions are judged by."""
    fields = {channel_name(field): field.name for field in data.layouts.state.fields}
    return windows_of(data, steps, fields=[fields[name] for name in judged(fields)]).some(MOST_WINDOWS)


@dataclass(frozen=True, eq=False)
class Scale:
    """In what units errors of windows count.

    Args:
        row: of a row's components, one over squares ``# (C,)``.
        window: of every window's log, the sum of norms when nothing changes, at least a tenth of the mean ``# (S,)``.
    """

    row: Tensor
    window: Tensor

    @classmethod
    def of(cls, windows: Segments) -> Scale:
        """By what the judged channels change from the start of windows."""
        layout, columns = compared_fields(windows)
        measured = windows.measured[..., columns]
        change = layout.difference(measured[:, :1].expand_as(measured), measured)
        channel, log = torch.tensor(windows.channel), torch.as_tensor(windows.log)
        squares = change.square().mean((0, 1))
        of_channel = torch.stack([squares[channel == own].sum() for own in channel]).clamp_min(1e-300)
        row = 1.0 / (of_channel * windows.length)
        whole = torch.bincount(log, (change.square() @ row).sum(1).sqrt())[log]
        return cls(row, whole.clamp_min(SETTINGS.worth_saying * float(whole.mean())))

    def mean(self, residuals: Tensor) -> float:
        """Sum over logs of the mean norm of residuals ``# (S, R)`` over that when nothing changes."""
        return float((self._norms(residuals) / self.window).sum())

    def whitening(self, residuals: Tensor) -> Whitening:
        """Weights of least squares that make a mean of norms small, at residuals ``# (S, R)``."""
        norms = self._norms(residuals)
        norms = norms.clamp_min(SETTINGS.worth_saying * float(norms.mean()))
        trust, lost = 1.0 / (norms * self.window), residuals[..., None][..., :0]
        return Whitening(self.row.rsqrt(), {}, self.row.repeat(residuals.shape[1] // len(self.row)), lost, 1, trust)

    def _norms(self, residuals: Tensor) -> Tensor:
        return torch.einsum("snc,c->s", residuals.square().unflatten(1, (-1, len(self.row))), self.row).sqrt()
