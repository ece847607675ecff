"""Prediction errors on held-out logs: the base, then one effect after the other."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from math import ceil
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.preparation import without_stops
from sym2real.diagnosis.data.segments import WARM_UP, Segments, number_in_log, segments_at
from sym2real.diagnosis.data.start import ROWS
from sym2real.diagnosis.data.windows import channel_units, finite_errors, horizons_in_rows, judged, stride_of
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.json_objects import fields_of, plain
from sym2real.logs.resample import BRIDGED
from sym2real.trajectory import Array

RESAMPLES = 200
# Windows of a block of the bootstrap, of longer windows as many as one is long.
SHORTEST_BLOCK = 10


@dataclass(frozen=True)
class RungError:
    """Root mean square and mean of a channel's error norm over windows, with a 95 % interval over logs' blocks.

    Errors of the same windows are resampled alike ``# (draws,)``, so that two models can be held against each other.
    """

    value: float
    mean: float
    low: float
    high: float
    unit: str
    resampled: Array = field(default_factory=lambda: np.empty(0), repr=False, compare=False)

    def ratio_to(self, other: RungError) -> tuple[float, float]:
        """Ends of the 95 % interval of this error over another one of the same windows."""
        if not len(self.resampled):
            return self.low / max(other.high, 1e-12), self.high / max(other.low, 1e-12)
        ends = np.quantile(self.resampled / np.maximum(other.resampled, 1e-12), [0.025, 0.975])
        return float(ends[0]), float(ends[1])

    def to_dict(self) -> dict[str, Any]:
        """Without what was resampled."""
        return fields_of(self, without=("resampled",))


@dataclass(frozen=True)
class Rung:
    """A model of the ladder: errors by horizon and channel.

    Args:
        model: its name.
        horizons: errors by horizon (s) and channel.
        beats_hold: whether, at some horizon, nothing that is judged is surely worse than if nothing changed.
        worse: at every horizon, the judged channels that are.
    """

    model: str
    horizons: dict[float, dict[str, RungError]]
    beats_hold: bool = True
    worse: dict[float, tuple[str, ...]] = field(default_factory=dict)

    def nearest(self, horizon: float) -> float:
        """The horizon that is nearest to ``horizon`` s.

        Raises:
            ValueError: when there is none.
        """
        return min(self.horizons, key=lambda known: abs(known - horizon))

    def to_dict(self) -> dict[str, Any]:
        """The entry of ``ladder`` in docs/method.md, "Answers as files"."""
        rows = [{"horizon": horizon, "errors": plain(errors)} for horizon, errors in self.horizons.items()]
        return {"model": self.model, "horizons": rows}


def windows_of(data: Dataset, steps: int, after: float = 0.0, fields: Collection[str] = ()) -> Segments:
    """Windows of so many steps that start every 0.1 s from what the rows before them say, of logs that are so long.

    Args:
        data: logs.
        steps: rows from a window's start to its end.
        after: part of every log behind which windows start.
        fields: what is compared; all by default.
    """
    rows = [np.arange(_first_start(len(log), after), len(log) - steps, stride_of(data.dt)) for log in data]
    rows = [without_stops(own, starts, steps + 1) for own, starts in zip(data, rows, strict=True)]
    log, row = np.repeat(np.arange(len(data)), [len(own) for own in rows]), np.concatenate(rows)
    return segments_at(data, log, row, steps + 1, fields)


def _first_start(rows: int, after: float) -> int:
    return max(ROWS - 1 + WARM_UP, round(after * rows))


def cut_notes(horizons: Sequence[float], wanted: float | None) -> tuple[str, ...]:
    """A sentence where the logs do not reach the longest horizon (s) that was wanted."""
    longest = max(horizons, default=0.0)
    if wanted is None or longest > wanted - 1e-9:
        return ()
    return (f"no held-out log is long enough for a horizon of {wanted:g} s: the ladder ends at {longest:g} s",)


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Logs that models are scored on.

    Args:
        library: effects in the base's equations.
        logs: what is predicted.
        fold_of: fold of each log, which is predicted by the fit of the others; None where none took part in the fit.
        after: part of every log behind which windows start, because the fit ends there.
    """

    library: Library
    logs: Dataset
    fold_of: NDArray[np.int64] | None = None
    after: float = 0.0

    def horizons(self, longest: float | None = None) -> tuple[float, ...]:
        """Horizons (s) that the logs are long enough for.

        Args:
            longest: none beyond this many seconds, and this one as well, or what the logs allow.
        """
        dt, rows = self.logs.dt, max(len(log) - 1 - _first_start(len(log), self.after) for log in self.logs)
        last = None if longest is None else min(longest, rows * dt)
        usual = horizons_in_rows(dt)
        wanted = usual if last is None else (*(horizon for horizon in usual if horizon < last), last)
        return tuple(horizon for horizon in wanted if 1 <= round(horizon / dt) <= rows)

    def ladder(self, stages: Sequence[tuple[str, Tensor]], horizons: Sequence[float]) -> tuple[Rung, ...]:
        """Errors of every stage at horizons that the logs are long enough for.

        Args:
            stages: name, and a parameter set per fold ``# (folds, P)``; one where the logs took no part in the fit.
            horizons: in s, of :meth:`horizons`.
        """
        if not horizons:
            return ()
        steps = {horizon: round(horizon / self.logs.dt) for horizon in horizons}
        windows = windows_of(self.logs, max(steps.values()), self.after)
        problem = Problem(self.library, self.logs, windows)
        folds = torch.as_tensor(np.zeros_like(windows.log) if self.fold_of is None else self.fold_of[windows.log])
        units, known = channel_units(windows.layout), {n: _known(self.logs, windows, n) for n in steps.values()}

        def errors(predicted: Tensor, step: int) -> dict[str, RungError]:
            """By channel, so many rows behind the starts of windows ``# (W, state)``."""
            block, own = max(SHORTEST_BLOCK, ceil(step / stride_of(self.logs.dt))), known[step]
            by_window = finite_errors(windows.layout, predicted, windows.measured[:, step])
            return {n: error_of(values[own], windows.log[own], units[n], block) for n, values in by_window.items()}

        rungs, unchanged = [], {at: errors(windows.start, n) for at, n in steps.items()}
        for name, sets in stages:
            mine = problem.states_by_segment(sets, folds if len(sets) > 1 else torch.zeros_like(folds))
            table = {at: errors(mine[:, n], n) for at, n in steps.items()}
            pairs = [(at, own, unchanged[at]) for at, own in table.items()]
            worse = {at: tuple(c for c in judged(own) if own[c].low > still[c].high) for at, own, still in pairs}
            rungs.append(Rung(name, table, not all(worse.values()), worse))
        return tuple(rungs)


