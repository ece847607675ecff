"""How far a model's predictions are from a log: one step, k steps and free run, per channel, beside "hold"."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sym2real.diagnosis.data_report import DataReport, data_report
from sym2real.diagnosis.features import Region
from sym2real.diagnosis.floor import Floor, floor_of_noise
from sym2real.diagnosis.locate import Where, locate
from sym2real.diagnosis.prepared import prepared
from sym2real.diagnosis.start import ROWS, Start
from sym2real.diagnosis.windows import Windows, channel_units, predict_windows
from sym2real.errors import ShapeError
from sym2real.layout import Layout
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Dataset, Trajectory

HORIZONS = (0.1, 0.2, 0.5, 0.8, 1.0)
# Free run in s: a car drifts slowly, a quadrotor with a wrong model is upside down after two seconds.
FREE_RUN = {"heading": 5.0, "otherwise": 2.0}


@dataclass(frozen=True)
class ChannelError:
    """Error of one channel at the end of windows.

    Args:
        value: root mean square over windows of the channel's norm, in ``unit``.
        mean: mean over windows.
        median: median over windows.
        p95: 95th percentile over windows.
        hold: root mean square error of predicting that nothing changes.
        unit: m, rad, m/s or rad/s.
    """

    value: float
    mean: float
    median: float
    p95: float
    hold: float
    unit: str

    @property
    def skill(self) -> float:
        """1 − value/hold: 1 is perfect, 0 no better than predicting that nothing changes."""
        return 1.0 - self.value / self.hold if self.hold > 0 else 0.0


@dataclass(frozen=True)
class HorizonErrors:
    """Errors of every channel one horizon (s) ahead, over so many windows."""

    horizon: float
    windows: int
    errors: dict[str, ChannelError]

    def to_dict(self) -> dict[str, Any]:
        channels = {channel: {**vars(error), "skill": error.skill} for channel, error in self.errors.items()}
        return {"horizon": self.horizon, "windows": self.windows, "errors": channels}


@dataclass(frozen=True)
class Comparison:
    """What :func:`compare` found.

    Args:
        one_step: errors one row ahead.
        horizons: errors at the horizons asked for that the logs are long enough for.
        free_run: errors after 2 s (car 5 s), or what the longest log allows.
        start: how start states were found.
        notes: what was done to the logs on the way in, and what was left out.
        where: regions in which the errors are larger.
        data: what the logs are fit for.
        floor: the part of the errors that the sensors' noise alone makes, at start and end.
    """

    one_step: HorizonErrors
    horizons: tuple[HorizonErrors, ...]
    free_run: HorizonErrors
    start: Start
    notes: tuple[str, ...] = ()
    where: tuple[Where, ...] = ()
    data: DataReport | None = None
    floor: tuple[Floor, ...] = ()

    def at(self, horizon: float) -> HorizonErrors:
        """Errors at the horizon nearest to ``horizon`` s."""
        return min(self.horizons, key=lambda errors: abs(errors.horizon - horizon))

    def to_dict(self) -> dict[str, Any]:
        """The object that ``--json`` prints (DESIGN.md, "Names that stay")."""
        return {
            "one_step": self.one_step.to_dict(),
            "horizons": [errors.to_dict() for errors in self.horizons],
            "free_run": self.free_run.to_dict(),
            "floor": [one.to_dict() for one in self.floor],
            "start": self.start,
            "notes": list(self.notes),
            "where": [one.to_dict() for one in self.where],
            "data": None if self.data is None else self.data.to_dict(),
        }


def compare(
    model: Equations | DynamicsModel,
    data: Dataset | Trajectory,
    horizons: Sequence[float] = HORIZONS,
    start: Start = "smoothed",
    region: Region | None = None,
) -> Comparison:
    """Compare a model's predictions with measured trajectories.

    Windows start every 0.1 s; errors are taken at their end; what was sent and what was known along the log drive
    the prediction.

    Args:
        model: equations, or a model that predicts in float64.
        data: logs whose columns and time step are those of the model (``read_log(…, layouts=…, dt=…)``).
        horizons: in s; those longer than every log are left out, and ``notes`` says so.
        start: "smoothed" from the ten rows up to the start, or the "measured" row.
        region: range of every column in the model's training, to say whether it fails inside or outside.

    Raises:
        ShapeError: when columns or time steps differ, or no log is long enough for a window.
    """
    logs = data if isinstance(data, Dataset) else Dataset([data])
    predictor, dataset = prepared(model, logs)
    longest = max(len(trajectory) for trajectory in dataset) - ROWS
    if longest < 1:
        raise ShapeError(f"no log is longer than {ROWS} rows: there is no window to compare")
    reachable = [horizon for horizon in horizons if round(horizon / dataset.dt) <= longest]
    notes = [f"{trajectory.name}: {note}" for trajectory in dataset for note in trajectory.notes]
    left_out = [horizon for horizon in horizons if horizon not in reachable]
    if left_out:
        notes.append(f"no log is long enough for horizons {left_out} s")
    free = min(round(free_run_seconds(dataset.layouts.state) / dataset.dt), longest)
    steps = sorted({1, free, *(round(horizon / dataset.dt) for horizon in reachable)})
    table = dict(zip(steps, _errors(predictor, dataset, steps, start), strict=True))
    return Comparison(
        one_step=table[1],
        horizons=tuple(replace(table[round(horizon / dataset.dt)], horizon=horizon) for horizon in reachable),
        free_run=table[free],
        start=start,
        notes=tuple(notes),
        where=locate(predictor, dataset, region),
        data=data_report(logs),
        floor=floor_of_noise(predictor, dataset, steps, start),
    )


def free_run_seconds(layout: Layout) -> float:
    """How long a free run is, s."""
    return FREE_RUN["heading" if layout.has_field("heading") else "otherwise"]


def _errors(model: DynamicsModel, dataset: Dataset, steps: Sequence[int], start: Start) -> Iterable[HorizonErrors]:
    for step in steps:
        windows = [
            predict_windows(model, trajectory, step, start) for trajectory in dataset if len(trajectory) >= ROWS + step
        ]
        yield _summary(windows, step, dataset)


def _summary(windows: Sequence[Windows], step: int, dataset: Dataset) -> HorizonErrors:
    units = channel_units(dataset.layouts.state)
    errors = [window.errors(step) for window in windows]
    holds = [window.hold_errors(step) for window in windows]
    channels = {
        channel: _channel_error(
            np.concatenate([error[channel] for error in errors]),
            np.concatenate([hold[channel] for hold in holds]),
            unit,
        )
        for channel, unit in units.items()
    }
    return HorizonErrors(round(step * dataset.dt, 6), sum(len(window.rows) for window in windows), channels)


def _channel_error(errors: Array, hold: Array, unit: str) -> ChannelError:
    return ChannelError(
        value=float(np.sqrt(np.mean(errors**2))),
        mean=float(errors.mean()),
        median=float(np.median(errors)),
        p95=float(np.quantile(errors, 0.95)),
        hold=float(np.sqrt(np.mean(hold**2))),
        unit=unit,
    )
