"""Thrust in N to the firmware's unsigned 16-bit number, and back.

The firmware's releases differ by 31 % in what a number means, so the map is named, or calibrated from a hover::

    counts = k · thrust / gain
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from sym2real.errors import ShapeError
from sym2real.registry import Registry
from sym2real.robots.robot import GRAVITY

FULL_SCALE = 65535
MOST_CHANGE = 2.0  # times: all releases and motors lie within 1.8; a slip of the decimal point would fly at full thrust


@dataclass(frozen=True)
class Counts:
    """What is sent for a thrust: the number, and whether the thrust was out of the map's reach."""

    value: int
    saturated: bool


@dataclass(frozen=True)
class ThrustMap:
    """Counts per Newton of total thrust, up to a greatest count.

    Args:
        name: where it comes from.
        per_newton: counts per N.
        most: greatest count.

    Raises:
        ShapeError: for numbers that no map has.
    """

    name: str
    per_newton: float
    most: int = 60000

    def __post_init__(self) -> None:
        if not 0.0 < self.per_newton < math.inf:
            raise ShapeError(f"thrust map {self.name!r}: expected counts per N > 0, found {self.per_newton!r}")
        if not 0 < self.most <= FULL_SCALE:
            raise ShapeError(
                f"thrust map {self.name!r}: expected a greatest count up to {FULL_SCALE}, found {self.most}"
            )

    def counts(self, thrust: float) -> Counts:
        """What to send for a thrust in N.

        Raises:
            ShapeError: for a thrust that is no number.
        """
        if math.isnan(thrust):
            raise ShapeError("expected a thrust in N, found NaN")
        wanted = thrust * self.per_newton
        if not 0.0 <= wanted < self.most + 0.5:
            return Counts(0 if wanted < 0.0 else self.most, True)
        return Counts(round(wanted), False)

    def newtons(self, counts: int) -> float:
        """The thrust in N that a count stands for."""
        return counts / self.per_newton

    @property
    def greatest(self) -> float:
        """Greatest thrust in N."""
        return self.most / self.per_newton

    def calibrated(self, mass: float, hover_counts: float) -> ThrustMap:
        """The map by which this mass in kg weighs what it was seen to hover at, as a mean count.

        Raises:
            ShapeError: for a mass or a count that nothing hovers at, or that is far from this map.
        """
        if not (0.0 < mass < math.inf and 0.0 < hover_counts <= self.most):
            raise ShapeError(f"expected a mass and counts up to {self.most} > 0, found {mass!r} kg at {hover_counts!r}")
        return self._changed("from hover", hover_counts / (mass * GRAVITY) / self.per_newton)

    def corrected(self, gain: float) -> ThrustMap:
        """The map after ``gain:thrust`` of a diagnosis: the robot gives so many times the thrust that was asked.

        Raises:
            ShapeError: for a gain that is not positive, or far from 1.
        """
        if not 0.0 < gain < math.inf:
            raise ShapeError(f"expected a gain of thrust > 0, found {gain!r}")
        return self._changed(f"gain {gain:.4g}", 1.0 / gain)

    def _changed(self, how: str, times: float) -> ThrustMap:
        if not 1.0 / MOST_CHANGE <= times <= MOST_CHANGE:
            raise ShapeError(
                f"thrust map {self.name!r}, {how}: expected at most {MOST_CHANGE:g} times more or less counts per N, "
                f"found {times:.3g} times: is it the right map, in kg and counts?"
            )
        return replace(self, name=f"{self.name}, {how}", per_newton=times * self.per_newton)


# Counts per N by what the firmware does with them; the releases from 2025.09 on know the upgraded motors.
THRUST_MAPS: Mapping[str, ThrustMap] = Registry(
    "thrust map",
    {
        name: ThrustMap(name, per_newton, most)
        for name, per_newton, most in (
            ("paper", 132000.0, 60000),
            ("2025.02", 111342.0, FULL_SCALE),
            ("2025.09", 145633.0, FULL_SCALE),
            ("2025.09-upgrade", 100823.0, FULL_SCALE),
            ("2026.04", 136531.0, FULL_SCALE),
            ("2026.04-upgrade", 91021.0, FULL_SCALE),
            ("2026.04-brushless", 81919.0, FULL_SCALE),
        )
    },
)
