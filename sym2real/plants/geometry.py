"""What a robot looks like at rest: the geometries of its description, for whoever draws it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from sym2real.plants.mujoco_plant import MujocoPlant
from sym2real.trajectory import Array

Shape = Literal["ellipsoid", "cylinder", "box"]
ROOT = 1  # the first body of a MuJoCo model; 0 is the world
ROUND: dict[int, Shape] = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
}


@dataclass(frozen=True, eq=False)
class Geometry:
    """One geometry in the axes of the first body.

    Args:
        name: of the description, or its number.
        shape: a box also for what has a shape of its own: a capsule, a mesh.
        centre: m ``# (3,)``.
        attitude: quaternion w x y z ``# (4,)``.
        half_sizes: m, along the geometry's own axes ``# (3,)``.
        colour: red, green, blue, opacity, from 0 to 1 ``# (4,)``.
    """

    name: str
    shape: Shape
    centre: Array
    attitude: Array
    half_sizes: Array
    colour: Array


def geometries(plant: MujocoPlant) -> list[Geometry]:
    """The geometries of the first body and of all that hangs on it, joints at rest."""
    model, rest = plant.mj_model, mujoco.MjData(plant.mj_model)
    mujoco.mj_kinematics(model, rest)
    axes, geometries = rest.xmat[ROOT].reshape(3, 3), []
    for number in np.flatnonzero(model.body_rootid[model.geom_bodyid] == ROOT):
        attitude, turn = np.empty(4), axes.T @ rest.geom_xmat[number].reshape(3, 3)
        mujoco.mju_mat2Quat(attitude, turn.ravel())
        centre, half_sizes = np.split(model.geom_aabb[number], 2)
        geometries.append(
            Geometry(
                name=model.geom(number).name or f"geometry {number}",
                shape=ROUND.get(int(model.geom_type[number]), "box"),
                centre=axes.T @ (rest.geom_xpos[number] - rest.xpos[ROOT]) + turn @ centre,
                attitude=attitude,
                half_sizes=half_sizes,
                colour=model.geom_rgba[number].astype(np.float64),
            )
        )
    return geometries
