"""From a motion capture system's axes to the world's: x forward, y left, z up, in m."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from sym2real.errors import ShapeError
from sym2real.trajectory import Array

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Frame:
    """Which of the system's axes are the world's x, y and z, then a turn about z and a shift.

    Args:
        axes: each "x", "y" or "z", with a minus where it is turned round; ("x", "-z", "y") where y points upward.
        yaw: of the system's turned axes in the world, rad.
        origin: of the system in the world, m.
        scale: m per unit of the system.

    Raises:
        ShapeError: for axes that are no right-handed frame, or numbers that are not finite.
    """

    axes: tuple[str, str, str] = ("x", "y", "z")
    yaw: float = 0.0
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    scale: float = 1.0

    def __post_init__(self) -> None:
        rows = [_axis(name) for name in self.axes]
        if None in rows or not math.isclose(float(np.linalg.det(np.array(rows, dtype=np.float64))), 1.0):
            raise ShapeError(
                f"expected three axes of a right-handed frame, such as x -z y, found {' '.join(self.axes)}"
            )
        if not np.isfinite([self.yaw, *self.origin]).all() or not 0.0 < self.scale < math.inf:
            raise ShapeError("expected a finite yaw and origin, and a scale > 0")

    @cached_property
    def rotation(self) -> Rotation:
        """Turns a vector of the system into the world."""
        return Rotation.from_euler("z", self.yaw) * Rotation.from_matrix([_axis(name) for name in self.axes])

    def position(self, seen: Array) -> Array:
        """A point of the system ``# (3,)`` in the world, m."""
        placed: Array = self.rotation.apply(self.scale * seen) + np.array(self.origin)
        return placed

    def attitude(self, seen: Array) -> Array:
        """A body's attitude in the system, quaternion w x y z ``# (4,)``, in the world."""
        turned: Array = (self.rotation * Rotation.from_quat(seen, scalar_first=True)).as_quat(scalar_first=True)
        return turned


def heading(attitude: Array) -> float:
    """Yaw in rad of a quaternion w x y z, body→world ``# (4,)``, of any length."""
    w, x, y, z = attitude.tolist()
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)


def _axis(name: str) -> tuple[float, ...] | None:
    along = AXES.get(name.removeprefix("-"))
    return None if along is None else tuple((-1.0 if name.startswith("-") else 1.0) * value for value in along)