def _known(data: Dataset, windows: Segments, steps: int) -> NDArray[np.bool_]:
    """Windows in whose first steps no row was lost whose commands nobody knows ``# (W,)``; all where these are few."""
    lost = [np.flatnonzero(log.extra.get(BRIDGED, 0.0)) for log in data]
    following = [np.searchsorted(lost[log], row) for log, row in zip(windows.log, windows.row, strict=True)]
    first = [[*lost[log], np.inf][at] for log, at in zip(windows.log, following, strict=True)]
    known: NDArray[np.bool_] = np.array(first) > windows.row + steps
    return known if known.sum() >= SETTINGS.fewest_pieces else np.ones_like(known)


def error_of(values: Array, log: NDArray[np.int64], unit: str, block: int = SHORTEST_BLOCK) -> RungError:
    """With an interval from resampling blocks of consecutive windows.

    Args:
        values: error norm of every window ``# (windows,)``.
        log: of every window, in the order of the logs ``# (windows,)``.
        unit: of the errors.
        block: windows in one: windows that overlap share errors, so none is shorter than a window.
    """
    blocks = np.unique(log * len(log) + number_in_log(log) // block, return_inverse=True)[1]
    sums, counts = np.bincount(blocks, values**2), np.bincount(blocks)
    draws = np.random.default_rng(0).integers(0, len(sums), (RESAMPLES, len(sums)))
    resampled = np.sqrt(sums[draws].sum(1) / counts[draws].sum(1))
    low, high = np.quantile(resampled, (0.025, 0.975))
    size, mean = float(np.sqrt(np.mean(values**2))), float(values.mean())
    return RungError(size, mean, float(low), float(high), unit, resampled)
