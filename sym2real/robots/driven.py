"""What brakes and drives the joints of a compiled MJCF, by its dampers and actuators."""

from collections.abc import Sequence

import mujoco
import numpy as np

from sym2real.robots.mjcf_columns import BY_JOINT, driven_joint
from sym2real.trajectory import Array


def braking(model: mujoco.MjModel) -> Array:
    """Damping of every degree of freedom with its servos' gains of the rate, N s/m or N m s ``# (nv,)``."""
    damping: Array = np.array(model.dof_damping, dtype=np.float64)
    for index in np.flatnonzero(model.actuator_trntype == BY_JOINT):
        dof = model.jnt_dofadr[model.actuator_trnid[index, 0]]
        damping[dof] -= model.actuator_biasprm[index, 2] * model.actuator_gear[index, 0] ** 2
    return damping


def strengths(model: mujoco.MjModel, actuators: Sequence[int], most: Array) -> dict[str, float]:
    """Largest force on each joint J of actuators under so much command ``# (action,)``: ``J_strength``, N or N m."""
    forces: dict[str, float] = {}
    for index, command in zip(actuators, most, strict=True):
        if joint := driven_joint(model, index):
            limit = np.abs(model.actuator_forcerange[index]).max() if model.actuator_forcelimited[index] else np.inf
            force = abs(model.actuator_gear[index, 0]) * min(limit, abs(model.actuator_gainprm[index, 0] * command))
            forces[f"{joint}_strength"] = forces.get(f"{joint}_strength", 0.0) + float(force)
    return forces
