"""A log's manoeuvre once more: the path that a controller is to follow, and the commands as they were sent."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import ArrayLike
from scipy.ndimage import uniform_filter1d
from torch import Tensor

from sym2real.protocols import Memoryless
from sym2real.trajectory import Array, Trajectory

SMOOTHING = 9  # rows over which a path is smoothed


@dataclass(frozen=True)
class Replayed(Memoryless):
    """A controller that sends again what was sent, whatever the state.

    Args:
        commands: by step ``# (steps, action)``.
    """

    commands: Array

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """The command of a step ``# (action,)``."""
        sent: Array = self.commands[step]
        return sent


def path_of(log: Trajectory) -> Tensor:
    """Full reference state along a log ``# (rows, state)``: its columns ``ref_…``, the smoothed path for the others."""
    layout = log.layouts.state
    path = uniform_filter1d(log.state, SMOOTHING, axis=0, mode="nearest")
    coordinate_of = {rate: coordinate for coordinate, rate in layout.rates.items()}
    if all(f"ref_{column}" in log.extra for field in layout.placing for column in field.columns):
        for column in layout:
            place = layout.index(column)
            if f"ref_{column}" in log.extra:
                path[:, place] = log.extra[f"ref_{column}"]
            elif f"ref_{coordinate_of.get(column)}" in log.extra:
                path[:, place] = np.gradient(log.extra[f"ref_{coordinate_of[column]}"], log.time)
    return layout.normalise(torch.as_tensor(path))
