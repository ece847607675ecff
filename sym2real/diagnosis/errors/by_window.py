"""Prediction errors of windows over all logs, beside what a person would say of the windows."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sym2real.dataset import Logs
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.data.start import ROWS
from sym2real.diagnosis.data.windows import LARGEST, channel_name, judged, predict_windows
from sym2real.effects.along_logs import prepared
from sym2real.layout import Layout
from sym2real.logs.conditions import features, over_windows, units_of
from sym2real.logs.noise import noise_of
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations
from sym2real.trajectory import Array
from sym2real.vocabulary import HEIGHT

HORIZON = 0.5  # s
BLOCK = 2.0  # s: pieces of a single log that stand for logs in the cross-validation


@dataclass(frozen=True, eq=False)
class WindowErrors:
    """Errors and features of windows over all logs.

    Args:
        errors: by channel, as large as one can be where the model predicts no number ``# (windows,)``.
        floor: by channel, the noise of one measurement of it.
        features: by name, mean over the window ``# (windows,)``.
        log: position of each window's log ``# (windows,)``.
        group: log, or piece of a single log, for cross-validation ``# (windows,)``.
        start, end: in s from the log's start ``# (windows,)``.
        names: of the logs.
        units: of features.
    """

    errors: dict[str, Array]
    floor: dict[str, float]
    features: dict[str, Array]
    log: NDArray[np.int64]
    group: NDArray[np.int64]
    start: Array
    end: Array
    names: tuple[str, ...]
    units: Mapping[str, str]


def window_errors(model: Equations | DynamicsModel, data: Logs) -> WindowErrors:
    """Errors at the end of windows of 0.5 s, or the longest that the logs allow, with what a person would say of them.

    Args:
        model: predicts in float64, with the data's columns.
        data: logs.

    Raises:
        ShapeError: when columns or time steps differ, or no log is long enough for a window.
    """
    predictor, dataset = prepared(model, long_enough(data, model))
    steps = max(1, min(round(HORIZON / dataset.dt), max(map(len, dataset)) - ROWS))
    layout, parts, means = dataset.layouts.state, [], []
    for index, trajectory in enumerate(dataset):
        if len(trajectory) >= ROWS + steps:
            windows = predict_windows(predictor, trajectory, steps)
            rows, off = windows.rows, layout.difference(windows.predicted[:, -1], windows.measured[:, -1])
            since = trajectory.time[rows] - trajectory.time[0]
            parts.append((np.full(len(rows), index), since, off.nan_to_num(LARGEST).numpy()))
            means.append({name: over_windows(values, rows, steps) for name, values in features(trajectory).items()})
    log, start, tangents = (np.concatenate(part) for part in zip(*parts, strict=True))
    common = set.intersection(*map(set, means))
    channels, units, noise = named_channels(layout), units_of(layout), [noise_of(log) for log in dataset]
    return WindowErrors(
        errors={name: np.linalg.norm(tangents[:, places], axis=1) for name, places in channels.items()},
        floor={name: float(np.median([np.linalg.norm(own[at]) for own in noise])) for name, at in channels.items()},
        features={name: np.concatenate([own[name] for own in means]) for name in units if name in common},
        log=log,
        group=log if len(parts) > 1 else (start / BLOCK).astype(np.int64),
        start=start,
        end=start + steps * dataset.dt,
        names=tuple(trajectory.name for trajectory in dataset),
        units=units,
    )


def named_channels(layout: Layout) -> dict[str, list[int]]:
    """Tangent positions of what is compared: positions and angles, which logs hold without differences.

    Of columns that are none of these, every field.
    """
    wanted = judged(map(channel_name, layout.fields))
    channels: dict[str, list[int]] = {}
    for field, places in zip(layout.fields, layout.tangent_places, strict=True):
        own = list(places)
        # What is up and what is level is told apart, because gravity does.
        if field.name == "position" and HEIGHT in field.columns:
            height = own[field.columns.index(HEIGHT)]
            channels |= {HEIGHT: [height], "xy": [slot for slot in own if slot != height]}
        elif channel_name(field) in wanted:
            channels[channel_name(field)] = own
    return channels
