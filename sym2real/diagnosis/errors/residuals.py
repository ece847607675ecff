"""What one-step residuals remember of themselves, and of the commands: a complete model leaves noise alone.

The residual of a row is what was measured less what the model predicts from the measured row before it. White sensor
noise enters two rows with opposite signs, so a negative correlation between neighbours accuses nobody; any other
autocorrelation does. A residual that follows a command so many rows earlier shows a gain, a lag or a delay that the
model lacks. Bands are those of :mod:`sym2real.correlations`.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from scipy.stats import norm

from sym2real import correlations
from sym2real.dataset import Dataset
from sym2real.diagnosis.data.start import ROWS
from sym2real.diagnosis.data.windows import UNIT_OF_KIND, channel_name, one_step_windows
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.along_logs import prepared
from sym2real.layout import Layout
from sym2real.logs.noise import SMALLEST_NOISE
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations
from sym2real.trajectory import Array
from sym2real.upward import upward

MEMORY = 0.5  # s: longest lag
PIECE = 4  # the longest lag is at most this part of the longest log


@dataclass(frozen=True, eq=False)
class Following:
    """How a residual follows one command.

    Args:
        correlation: from ``-lags`` (the command comes after the residual) to ``lags`` rows earlier ``# (2·lags + 1,)``.
        deviation: of every one of them if the two have nothing to do with each other.
    """

    correlation: Array
    deviation: float

    @property
    def causal(self) -> Array:
        """Lags from 0 on: the command of the step itself, then earlier ones ``# (lags + 1,)``."""
        return self.correlation[len(self.correlation) // 2 :]

    @property
    def answers_noise(self) -> bool:
        """Whether the next command goes with the residual, and the step's own against it, or the other way round.

        Noise of a row stands in its own residual and, with the other sign, in the next; a controller answers it once
        in between. A command that is merely slow goes with both alike.
        """
        after = self.correlation[len(self.correlation) // 2 - 1]
        return bool(after * self.causal[0] < 0 and abs(after) > _bar(1) * self.deviation)


@dataclass(frozen=True, eq=False)
class Residual:
    """One component's residuals.

    Args:
        deviation: standard deviation in ``unit``.
        unit: m, rad, m/s or rad/s.
        autocorrelation: 1 … lags rows apart ``# (lags,)``.
        deviations: of the autocorrelations of what remembers at most one row ``# (lags,)``.
        commands: how it follows each command that varies.
    """

    deviation: float
    unit: str
    autocorrelation: Array
    deviations: Array
    commands: dict[str, Following]

    def worst(self) -> tuple[float, int]:
        """Largest autocorrelation in deviations, and its lag; noise makes neighbours opposite, which does not count."""
        size = np.abs(self.autocorrelation) / self.deviations
        size[0] = max(self.autocorrelation[0] / self.deviations[0], 0.0)
        return float(size.max()), int(size.argmax()) + 1


@dataclass(frozen=True, eq=False)
class Residuals:
    """What :func:`one_step_residuals` found.

    Args:
        dt: time between rows in s.
        rows: of all logs together.
        lags: longest lag in rows.
        components: by name; those that the model predicts to the last digit are left out.
    """

    dt: float
    rows: int
    lags: int
    components: dict[str, Residual]

    @property
    def white_bar(self) -> float:
        """Deviations that the largest autocorrelation of all stays below in 95 % of complete models."""
        return _bar(len(self.components) * self.lags)

    @property
    def command_bar(self) -> float:
        """Deviations that the largest causal correlation with any command stays below, likewise."""
        return _bar(sum(len(residual.commands) for residual in self.components.values()) * (self.lags + 1))

    @property
    def coloured(self) -> tuple[str, ...]:
        """Components whose residual is not white beyond what noise makes, the clearest first."""
        worst = {name: residual.worst()[0] for name, residual in self.components.items()}
        return tuple(sorted((name for name in worst if worst[name] > self.white_bar), key=lambda name: -worst[name]))

    def suspicious(self) -> dict[str, str]:
        """Commands that a residual follows, each with the component that does so most clearly."""
        clearest: dict[str, tuple[float, str]] = {}
        for name, residual in self.components.items():
            for command, following in residual.commands.items():
                size = float(np.abs(following.causal).max()) / following.deviation
                if size > max(self.command_bar, clearest.get(command, (0.0, ""))[0]):
                    clearest[command] = size, name
        return {command: name for command, (_, name) in clearest.items()}

    def lines(self) -> list[str]:
        """What a person should know, a sentence each."""
        return list(upward("residual_lines")(self))

    def to_dict(self) -> dict[str, Any]:
        """The object ``residuals`` that ``compare --json`` prints; bands are of 95 %, each lag for itself."""
        components = {name: self._entry(name, residual) for name, residual in self.components.items()}
        return {"dt": self.dt, "rows": self.rows, "lags": self.lags, "components": components, "lines": self.lines()}

    def _entry(self, name: str, residual: Residual) -> dict[str, Any]:
        band, known = _bar(1), {"deviation": residual.deviation, "unit": residual.unit}
        own = {"values": residual.autocorrelation.tolist(), "band": (band * residual.deviations).tolist()}
        commands = {
            command: {"values": other.correlation.tolist(), "band": band * other.deviation}
            for command, other in residual.commands.items()
        }
        return {**known, "white": name not in self.coloured, "autocorrelation": own, "commands": commands}


@cache
def _bar(tests: int) -> float:
    return float(norm.isf(SETTINGS.level / 2 / max(tests, 1)))


def one_step_residuals(model: Equations | DynamicsModel, data: Dataset, constant: Collection[str] = ()) -> Residuals:
    """Autocorrelation of what one-step predictions miss, and its correlation with what was sent.

    Args:
        model: predicts in float64, with the data's columns.
        data: logs; those shorter than a window's history and a few rows are left out.
        constant: commands that hardly vary, which are left out.

    Raises:
        ShapeError: when columns or time steps differ.
    """
    predictor, dataset = prepared(model, data)
    misses, sent = [], []
    for trajectory, as_sent in zip(dataset, data, strict=True):
        if len(trajectory) > ROWS + PIECE:
            windows = one_step_windows(predictor, trajectory)
            misses.append(windows.missed.numpy())
            sent.append(as_sent.action[windows.rows])
    if not misses:
        return Residuals(dataset.dt, 0, 0, {})
    lags = max(1, min(round(MEMORY / dataset.dt), max(map(len, misses)) // PIECE))
    commands = {name: own for name, own in _centred(data.layouts.action, sent).items() if name not in constant}
    units = tangent_units(dataset.layouts.state)
    residuals = {n: residual_of(own, commands, lags, units[n]) for n, own in _centred(units, misses).items()}
    components = {name: residual for name, residual in residuals.items() if residual is not None}
    return Residuals(dataset.dt, sum(map(len, misses)), lags, components)


def _centred(names: Iterable[str], pieces: Sequence[Array]) -> dict[str, list[Array]]:
    """By name, every column of pieces ``# (rows, columns)`` less its mean in each ``# (rows,)``."""
    return {name: correlations.centred([rows[:, place] for rows in pieces]) for place, name in enumerate(names)}


def residual_of(pieces: Sequence[Array], commands: dict[str, list[Array]], lags: int, unit: str) -> Residual | None:
    """Correlations of one component; None where the model predicts it to the last digit.

    Args:
        pieces: its residuals by log, centred ``# (rows,)`` each.
        commands: by name, centred, in the same pieces.
        lags: longest lag in rows.
        unit: of the residual.
    """
    rows = sum(map(len, pieces))
    deviation = float(np.sqrt(sum(float(piece @ piece) for piece in pieces) / rows))
    if deviation <= SMALLEST_NOISE:
        return None
    far = max(lags, correlations.summed_lags(pieces))
    itself = correlations.autocorrelation(pieces, far)
    following = {}
    for name, values in commands.items():
        by_chance = correlations.cross_deviation(rows, itself, correlations.autocorrelation(values, far))
        following[name] = Following(correlations.cross_correlations(pieces, values, lags), by_chance)
    return Residual(deviation, unit, itself[:lags], correlations.own_deviations(rows, itself[:lags]), following)


def tangent_units(layout: Layout) -> dict[str, str]:
    """Name and unit of every component of a difference between states, in their order."""
    units: dict[str, str] = {}
    for field in layout.fields:
        names = field.columns
        if field.kind != "vector":
            axes = "xyz"[: field.tangent_size]
            names = tuple(f"{channel_name(field)} {axis}" for axis in axes) if len(axes) > 1 else (channel_name(field),)
        units |= dict.fromkeys(names, UNIT_OF_KIND.get(field.kind, field.unit))
    return units
