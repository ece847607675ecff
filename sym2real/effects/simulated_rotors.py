"""Rotors of a simulated rotorcraft: actuators of their own, or what a thrust and three torques ask of four of them."""

from typing import Any

import numpy as np

from sym2real.effects.body import Body
from sym2real.effects.truth import placed
from sym2real.errors import ModelError
from sym2real.trajectory import Array
from sym2real.vocabulary import MOTOR_COLUMNS, MOTORS


def require_rotors(spec: Any) -> None:
    """Refuse an ``MjSpec`` without motors of its own.

    Raises:
        ModelError: where the robot is described by a thrust and a rate loop.
    """
    if sum(actuator.name in MOTOR_COLUMNS for actuator in spec.actuators) < len(MOTORS):
        raise ModelError(f"the simulated robot has no actuators named {', '.join(MOTORS)}: it has a rate loop")


def _rotors(model: Any) -> list[int]:
    """Actuators that are rotors of their own; none of a robot with a rate loop."""
    return [index for index in range(model.nu) if model.actuator(index).name in MOTOR_COLUMNS]


def stands(model: Any, rotor: int) -> tuple[Array, Array]:
    """Where a rotor's site stands in the body frame, m ``# (3,)``, and its axes there ``# (3, 3)``.

    It may be on an arm that is a body of its own.
    """
    site = model.actuator_trnid[rotor, 0]
    return placed(model, model.site_bodyid[site], model.site_pos[site], model.site_quat[site])


def places(model: Any, body: Body) -> Array:
    """Rotors in the body frame in m; behind a rate loop the first front right, clockwise from above ``# (n, 3)``."""
    if rotors := _rotors(model):
        return np.array([stands(model, rotor)[0] for rotor in rotors])
    angle = np.deg2rad([-45.0, -135.0, 135.0, 45.0])
    return body.number("arm") * np.array([np.cos(angle), np.sin(angle), np.zeros(4)]).T


def reactions(model: Any, body: Body) -> Array:
    """Torque about body z per thrust of every rotor in m ``# (n,)``."""
    if rotors := _rotors(model):
        own: Array = model.actuator_gear[rotors, 5] / model.actuator_gear[rotors, 2]
        return own
    return body.number("torque_per_thrust") * np.array([-1.0, 1.0, -1.0, 1.0])


def thrusts(model: Any, data: Any, body: Body) -> Array:
    """What every rotor gives now, N ``# (n,)``: what its actuator does, or what all actuators together ask of it."""
    if rotors := _rotors(model):
        own: Array = data.actuator_force[rotors] * model.actuator_gear[rotors, 2]
        return own
    along = places(model, body)
    mixer = np.stack([np.ones(4), along[:, 1], -along[:, 0], reactions(model, body)])
    return np.linalg.solve(mixer, np.array(data.actuator_force[:4]))
