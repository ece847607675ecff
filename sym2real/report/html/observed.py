"""What every combination of switches predicts of the logs: errors over the horizon and of every window, and curves."""

from dataclasses import dataclass

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis import ROWS
from sym2real.diagnosis.data.start import Start
from sym2real.diagnosis.data.windows import channel_units, horizons_in_rows
from sym2real.diagnosis.errors.by_window import HORIZON, named_channels
from sym2real.layout import Layout
from sym2real.report.html.predictions import Starts
from sym2real.report.html.signals import signals, unwrapped
from sym2real.report.html.variants import Given, WithFindings, subsets
from sym2real.trajectory import Array


@dataclass(frozen=True, eq=False)
class Observed:
    """Predictions of all variants, as far as a page shows them; axis B goes over the combinations of switches.

    Args:
        starts: windows, which start every 0.1 s.
        horizons: in s ``# (K,)``.
        ahead: horizon of the errors of windows, in s.
        by_horizon: root mean square error by channel ``# (B, K)``.
        by_window: error by channel; not a number where a log ends before ``# (B, W)``.
        curves: by log, measured signals ``# (rows, signals)`` and predicted ones with gaps ``# (B, rows, signals)``.
    """

    starts: Starts
    horizons: Array
    ahead: float
    by_horizon: dict[str, Array]
    by_window: dict[str, Array]
    curves: tuple[tuple[Array, Array], ...]

    @property
    def layout(self) -> Layout:
        """Of the measured states."""
        return self.starts.data.layouts.state


def observe(variants: Given | WithFindings, data: Dataset, method: Start = "smoothed") -> Observed:
    """Predict with every combination of switches.

    Args:
        variants: models.
        data: logs with the models' columns.
        method: how start states are estimated.
    """
    longest = max(len(log) for log in data) - ROWS
    wanted_rows = {round(horizon / data.dt) for horizon in horizons_in_rows(data.dt)}
    steps = sorted({row for row in wanted_rows if 1 <= row <= longest} | {1})
    starts, shown = Starts.of(data, steps[-1], method), min(round(HORIZON / data.dt), steps[-1])
    layout, ends = data.layouts.state, np.array([*steps, shown]) - 1
    measured = starts.measured[:, ends]
    channels = dict(zip(channel_units(layout), map(list, layout.tangent_places), strict=True)) | named_channels(layout)
    sizes: dict[str, list[Array]] = {name: [] for name in channels}  # norms # (W, horizons and the shown one)
    curves, model = [], None
    for on in subsets(len(variants.switches)):
        model, logs = variants.prepared(on, data, model)
        predicted = starts.predicted(model, logs)
        away = layout.difference(predicted[:, ends], measured)
        for name, places in channels.items():
            sizes[name].append(away[..., places].norm(dim=-1).numpy())
        curves.append([signals(layout, states) for states in starts.along(predicted)])
    by_channel = {name: np.array(made) for name, made in sizes.items()}  # (B, W, …)
    return Observed(
        starts=starts,
        horizons=np.array(steps) * data.dt,
        ahead=shown * data.dt,
        by_horizon={name: np.sqrt(np.nanmean(made[..., :-1] ** 2, axis=1)) for name, made in by_channel.items()},
        by_window={name: made[..., -1] for name, made in by_channel.items()},
        curves=tuple(
            unwrapped(layout, signals(layout, log.state), np.array([row[index] for row in curves]))
            for index, log in enumerate(data)
        ),
    )
