"""What was sent between the rows of a log that is slower than the model: held commands, or others that no row tells.

A recorder that keeps every second row of a controller's commands loses the others. Held over the row, the one that was
kept looks as if it did less than it does (errors in variables). In the place of a lost command stands what is expected
of it, the smooth part of those that were kept (regression calibration: R. Carroll et al., "Measurement Error in
Nonlinear Models", 2006, chapter 4). The model tells which of the two it was, by its errors over a row.

Motors are told by a loop on board, which is faster than most logs, so that rows at the model's own step lose commands
as well: a healthy robot's torques seemed to be a third of what they are. There a row has the mean of what is expected,
and a part of what the command that was kept differs from it. As torques may be larger than the model says, and late,
the rates tell: by how their changes go with those that the model predicts, at any scale and any lag.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import torch
from scipy.interpolate import make_smoothing_spline
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.windows import predict_windows
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.along_logs import prepared
from sym2real.symbolic import Equations
from sym2real.symbolic.period import steps_within
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import MOTOR_TORQUES, RATE

ROWS = 2  # of a delay, at most, that commands may have in the comparison
LAGS = (0.0, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6)  # rows, of motors in it
# Of motors' commands a row's mean is on the line to the next row, of a smooth part by a kernel of so many rows
# (standard deviation) and of a part of what the kept command differs from it: one of so many that were sent.
MEANS = ((0.1, 0.0), (4.0, 0.5), (4.0, 0.25))


def with_lost_commands(model: Equations, data: Dataset) -> Dataset:
    """The logs with what is expected of commands that were sent between their rows, where that predicts better.

    Beyond chance: by a likelihood ratio of the errors over a row.
    """
    parts = steps_within(model, data.dt)
    if parts > 1:
        likelihood, others = _likelihood_of_any_delay, [Dataset(_smooth(log, parts) for log in data)]
    elif MOTOR_TORQUES[0] in model.quantities:
        likelihood, others = _likelihood_of_any_lag, [Dataset(_mean(log, *of) for log in data) for of in MEANS]
    else:
        return data
    held, *expected = (likelihood(model, logs, parts) for logs in (data, *others))
    best = int(np.argmax(expected))
    return others[best] if expected[best] - held > SETTINGS.sensor_deviations**2 else data


def _likelihood_of_any_lag(model: Equations, data: Dataset, parts: int) -> float:
    """The best of all motors that follow at once, late, and slowly, where a row has one part."""
    pairs = product(range(0, (ROWS + 1) * parts, parts), LAGS)
    return max(_turning_likelihood(model, Dataset(_following(log, *pair) for log in data)) for pair in pairs)


def _following(log: Trajectory, late: int, time: float) -> Trajectory:
    """With the means over rows of what follows the commands so many rows late, at first order with a time in rows."""
    sent, kept = log.action[np.maximum(np.arange(len(log)) - late, 0)], np.exp(-1.0 / max(time, 1e-9))
    before = sent[0] + lfilter([0.0, 1.0 - kept], [1.0, -kept], sent - sent[0], axis=0)
    return replace(log, action=sent + (before - sent) * time * (1.0 - kept), between=None)


def _turning_likelihood(model: Equations, data: Dataset) -> float:
    """Of the changes of body rates over a row, given those that the model predicts, at any scale."""
    predict, logs = prepared(model, data)
    windows = [predict_windows(predict, log, 1, "measured", stride=1) for log in logs]
    columns = windows[0].layout.indices(RATE.columns)
    change = [torch.stack([part.measured[:, 0], part.predicted[:, 0]]) - part.start for part in windows]
    pairs = torch.cat(change, dim=1)[..., columns].permute(2, 0, 1)  # (axis, measured or predicted, rows)
    together = torch.stack([torch.corrcoef(pair)[0, 1] for pair in pairs]).clamp_min(0.0)
    return -0.5 * pairs.shape[-1] * float((1.0 - together.square()).log().sum())


def _likelihood_of_any_delay(model: Equations, data: Dataset, parts: int) -> float:
    """The best of commands that take effect at once and later, one command after the other.

    Held over a row they are half a row late already.
    """
    best = step_likelihood(model, data)
    for place in range(data.layouts.action.size):
        delayed = [Dataset(_later(log, place, parts, late) for log in data) for late in range(1, ROWS * parts + 1)]
        likely = [step_likelihood(model, logs) for logs in delayed]
        if max(likely) > best:
            best, data = max(likely), delayed[int(np.argmax(likely))]
    return best


def _later(log: Trajectory, place: int, parts: int, late: int) -> Trajectory:
    """With a command that takes effect so many parts of a row later."""
    between = log.sent_in_parts(parts).copy()
    sent = between[:, :, place].ravel()
    between[:, :, place] = np.concatenate([np.repeat(sent[:1], late), sent[:-late]]).reshape(len(log), parts)
    return replace(log, action=between[:, 0], between=between)


def _smooth(log: Trajectory, parts: int) -> Trajectory:
    rows = np.arange(len(log), dtype=np.float64)
    moments = np.minimum(rows[:, None] + np.arange(parts) / parts, rows[-1])
    between = np.stack([make_smoothing_spline(rows, column)(moments) for column in log.action.T], axis=-1)
    between[:, 0] = log.action
    return replace(log, between=between)


def _mean(log: Trajectory, width: float, share: float) -> Trajectory:
    """With what is expected of every row's mean, as of :data:`MEANS`; a smoothing spline takes seconds for a log."""
    smooth = gaussian_filter1d(log.action, width, axis=0, mode="nearest")
    action = (smooth + np.concatenate([smooth[1:], smooth[-1:]])) / 2 + share * (log.action - smooth)
    return replace(log, action=action, between=action[:, None])


def step_likelihood(model: Equations, data: Dataset) -> float:
    """Of the errors over a row, each component with a variance of its own."""
    predict, logs = prepared(model, data)
    windows = [predict_windows(predict, log, 1, "measured", stride=1) for log in logs]
    errors = [part.layout.difference(part.measured[:, 0], part.predicted[:, 0]) for part in windows]
    squares = torch.cat(errors).square().mean(0).clamp(min=1e-300)
    return -0.5 * sum(map(len, errors)) * float(squares.log().sum())
