"""Sensors' noise, and errors that remain however good the model is: of the start, of the end, and small disturbances.

The start of a window is estimated from noisy rows. How far off it is, is found by drawing the sensors' noise once more
on top of the log and estimating again (a parametric bootstrap), so that the estimator is measured with its choices.
That error and the disturbances of the whitening go through the model's Jacobian to the end of the window, where a
noisy row is what a prediction is held against:

    floor² = E‖J_x δ‖² + Σ q_d² ‖J_d‖² + σ²        per channel
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import compared_components
from sym2real.diagnosis.data.start import ROWS, Start, start_states
from sym2real.diagnosis.data.windows import channel_name, channel_units, one_step_windows, predict_windows
from sym2real.diagnosis.errors.rungs import HeldOut, Rung, windows_of
from sym2real.diagnosis.estimate.whitening import PIECES, Whitening, disturbances
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.along_logs import predicted_from
from sym2real.layout import Layout
from sym2real.logs.derive import SHORTEST, slope
from sym2real.logs.noise import component_noise
from sym2real.protocols import DynamicsModel
from sym2real.trajectory import Array, Trajectory


@dataclass(frozen=True, eq=False)
class SensorNoise:
    """White noise on every tangent component; velocities that are slopes of positions have theirs.

    Args:
        deviation: standard deviation per tangent component ``# (tangent,)``.
        slopes: tangent place of each velocity that is the slope of a position through three rows (as differences become
            where data are checked), with that position's place.
        dt: in s.
    """

    deviation: Array
    slopes: dict[int, int]
    dt: float

    @classmethod
    def of(cls, data: Dataset) -> SensorNoise:
        """As third differences of the logs show it."""
        layout = data.layouts.state
        made = [pair for pair in layout.rates.items() if all(_is_slope(log, *pair) for log in data)]
        return cls(component_noise(data), _places(layout, made), data.dt)

    @classmethod
    def assumed(cls, sensors: Mapping[str, float], data: Dataset) -> SensorNoise:
        """Standard deviations by state field, for data without noise; velocities are slopes of positions."""
        layout = data.layouts.state
        deviation = [sensors.get(field.name, 0.0) for field in layout.fields for _ in range(field.tangent_size)]
        return cls(np.array(deviation), _places(layout, layout.rates.items()), data.dt)

    def with_deviation(self, places: tuple[int, ...], deviation: Array) -> SensorNoise:
        """The same with other sizes for some components."""
        changed = self.deviation.copy()
        changed[list(places)] = deviation
        return replace(self, deviation=changed)

    @property
    def of_a_row(self) -> Array:
        """Standard deviation of one measured row ``# (tangent,)``."""
        row = self.deviation.copy()
        for velocity, position in self.slopes.items():
            row[velocity] = np.sqrt(0.5) * self.deviation[position] / self.dt
        return row

    def added_to(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """The log with its noise drawn once more on top."""
        layout = trajectory.layouts.state
        drawn = rng.standard_normal((len(trajectory) + 2, layout.tangent_size)) * self.deviation
        noise = drawn[1:-1].copy()
        for velocity, position in self.slopes.items():
            noise[:, velocity] = (drawn[2:, position] - drawn[:-2, position]) / (2.0 * self.dt)
        state = layout.retract(torch.as_tensor(trajectory.state), torch.as_tensor(noise)).numpy()
        return replace(trajectory, state=state)


def _places(layout: Layout, rates: Iterable[tuple[str, str]]) -> dict[int, int]:
    """Tangent place of each velocity, with that of its position, of columns of both."""
    return {layout.vector_places[rate]: layout.vector_places[of] for of, rate in rates}


def _is_slope(trajectory: Trajectory, position: str, velocity: str) -> bool:
    logged, made = trajectory.column(velocity), slope(trajectory.time, trajectory.column(position), SHORTEST)
    return bool(np.std((made - logged)[1:-1]) <= SETTINGS.same * max(float(np.std(logged)), 1e-9))


DRAWS, SEED = 4, 0
MOST_WINDOWS = 60
# In s: windows for the floor of noise start this often, which is seldom enough not to cost more than the errors do.
STRIDE = 0.2


@dataclass(frozen=True)
class Floor:
    """Smallest error that a model can reach one horizon (s) ahead.

    Args:
        horizon: in s.
        errors: by channel, its root mean square and unit.
        noise: what the sensors alone make of it.
    """

    horizon: float
    errors: Mapping[str, tuple[float, str]]
    noise: Mapping[str, float] = field(default_factory=dict)

    @property
    def disturbed(self) -> dict[str, float]:
        """By channel, how many times the sensors' noise it is."""
        return {channel: self.errors[channel][0] / max(noise, 1e-12) for channel, noise in self.noise.items()}

    def to_dict(self) -> dict[str, Any]:
        """The entry of ``floor`` in docs/method.md, "Answers as files"."""
        errors = {channel: {"value": value, "unit": unit} for channel, (value, unit) in self.errors.items()}
        return {"horizon": self.horizon, "errors": errors, "noise": dict(self.noise)}


def floor_of_noise(model: DynamicsModel, data: Dataset, steps: Sequence[int], start: Start) -> tuple[Floor, ...]:
    """The part of the floor that the sensors' noise makes: for any model, whatever disturbs the robot.

    Third differences take fast motion for noise; no noise is larger than what a single step misses.

    Args:
        model: predicts in float64.
        data: logs with the model's columns; those too short for the longest window take no part.
        steps: lengths of windows in rows.
        start: how start states are estimated.
    """
    layout, rng, longest = data.layouts.state, np.random.default_rng(SEED), max(steps)
    noise, missed = SensorNoise.of(data), [one_step_windows(model, log).missed for log in data if len(log) > ROWS]
    if sum(map(len, missed)) > 1:  # a single window has no deviation
        noise = replace(noise, deviation=np.minimum(noise.deviation, torch.cat(missed).std(0).numpy()))
    stride, row = max(1, round(STRIDE / data.dt)), torch.as_tensor(noise.of_a_row).square()
    moved, windows = torch.zeros(longest, layout.tangent_size, dtype=torch.float64), 0
    for log in (log for log in data if len(log) >= ROWS + longest):
        plain = predict_windows(model, log, longest, start, stride)
        for by in _start_deviations(log, plain.rows, noise, rng, start).unbind(1):
            other = predicted_from(model, log, plain.rows, longest, start=layout.retract(plain.start, by).numpy())
            moved += layout.difference(other, plain.predicted).square().sum(0)
            windows += len(plain.rows)
    if not windows:
        return ()
    square = moved / windows + row  # (longest, tangent)
    return tuple(_floor(count * data.dt, layout, square[count - 1]) for count in steps)


def floor_of_explained(
    held: HeldOut, values: Tensor, whitening: Whitening, horizons: Sequence[float], *, noise: SensorNoise | None = None
) -> tuple[Floor, ...]:
    """The floor of a model that misses nothing but noise and small disturbances.

    Args:
        held: the equations with every effect in them, and logs, all windows of which tell of it.
        values: parameter set of the fully explained model ``# (P,)``.
        whitening: what noise and disturbances are.
        horizons: in s.
        noise: of the sensors; by default what the whitening and, of what it does not compare, the logs show.
    """
    if not horizons:
        return ()
    data, steps = held.logs, [round(horizon / held.logs.dt) for horizon in horizons]
    windows = windows_of(data, max(steps)).some(MOST_WINDOWS)
    layout, problem = windows.layout, Problem(held.library, data, windows)
    compared, _ = compared_components(layout, whitening.fields)
    noise = noise or SensorNoise.of(data).with_deviation(compared, whitening.sensor.numpy())
    rng, of_log = np.random.default_rng(SEED), [windows.row[windows.log == place] for place in range(len(data))]
    deviations = [_start_deviations(log, rows, noise, rng) for log, rows in zip(data, of_log, strict=True) if len(rows)]
    # Windows lie by log, as the deviations do.
    started = torch.einsum("wri,wdi->wrd", problem.start_jacobian(values), torch.cat(deviations)).square().mean(-1)
    kinds = disturbances(held.library.equations)
    pieces = max(1, round(max(steps) * PIECES / whitening.length))
    power = torch.tensor([whitening.disturbances[name] / size for name, size in kinds], dtype=torch.float64)
    disturbed = (problem.disturbance_jacobian(values, kinds, pieces) * power[:, None]).square().sum((-1, -2))
    row, size = torch.as_tensor(noise.of_a_row).square(), (windows.length, -1)
    if whitening.wander.walks:
        walk = torch.zeros_like(row)
        walk[list(compared)] = whitening.wander.shares * whitening.sensor.square()
        row = row + walk * torch.arange(windows.length)[:, None]
    of_noise, whole = ((part.mean(0).reshape(size) + row)[steps] for part in (started, started + disturbed))
    levels = zip(horizons, of_noise, whole, strict=True)
    return tuple(_floor(horizon, layout, square, quiet) for horizon, quiet, square in levels)


def no_higher_than_reached(floor: Sequence[Floor], stages: Sequence[Rung]) -> tuple[Floor, ...]:
    """The floor, nowhere above the lowest error of a ladder: what a model has reached can be reached.

    Variances that were estimated too large raise the floor; motors sampled fast made it four times what was reached.
    """
    lowered = []
    for level in floor:
        reached = [stage.horizons[level.horizon] for stage in stages if level.horizon in stage.horizons]
        known = level.errors.items()
        errors = {name: (min([size, *(own[name].value for own in reached)]), unit) for name, (size, unit) in known}
        noise = {channel: min(size, errors[channel][0]) for channel, size in level.noise.items()}
        lowered.append(replace(level, errors=errors, noise=noise))
    return tuple(lowered)


def _start_deviations(
    log: Trajectory, rows: NDArray[np.int64], noise: SensorNoise, rng: np.random.Generator, method: Start = "smoothed"
) -> Tensor:
    """How far starts at these rows move when a log's noise is drawn once more ``# (rows, DRAWS, tangent)``.

    By more where all are further from the measured rows than noise makes them: what moves fast is smoothed away.
    """
    difference, states = log.layouts.state.difference, torch.as_tensor(log.state)
    everywhere, moves, drawn = np.arange(ROWS - 1, len(log)), list[Tensor](), list[Tensor]()
    starts = torch.as_tensor(start_states(log, everywhere, method))
    for _ in range(DRAWS):
        noisy = noise.added_to(log, rng)
        moves.append(difference(torch.as_tensor(start_states(noisy, everywhere, method)), starts))
        drawn.append(difference(torch.as_tensor(noisy.state), states)[everywhere])
    moved = torch.stack(moves, dim=1)
    by_noise = (moved - torch.stack(drawn, dim=1)).square().mean((0, 1))
    beyond = (difference(starts, states[everywhere]).square().mean(0) - by_noise).clamp_min(0.0)
    return moved[rows - everywhere[0]] * (1.0 + beyond / moved.square().mean((0, 1)).clamp_min(1e-300)).sqrt()


def _floor(horizon: float, layout: Layout, square: Tensor, of_noise: Tensor | None = None) -> Floor:
    """From mean squares per tangent component, of all and of the noise alone where that is not all."""
    units, noise = channel_units(layout), {} if of_noise is None else _sizes(layout, of_noise)
    errors = {channel: (size, units[channel]) for channel, size in _sizes(layout, square).items()}
    return Floor(round(horizon, 6), errors, noise)


def _sizes(layout: Layout, square: Tensor) -> dict[str, float]:
    parts = square.split([of.tangent_size for of in layout.fields])
    return {channel_name(of): float(part.sum().sqrt()) for of, part in zip(layout.fields, parts, strict=True)}
