"""What brakes, holds and drives the joints of a compiled MJCF, by its dampers, springs and actuators."""

from collections.abc import Sequence

import mujoco
import numpy as np

from sym2real.robots.mjcf_columns import BY_JOINT, driven_joint
from sym2real.trajectory import Array


def braking(model: mujoco.MjModel) -> Array:
    """Damping of every degree of freedom with its servos' gains of the rate, N s/m or N m s ``# (nv,)``."""
    return _with_servos(model, model.dof_damping, 2)


def springing(model: mujoco.MjModel) -> Array:
    """Stiffness of every degree of freedom with its servos' gains of the place, N/m or N m ``# (nv,)``."""
    stiffness = np.zeros(model.nv)
    stiffness[model.jnt_dofadr] = model.jnt_stiffness
    return _with_servos(model, stiffness, 1)


def _with_servos(model: mujoco.MjModel, own: Array, bias: int) -> Array:
    whole: Array = np.array(own, dtype=np.float64)
    for index in np.flatnonzero(model.actuator_trntype == BY_JOINT):
        dof = model.jnt_dofadr[model.actuator_trnid[index, 0]]
        whole[dof] -= model.actuator_biasprm[index, bias] * model.actuator_gear[index, 0] ** 2
    return whole


def strengths(model: mujoco.MjModel, actuators: Sequence[int], most: Array) -> dict[str, float]:
    """Largest force on each joint J of actuators under so much command ``# (action,)``: ``J_strength``, N or N m."""
    forces: dict[str, float] = {}
    for index, command in zip(actuators, most, strict=True):
        if joint := driven_joint(model, index):
            limit = np.abs(model.actuator_forcerange[index]).max() if model.actuator_forcelimited[index] else np.inf
            force = abs(model.actuator_gear[index, 0]) * min(limit, abs(model.actuator_gainprm[index, 0] * command))
            forces[f"{joint}_strength"] = forces.get(f"{joint}_strength", 0.0) + float(force)
    return forces
