"""Hexarotor of 1.5 kg whose six motors are commanded, each from 0 to 1; no loop flies it but the controller's."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sym2real.robots.from_mjcf import WEIGHTS, from_mjcf
from sym2real.robots.recipe import Recipe

if TYPE_CHECKING:
    from sym2real.symbolic import Equations

MASS, INERTIA = 1.5, (0.02, 0.021, 0.036)  # kg, kg m²
THRUST = 5.0  # N of one rotor at full command
ARM, TORQUE_PER_THRUST = 0.25, 0.016  # m
ANGLES = (0.0, 60.0, 120.0, 180.0, 240.0, 300.0)  # degrees, from x towards y
SPIN = (-1, 1, -1, 1, -1, 1)


def _rigid_body() -> Equations:
    from sym2real.robots.motors import Motors  # noqa: PLC0415 — SymPy stays out of light imports
    from sym2real.robots.nominal_quadrotor import quadrotor  # noqa: PLC0415

    motors = Motors(THRUST, torque_per_thrust=TORQUE_PER_THRUST, arm=ARM, spin=SPIN, angles=ANGLES)
    return quadrotor(MASS, INERTIA, interface="motors", motors=motors, dt=0.02)


HEXAROTOR = from_mjcf(
    Path(__file__).with_suffix(".xml"),
    title="Hexarotor",
    recipe=Recipe(
        tasks=(("hover", {}), ("circle", {})),
        base="nominal",
        dither=(0.01,) * len(SPIN),
        dependencies=tuple(("vz", f"motor{number}") for number in range(1, len(SPIN) + 1)),
        cost_weights=WEIGHTS,
    ),
    numbers={
        **dict(zip(("jx", "jy", "jz"), INERTIA, strict=True)),
        "arm": ARM,
        "torque_per_thrust": TORQUE_PER_THRUST,
    },
    rigid_body=_rigid_body,
)
