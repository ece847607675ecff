"""Rotors of a simulated quadrotor: actuators of their own, or what a thrust and three torques ask of four of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from sym2real.effects.body import Body
from sym2real.errors import ModelError
from sym2real.layout import MOTORS
from sym2real.trajectory import Array


def rotor_sites(spec: Any) -> list[tuple[Any, Any]]:
    """The actuator of every motor in an ``MjSpec``, with the site that it pushes at.

    Raises:
        ModelError: where the robot is described by a thrust and a rate loop.
    """
    found = [actuator for actuator in spec.actuators if actuator.name in MOTORS]
    if len(found) != len(MOTORS):
        raise ModelError(f"the simulated robot has no actuators named {', '.join(MOTORS)}: it has a rate loop")
    return [(actuator, spec.site(actuator.target)) for actuator in found]


def places(body: Body) -> Array:
    """Rotors in the body frame in m, the first front right, the others clockwise from above ``# (4, 3)``."""
    angle = np.deg2rad([-45.0, -135.0, 135.0, 45.0])
    found: Array = body.number("arm") * np.array([np.cos(angle), np.sin(angle), np.zeros(4)]).T
    return found


def reactions(body: Body) -> Array:
    """Torque about body z per thrust of every rotor in m ``# (4,)``."""
    found: Array = body.number("torque_per_thrust") * np.array([-1.0, 1.0, -1.0, 1.0])
    return found


def pushes(model: Any, data: Any, body: Body) -> Array:
    """What every rotor gives now, N ``# (4,)``: what its actuator does, or what all actuators together ask of it."""
    if model.actuator(0).name == MOTORS[0]:
        own: Array = np.array([float(data.actuator(name).force[0]) for name in MOTORS])
        return own
    along = places(body)
    mixer = np.stack([np.ones(4), along[:, 1], -along[:, 0], reactions(body)])
    asked: Array = np.linalg.solve(mixer, np.array(data.actuator_force[:4]))
    return asked
