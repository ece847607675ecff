"""Robots of a user's own, which no registry knows: what their equations carry, and the robot that this makes again."""

from functools import cache
from pathlib import Path
from typing import Protocol

import mujoco
import numpy as np

from sym2real.inertias import write_inertia
from sym2real.robots.description import is_text, spec_of
from sym2real.robots.mjcf_columns import failures_of
from sym2real.robots.robot import Robot
from sym2real.symbolic.serialise import Origin
from sym2real.trajectory import Array


class OfRobot(Protocol):
    """What may say which robot it is of: equations, networks."""

    @property
    def robot(self) -> str:
        """Name of the robot; empty where it is not known."""


def robot_of(model: OfRobot) -> Robot | None:
    """The robot that a model is of: the one that it carries, else the registered one of its name; None without.

    Raises:
        ModelError: for a carried description that is none.
    """
    from sym2real.robots import ROBOTS  # noqa: PLC0415 — the registry opens this module's robots too

    origin = getattr(model, "origin", None)
    return robot_from(origin) if origin is not None else ROBOTS.get(model.robot)


@cache
def robot_from(origin: Origin) -> Robot:
    """The robot that was made from this, always the same one.

    Raises:
        ModelError, UnknownNameError: as of :func:`sym2real.robots.from_mjcf.from_mjcf`.
    """
    return Robot.from_mjcf(
        origin.mjcf,
        name=origin.name,
        actions=dict(origin.actions),
        state=origin.state,
        dt=origin.dt,
        numbers=dict(origin.numbers),
        title=origin.title,
    )


def origin_of(robot: Robot) -> Origin | None:
    """What makes the robot again; None for one that the package has, or that is not from an MJCF alone.

    None too where the description cannot do without files beside it: meshes can, fields of heights cannot.

    Raises:
        ModelError: when MuJoCo cannot write the bodies without their meshes.
    """
    mjcf, actuators = robot.description.mjcf, robot.description.actuators
    if not actuators or _is_registered(robot):
        return None
    with failures_of(mjcf, "an MJCF that can be written without its meshes"):
        text = mjcf if is_text(mjcf) else alone(mjcf)
    if text is None:
        return None
    numbers = tuple((name, float(value)) for name, value in robot.numbers.items())
    return Origin(
        text, robot.name, robot.title, tuple(actuators.items()), robot.layouts.state.columns, robot.dt, numbers
    )


def _is_registered(robot: Robot) -> bool:
    """Whether the package finds it by its name."""
    from sym2real.robots import ROBOTS  # noqa: PLC0415 — as above

    known = ROBOTS.get(robot.name)
    if known is None or Path(known.description.mjcf).parent != Path(__file__).parent:
        return False
    same = (known.description.mjcf, known.layouts, known.dt)
    return same == (robot.description.mjcf, robot.layouts, robot.dt)


def alone(mjcf: str) -> str | None:
    """An MJCF of the same bodies and contacts that needs no include, mesh or picture; None where it needs more.

    Every body's inertia is written out, and what touches stays: MuJoCo lets a mesh touch with its convex hull.
    """
    spec = spec_of(mjcf)
    model = spec.compile()
    for body in spec.bodies:
        if model.body_mass[body.id] > 0:
            write_inertia(body, model)
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.compiler.discardvisual = bool(spec.meshes or spec.textures or spec.skins)
    # New ones: a mesh that was compiled keeps the normals of all its faces, which a hull's do not fit.
    hulls = {mesh.name: _hull(model, mesh.id) for mesh in spec.meshes if model.mesh_graphadr[mesh.id] >= 0}
    for geom in [geom for geom in spec.geoms if geom.meshname and geom.meshname not in hulls]:
        spec.delete(geom)  # touches nothing
    for mesh in spec.meshes:
        spec.delete(mesh)
    for name, corners in hulls.items():
        spec.add_mesh(name=name, uservert=corners.ravel())
    spec.compile()
    text = spec.to_xml()
    return None if 'file="' in text else text


def _hull(model: mujoco.MjModel, mesh: int) -> Array:
    """Corners of a mesh's convex hull where the file has them, m ``# (corners, 3)``."""
    first, turn = model.mesh_vertadr[mesh], np.empty(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[mesh])
    # Of the graph: the number of corners, that of faces, a place for each corner, the corners.
    graph = model.mesh_graph[model.mesh_graphadr[mesh] :]
    corners = model.mesh_vert[first + graph[2 + graph[0] : 2 + 2 * graph[0]]]
    hull: Array = corners @ turn.reshape(3, 3).T + model.mesh_pos[mesh]
    return hull
