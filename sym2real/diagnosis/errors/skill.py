"""Errors of windows summed up per channel: how large, and beside what: "hold", the mean, the floor of noise."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

import numpy as np
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.start import ROWS, Start
from sym2real.diagnosis.data.windows import Windows, channel_errors, channel_units, predict_windows
from sym2real.diagnosis.errors.floor import Floor
from sym2real.diagnosis.settings import SETTINGS
from sym2real.json_objects import plain
from sym2real.layout import Layout
from sym2real.protocols import DynamicsModel
from sym2real.trajectory import Array

# Steps to the mean of rotations, each of which squares the error of the one before.
MEAN_STEPS = 4


@dataclass(frozen=True)
class ChannelError:
    """Error of one channel at the end of windows.

    Args:
        value: root mean square over windows of the channel's norm, in ``unit``.
        mean: mean over windows.
        median: median over windows.
        p95: 95th percentile over windows.
        hold: root mean square error of predicting that nothing changes.
        spread: standard deviation of what was measured about its mean in its log: the error of predicting that mean;
            not a number where logs have fewer than ten windows on average.
        floor: the part that the sensors' noise alone makes; not a number where no log is long enough to tell.
        unit: m, rad, m/s or rad/s.
        windows: how many these figures are over.
    """

    value: float
    mean: float
    median: float
    p95: float
    hold: float
    spread: float
    floor: float
    unit: str
    windows: int

    @property
    def skill(self) -> float:
        """1 − value/hold: 1 is perfect, 0 no better than predicting that nothing changes.

        Not a number of fewer than ten windows.
        """
        if self.windows < SETTINGS.fewest_pieces:
            return math.nan
        return 1.0 - self.value / self.hold if self.hold > 0 else 0.0

    @property
    def skill_mean(self) -> float:
        """1 − value/spread: 1 is perfect, 0 no better than the mean; not a number where ``spread`` is none, or zero."""
        return 1.0 - self.value / self.spread if self.spread > 0 else math.nan

    @property
    def fit(self) -> float:
        """The same in %, as system identification counts: 100·(1 − RMSE/standard deviation)."""
        return 100.0 * self.skill_mean

    @property
    def excess(self) -> float:
        """Error beyond the floor, √(value² − floor²), in ``unit``."""
        return math.nan if math.isnan(self.floor) else math.sqrt(max(self.value**2 - self.floor**2, 0.0))

    def to_dict(self) -> dict[str, Any]:
        """The entry of a channel in what ``sym2real compare --json`` prints, where null is what is not a number."""
        compared = {"skill": self.skill, "skill_mean": self.skill_mean, "fit": self.fit, "excess": self.excess}
        return {**vars(self), **compared}


@dataclass(frozen=True)
class HorizonErrors:
    """Errors of every channel one horizon (s) ahead."""

    horizon: float
    errors: dict[str, ChannelError]

    @property
    def windows(self) -> int:
        """How many the errors are over."""
        return next(iter(self.errors.values())).windows

    def to_dict(self) -> dict[str, Any]:
        """An entry of ``horizons`` in what ``sym2real compare --json`` prints."""
        return {"horizon": self.horizon, "windows": self.windows, "errors": plain(self.errors)}


def prediction_errors(
    model: DynamicsModel, dataset: Dataset, steps: Sequence[int], start: Start, floor: Sequence[Floor]
) -> Iterable[HorizonErrors]:
    """Errors so many rows ahead, in the order of ``steps``.

    Args:
        model: predicts in float64.
        dataset: logs with the model's columns.
        steps: lengths of windows in rows, none longer than every log.
        start: how start states are estimated.
        floor: of every length, or of none.

    Raises:
        ShapeError: when no log is long enough for a window.
    """
    for step, lowest in zip_longest(steps, floor):
        long_enough = [log for log in dataset if len(log) >= ROWS + step] or [max(dataset, key=len)]
        yield _summary([predict_windows(model, log, step, start) for log in long_enough], step, dataset, lowest)


def _summary(windows: Sequence[Windows], step: int, dataset: Dataset, floor: Floor | None) -> HorizonErrors:
    measured = [(window, window.measured[:, step - 1]) for window in windows]
    errors = _joined(channel_errors(window.layout, window.predicted[:, step - 1], ends) for window, ends in measured)
    holds = _joined(channel_errors(window.layout, window.start, ends) for window, ends in measured)
    off_means = _joined(off_the_mean(window.layout, ends) for window, ends in measured)
    varied = sum(len(window.rows) for window in windows) >= SETTINGS.fewest_pieces * len(windows)
    channels = {
        channel: ChannelError(
            value=_root_mean_square(errors[channel]),
            mean=float(errors[channel].mean()),
            median=float(np.median(errors[channel])),
            p95=float(np.quantile(errors[channel], 0.95)),
            hold=_root_mean_square(holds[channel]),
            spread=_root_mean_square(off_means[channel]) if varied else math.nan,
            floor=math.nan if floor is None else floor.errors[channel][0],
            unit=unit,
            windows=len(errors[channel]),
        )
        for channel, unit in channel_units(dataset.layouts.state).items()
    }
    return HorizonErrors(round(step * dataset.dt, 6), channels)


def _joined(parts: Iterable[dict[str, Array]]) -> dict[str, Array]:
    """Per channel, the windows of all logs behind each other ``# (windows,)``."""
    logs = list(parts)
    return {channel: np.concatenate([log[channel] for log in logs]) for channel in logs[0]}


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def off_the_mean(layout: Layout, states: Tensor) -> dict[str, Array]:
    """Distance of states from their mean on the manifold, per channel ``# (windows,)``."""
    middle = states[:1]
    for _ in range(MEAN_STEPS):
        middle = layout.retract(middle, layout.difference(states, middle.expand_as(states)).mean(0, keepdim=True))
    return channel_errors(layout, states, middle.expand_as(states))
