"""Ready differences from the plain robot, by the simulator's own means.

Each function returns a :class:`~sym2real.protocols.Change` for :class:`~sym2real.plants.MujocoPlant`. The robot is the
first body of the description.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sym2real.protocols import Change
from sym2real.robots.robot import GRAVITY


def constant_force(fx: float = 0.0, fy: float = 0.0, fz: float = 0.0) -> Change:
    """A steady force in N along world axes at the robot's centre of mass: wind."""

    def force(model: Any, data: Any) -> None:
        data.xfrc_applied[1, :3] += (fx, fy, fz)

    return Change(f"constant force ({fx:g}, {fy:g}, {fz:g}) N", force=force)


def inertial_offset(rx: float = 0.0, ry: float = 0.0, rz: float = 0.0) -> Change:
    """The centre of mass moved by an offset in m along body axes.

    The body frame, the thrust line and the axes of the rate loop stay; so does the inertia about the centre of mass.
    """

    def edit(spec: Any) -> None:
        plain, body = spec.copy().compile(), spec.worldbody.first_body()
        body.explicitinertial = True
        body.mass = plain.body_mass[1]
        body.inertia = plain.body_inertia[1]
        body.iquat = plain.body_iquat[1]
        body.ipos = plain.body_ipos[1] + (rx, ry, rz)

    return Change(f"centre of mass moved by ({rx:g}, {ry:g}, {rz:g}) m", edit=edit)


def tilted_gravity(gx: float = 0.0, gy: float = 0.0) -> Change:
    """Gravity with components in m/s² along the world's x and y, its size unchanged: a slope under a car."""

    def edit(spec: Any) -> None:
        spec.option.gravity = (gx, gy, -np.sqrt(GRAVITY**2 - gx**2 - gy**2))

    return Change(f"gravity tilted by ({gx:g}, {gy:g}) m/s²", edit=edit)
