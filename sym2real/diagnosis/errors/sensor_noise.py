"""Noise of the sensors, as a log shows it: how large it is, and drawn once more on top of the log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import torch

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import component_noise
from sym2real.diagnosis.settings import SETTINGS
from sym2real.layout import Layout
from sym2real.logs.derive import SHORTEST, slope
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
        columns = {place: name for name, place in data.layouts.state.vector_places.items()}
        found = {
            velocity: position
            for velocity, position in _velocities(data.layouts.state).items()
            if all(_is_slope(trajectory, columns[position], columns[velocity]) for trajectory in data)
        }
        return cls(component_noise(data), found, data.dt)

    @classmethod
    def assumed(cls, sensors: Mapping[str, float], data: Dataset) -> SensorNoise:
        """Standard deviations by state field, for data without noise; velocities are slopes of positions."""
        layout = data.layouts.state
        deviation = [sensors.get(field.name, 0.0) for field in layout.fields for _ in range(field.tangent_size)]
        return cls(np.array(deviation), _velocities(layout), data.dt)

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


def _velocities(layout: Layout) -> dict[int, int]:
    """Tangent place of each velocity, with that of its position."""
    places = layout.vector_places
    return {places[f"v{name}"]: place for name, place in places.items() if f"v{name}" in places}


def _is_slope(trajectory: Trajectory, position: str, velocity: str) -> bool:
    logged = trajectory.column(velocity)
    missed = slope(trajectory.time, trajectory.column(position), SHORTEST) - logged
    return bool(np.std(missed[1:-1]) <= SETTINGS.same * max(float(np.std(logged)), 1e-9))
