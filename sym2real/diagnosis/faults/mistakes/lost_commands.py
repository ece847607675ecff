"""What was sent between the rows of a log that is slower than the model: held commands, or others that no row tells.

A recorder that keeps every second row of a controller's commands loses the others. Held over the row, the one that was
kept looks as if it did less than it does (errors in variables). In the place of a lost command stands what is expected
of it, the smooth part of those that were kept, or half-way to it where they mostly answer noise (regression
calibration: R. Carroll et al., "Measurement Error in Nonlinear Models", 2006, chapter 4). The model tells which of
these it was, by its errors over a row.
"""

from dataclasses import replace
from operator import itemgetter

import numpy as np
import torch
from scipy.interpolate import make_smoothing_spline

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.windows import one_step_windows
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.along_logs import prepared
from sym2real.symbolic import Equations
from sym2real.symbolic.period import steps_within
from sym2real.trajectory import Trajectory

ROWS = 2  # of a delay, at most, that commands may have in the comparison
TOWARDS_SMOOTH = (0.5, 1.0)  # of the way from the command that is held to the smooth one


def with_lost_commands(model: Equations, data: Dataset) -> Dataset:
    """The logs with what is expected of commands that no row tells, sent between rows, where that predicts better.

    Beyond chance: by a likelihood ratio of the errors over a row.
    """
    parts = steps_within(model, data.dt)
    if parts == 1 or data[0].between is not None:
        return data
    versions = [data, *(Dataset(_smooth(log, parts, part) for log in data) for part in TOWARDS_SMOOTH)]
    likely = [_likelihood_of_any_delay(model, logs, parts) for logs in versions]
    return versions[int(np.argmax(likely))] if max(likely) - likely[0] > SETTINGS.sensor_deviations**2 else data


def _likelihood_of_any_delay(model: Equations, data: Dataset, parts: int) -> float:
    """The best of commands that take effect at once and later, one command after the other.

    Held over a row they are half a row late already.
    """
    best = step_likelihood(model, data)
    for place in range(data.layouts.action.size):
        delayed = (Dataset(_later(log, place, parts, late) for log in data) for late in range(1, ROWS * parts + 1))
        best, data = max([(best, data), *((step_likelihood(model, logs), logs) for logs in delayed)], key=itemgetter(0))
    return best


def _later(log: Trajectory, place: int, parts: int, late: int) -> Trajectory:
    """With a command that takes effect so many parts of a row later."""
    between = log.sent_in_parts(parts).copy()
    sent = between[:, :, place].ravel()
    between[:, :, place] = np.concatenate([np.repeat(sent[:1], late), sent[:-late]]).reshape(len(log), parts)
    return replace(log, action=between[:, 0], between=between)


def _smooth(log: Trajectory, parts: int, part: float) -> Trajectory:
    """With commands between rows that lie so much of the way from the one that is held to a smooth curve."""
    rows = np.arange(len(log), dtype=np.float64)
    moments = np.minimum(rows[:, None] + np.arange(parts) / parts, rows[-1])
    between = np.stack([make_smoothing_spline(rows, column)(moments) for column in log.action.T], axis=-1)
    between[:, 0] = log.action
    return replace(log, between=log.action[:, None] + part * (between - log.action[:, None]))


def step_likelihood(model: Equations, data: Dataset) -> float:
    """Of the errors over a row, each component with a variance of its own."""
    predict, logs = prepared(model, data)
    errors = [one_step_windows(predict, log).missed for log in logs]
    return -0.5 * sum(map(len, errors)) * float(torch.cat(errors).square().mean(0).clamp(min=1e-300).log().sum())
