"""Logs and what models predict of them as a recording for the Rerun viewer (https://rerun.io): curves, paths, ghosts.

Every log is a tree of its own. The measured robot is drawn as its geometries stand in its description, each model's as
a wire frame that starts anew from the measured state every 0.8 s, as the curves of a report do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis import ROWS
from sym2real.diagnosis.data.preparation import prepared
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.errors import needing
from sym2real.files import whole
from sym2real.layout import Layout
from sym2real.logs.pose import poses
from sym2real.plants.geometry import Geometry
from sym2real.report.html.predictions import Starts
from sym2real.report.html.signals import signal_units, signals
from sym2real.report.html.variants import Predicting
from sym2real.trajectory import Array

MEASURED, TIMELINE = "measured", "log_time"
AXES = 0.1  # m, of the frames that are drawn: seen on a robot of a hand's size and on one of an arm's


def write_rerun(
    path: str | Path, data: Dataset, models: Mapping[str, Predicting], robot: Sequence[Geometry] = ()
) -> Path:
    """Write what was measured and what models predict.

    Args:
        path: of the file, ``.rrd``.
        data: logs.
        models: equations or models that predict in float64, by the name that the viewer is to show.
        robot: how it is drawn; frames alone without it.

    Raises:
        MissingDependencyError: without the extra ``rerun``.
        DataError: when there is no writing there.
        ShapeError: when a model's columns or time step are not those of the logs.
    """
    with needing("a recording for Rerun needs", "rerun"):
        import rerun
    states = {MEASURED: [log.state for log in data]} | {name: _predicted(model, data) for name, model in models.items()}
    with whole(path) as beside:
        stream = rerun.RecordingStream("sym2real")
        stream.save(beside)
        for number, log in enumerate(data):
            tree = _Tree(rerun, stream, log.name or f"log {number + 1}", log.time)
            for name, along in states.items():
                tree.send(name, data.layouts.state, along[number], robot)
        stream.disconnect()
    return Path(path)


def _predicted(model: Predicting, data: Dataset) -> list[Array]:
    """By log, states in pieces of 0.8 s ``# (rows, state)``; not a number between them."""
    steps = max(1, min(round(JUDGED_AT / data.dt), max(len(log) for log in data) - ROWS))
    starts = Starts.of(data, steps)
    return starts.along(starts.predicted(*prepared(model, data)))


@dataclass(frozen=True)
class _Tree:
    """What the viewer shows of one log."""

    rerun: ModuleType
    stream: Any
    name: str
    time: Array

    def send(self, name: str, layout: Layout, states: Array, robot: Sequence[Geometry]) -> None:
        """Curves and, where the state has a pose, the moving robot."""
        index = [self.rerun.TimeColumn(TIMELINE, duration=self.time)]
        for signal, values in zip(signal_units(layout), signals(layout, states).T, strict=True):
            scalars = self.rerun.Scalars.columns(scalars=values)
            self.stream.send_columns(self._place("signals", signal, name), index, scalars)
        found = poses(layout, states)
        if found is None:
            return
        body, (position, attitude) = self._place("world", name), found
        moved = self.rerun.Transform3D.columns(translation=position, quaternion=_x_to_w(attitude))
        self.stream.send_columns(body, index, moved)
        self.stream.log(body, self.rerun.TransformAxes3D(AXES), static=True)
        path = self.rerun.LineStrips3D(_pieces(position))
        self.stream.log(self._place("world", "path", name), path, static=True)
        self._draw(name, robot)

    def _place(self, *parts: str) -> str:
        return str(self.rerun.new_entity_path([self.name, *parts]))

    def _draw(self, name: str, robot: Sequence[Geometry]) -> None:
        kinds = self.rerun.components.FillMode
        fill = kinds.Solid if name == MEASURED else kinds.MajorWireframe
        for part in robot:
            about = {
                "centers": [part.centre],
                "quaternions": _x_to_w(part.attitude[None]),
                "colors": [(255 * part.colour).astype(np.uint8)],
                "fill_mode": fill,
            }
            if part.shape == "ellipsoid":
                drawn = self.rerun.Ellipsoids3D(half_sizes=[part.half_sizes], **about)
            elif part.shape == "cylinder":
                length, radius = 2 * part.half_sizes[2], part.half_sizes[0]
                drawn = self.rerun.Cylinders3D(lengths=[length], radii=[radius], **about)
            else:
                drawn = self.rerun.Boxes3D(half_sizes=[part.half_sizes], **about)
            self.stream.log(self._place("world", name, part.name), drawn, static=True)


def _x_to_w(quaternions: Array) -> Array:
    """Quaternions w x y z ``# (N, 4)`` in the viewer's order."""
    return np.roll(quaternions, -1, axis=1)


def _pieces(path: Array) -> list[Array]:
    """The pieces of a path ``# (rows, 3)`` between rows that are no numbers."""
    there = ~np.isnan(path[:, 0])
    ends = np.flatnonzero(np.diff(there)) + 1
    return [piece for piece, known in zip(np.split(path, ends), np.split(there, ends), strict=True) if known[0]]
