"""Roll and pitch of an attitude, or of its command, that are not what they are called."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from sym2real import rotation
from sym2real.diagnosis.data.changed import with_columns
from sym2real.diagnosis.faults.mistakes.transformation import HEADING, QUATERNION, Exchanged
from sym2real.logs.derive import continuous
from sym2real.logs.sources import ANGLES, AsRead
from sym2real.trajectory import Array, Trajectory

COMMANDED = "_cmd"


@dataclass(frozen=True)
class OfAttitude(Exchanged):
    """Roll and pitch of an attitude in each other's place, or with the other sign.

    Args:
        quaternion: the attitude's columns; those that are exchanged are angles.
    """

    quaternion: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Which angles, of what was measured or of what was commanded."""
        of = "attitude" if self.quaternion == QUATERNION else "commanded attitude"
        return f"{super().name} in the {of}"

    def fix(self, read: AsRead) -> str:
        """What to change, in the angles that the log has, or in those that its quaternion is made of."""
        if all(own in read.sources for own in self.columns):
            return super().fix(read)
        return f"put them right where {' '.join(read.columns(self.quaternion))} are made of angles{AsRead().frame}"

    def undone(self, log: Trajectory) -> Trajectory:
        """With every angle in its own place."""
        attitude = np.stack([log.column(name) for name in self.quaternion], axis=1)
        angles = rotation.to_euler(torch.as_tensor(attitude)).clone()
        first, places = angles.clone(), [ANGLES.index(own.removesuffix(COMMANDED)) for own in self.columns]
        for place, source, sign in zip(places, self.sources, self.signs, strict=True):
            angles[:, ANGLES.index(source.removesuffix(COMMANDED))] = sign * first[:, place]
        return with_angles(log, angles.numpy(), self.quaternion)


def with_angles(log: Trajectory, angles: Array, quaternion: Sequence[str] = QUATERNION) -> Trajectory:
    """A log with other roll, pitch and yaw of a quaternion, or another yaw, in rad ``# (rows, 3 or 1)``."""
    if angles.shape[1] == 1:
        return with_columns(log, dict(zip(HEADING, (np.sin(angles[:, 0]), np.cos(angles[:, 0])), strict=True)))
    turned = rotation.from_euler(*torch.as_tensor(angles).unbind(-1)).numpy()
    return with_columns(log, dict(zip(quaternion, continuous(turned).T, strict=True)))
