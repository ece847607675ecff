"""A free body whose state is its pose in a plane, and wheels under it that roll without slip.

Of the contacts of the robot where it comes to rest, with the body's axes along the world's, those with friction hold:
J (v, q̇) = 0 for the velocity v = (forward, left, turning) of the body's origin and the rates q̇ of the joints. They give
q̇ = W v for every v that they leave. So a state of pose and velocity alone is also one of the wheels.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from copy import copy
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from sym2real.errors import ModelError
from sym2real.layout import Layout
from sym2real.robots import mjcf_columns as columns
from sym2real.robots.description import yaw_of
from sym2real.trajectory import Array
from sym2real.vocabulary import DRILLING, HEADING, TURNING_INERTIA, WRENCH, rate_per_speed, rate_per_turn, wheel_load

STATE = ("x", "y", "sin_yaw", "cos_yaw", "vx", "vy", "wz")
PLANAR_WRENCH = ("fx", "fy", "tz")
OF_FREE = (0, 1, 5)  # degrees of freedom of a free joint that lie in the plane
SLIP = 1e-3  # m/s at a contact per m/s or rad/s of the body: it may stand a little askew
AT_REST = 0.5  # s
NO_FRICTION = 1  # dimension of a contact that only pushes


def asked(state: Iterable[str] | None) -> bool:
    """Whether columns of a state are those of a robot in a plane.

    Raises:
        ModelError: for a heading among other columns.
    """
    wanted = tuple(state or ())
    if not {*wanted} & {*HEADING.columns}:
        return False
    if {*wanted} != {*STATE}:
        raise ModelError(f"expected {', '.join(STATE)} of a robot in a plane, found {', '.join(wanted)}")
    return True


def facing_x(model: mujoco.MjModel, data: Any) -> Any:
    """Data of a robot that is turned about z until it faces along the world's x, wherever a keyframe has it face.

    Raises:
        ModelError: for a robot without a free joint.
    """
    if columns.FREE not in model.jnt_type:
        raise ModelError("expected a free joint of a robot with a heading, found none")
    turned, place = copy(data), int(model.jnt_qposadr[np.argmax(model.jnt_type == columns.FREE)])
    half = -0.5 * yaw_of(data.qpos, place + 3)
    back = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
    mujoco.mju_mulQuat(turned.qpos[place + 3 : place + 7], back, data.qpos[place + 3 : place + 7])
    mujoco.mj_forward(model, turned)
    return turned


@dataclass(frozen=True, eq=False)
class Wheels:
    """What rolls with the body.

    Args:
        body: that moves freely.
        place, first: of its joint in qpos and in qvel.
        names: of the other joints.
        dofs: of them ``# (n,)``.
        rates: W: of the joints per speed forward, speed to the left and turning rate ``# (n, 3)``.
        moves: whether the contacts leave a speed forward, one to the left, and turning.
    """

    body: int
    place: int
    first: int
    names: tuple[str, ...]
    dofs: list[int]
    rates: Array
    moves: tuple[bool, bool, bool]

    @classmethod
    def of(cls, model: mujoco.MjModel, data: Any) -> Wheels:
        """Those of a compiled file, where its data stand, facing along x."""
        free = int(np.argmax(model.jnt_type == columns.FREE))
        body, place, first = (int(of[free]) for of in (model.jnt_bodyid, model.jnt_qposadr, model.jnt_dofadr))
        joints = [joint for joint in range(model.njnt) if joint != free]
        dofs = [int(model.jnt_dofadr[joint]) for joint in joints]
        sliding = _sliding(model, data)
        of_body, of_joints = sliding[:, [first + dof for dof in OF_FREE]], sliding[:, dofs]
        rates = -np.linalg.pinv(of_joints) @ of_body
        left = np.abs(of_body + of_joints @ rates).max(axis=0, initial=0.0)
        forward, aside, turning = (bool(slip < SLIP) for slip in left)
        names = tuple(model.joint(joint).name for joint in joints)
        return cls(body, place, first, names, dofs, rates, (forward, aside, turning))

    @property
    def steers_by_itself(self) -> bool:
        """Whether it can go forward and turn, and not aside: all wheels on one axle."""
        return self.moves == (True, False, True)

    @property
    def ways(self) -> Array:
        """Rates of the joints per speed forward and turning rate ``# (n, 2)``."""
        return self.rates[:, [0, 2]]

    def inertia(self, model: mujoco.MjModel, data: Any) -> Array:
        """What a speed forward and a turning rate move, wheels and all, kg, kg m and kg m² ``# (2, 2)``."""
        way = np.zeros((model.nv, 2))
        way[self.first + OF_FREE[0], 0] = way[self.first + OF_FREE[2], 1] = 1.0
        way[self.dofs] = self.ways
        return way.T @ columns.inertias(model, data) @ way

    def numbers(self, model: mujoco.MjModel, data: Any, actions: Mapping[str, str]) -> dict[str, float]:
        """What a torque on a joint moves, and how fast a servo of a wheel's rate turns it, by the names of a body's."""
        if not self.steers_by_itself:
            return {}
        carried, ways = np.linalg.inv(self.inertia(model, data)), dict(zip(self.names, self.ways, strict=True))
        numbers = {f"{name}_inertia": 1.0 / float(way @ carried @ way) for name, way in ways.items()}
        numbers |= {TURNING_INERTIA: float(self.inertia(model, data)[1, 1]), DRILLING: drilling(model, data)}
        pressed = _loads(model, data)
        numbers |= {
            wheel_load(name): pressed.get(int(model.jnt_bodyid[model.joint(name).id]), 0.0) for name in self.names
        }
        for actuator, column in actions.items():
            index = model.actuator(actuator).id
            joint = columns.driven_joint(model, index)
            if columns.command_kind(model, index) == "velocity" and joint in ways:
                ahead, turn = model.actuator_gear[index, 0] * ways[joint]
                numbers |= {rate_per_speed(column): float(ahead), rate_per_turn(column): float(turn)}
        return numbers


def _at_rest(model: mujoco.MjModel, data: Any) -> Any:
    """The robot once it has come to rest: of a wheel's two ends one alone may touch where a keyframe puts it."""
    resting = copy(data)
    mujoco.mj_step(model, resting, round(AT_REST / model.opt.timestep))
    return resting


def _sliding(model: mujoco.MjModel, data: Any) -> Array:
    """Velocity across what touches with friction per degree of freedom, m/s ``# (3 bodies, nv)``.

    At the surface of each body, which MuJoCo lets sink into the other: a wheel rolls by its own radius. Where a body
    touches at several points (a wheel's width on a floor), the mean of theirs: it drills about the middle.
    """
    patches: dict[tuple[int, ...], list[Array]] = {}
    resting = _at_rest(model, data)
    for contact in resting.contact:
        if contact.dim == NO_FRICTION:
            continue
        bodies, normal = tuple(model.geom_bodyid[contact.geom].tolist()), contact.frame[:3]
        across = np.zeros((3, model.nv))
        for body, side in zip(bodies, (-1.0, 1.0), strict=True):
            moved = np.zeros((3, model.nv))
            surface = contact.pos + side * contact.dist / 2 * normal + data.xpos[body] - resting.xpos[body]
            mujoco.mj_jac(model, data, moved, None, surface, body)
            across += side * moved
        patches.setdefault(bodies, []).append(across - np.outer(normal, normal @ across))
    means = [np.mean(points, axis=0) for points in patches.values()]
    return np.concatenate([np.zeros((0, model.nv)), *means])


def drilling(model: mujoco.MjModel, data: Any) -> float:
    """Torque in N m that brakes a turn: dry friction of bodies that touch at several points, about their middles."""
    patches: dict[tuple[int, ...], list[Array]] = {}
    for contact, pressed in _pressing(model, data):
        held = (contact.friction[0] if contact.dim > NO_FRICTION else 0.0) * pressed
        patches.setdefault(tuple(model.geom_bodyid[contact.geom]), []).append(np.append(contact.pos, held))
    points = (np.array(patch) for patch in patches.values())
    return float(sum(np.linalg.norm(p[:, :2] - p[:, :2].mean(axis=0), axis=1) @ p[:, 3] for p in points))


def _loads(model: mujoco.MjModel, data: Any) -> dict[int, float]:
    """What presses each body on others where the robot rests, N."""
    loads: dict[int, float] = {}
    for contact, pressed in _pressing(model, data):
        for body in model.geom_bodyid[contact.geom].tolist():
            loads[body] = loads.get(body, 0.0) + pressed
    return loads


def _pressing(model: mujoco.MjModel, data: Any) -> Iterator[tuple[Any, float]]:
    """Contacts of the robot at rest, and what presses both together at each, N."""
    resting, force = _at_rest(model, data), np.zeros(6)
    for number, contact in enumerate(resting.contact):
        mujoco.mj_contactForce(model, resting, number, force)
        yield contact, float(force[0])


def inputs_of(model: mujoco.MjModel) -> Layout:
    """External forces: force and torque in the plane, and a torque along every joint."""
    fields = (field for field in columns.inputs_of(model).fields if field.columns[0] not in WRENCH)
    return Layout.of(PLANAR_WRENCH) + Layout(tuple(fields))


@dataclass(frozen=True, eq=False)
class PlanarCoordinates:
    """States of the plane in MuJoCo's coordinates, and back.

    Args:
        wheels: what rolls.
        standing: qpos where it stands, with its axes along the world's ``# (nq,)``.
        velocities: number of degrees of freedom.
    """

    wheels: Wheels
    standing: Array
    velocities: int

    def to_state(self, qpos: Array, qvel: Array) -> Array:
        """States ``# (..., 7)``."""
        place, first = self.wheels.place, self.wheels.first
        yaw = yaw_of(qpos, place + 3)
        parts = (qpos[..., place], qpos[..., place + 1], np.sin(yaw), np.cos(yaw))
        return np.stack([*parts, *(qvel[..., first + dof] for dof in OF_FREE)], axis=-1)

    def to_coordinates(self, state: Array) -> tuple[Array, Array]:
        """qpos ``# (nq,)`` and qvel ``# (nv,)``; the wheels roll."""
        x, y, sine, cosine, vx, vy, turning = state
        half, place, first = 0.5 * np.arctan2(sine, cosine), self.wheels.place, self.wheels.first
        qpos, qvel = self.standing.copy(), np.zeros(self.velocities)
        qpos[place : place + 2] = x, y
        turn = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
        mujoco.mju_mulQuat(qpos[place + 3 : place + 7], turn, self.standing[place + 3 : place + 7])
        qvel[[first + dof for dof in OF_FREE]] = vx, vy, turning
        body = (vx * cosine + vy * sine, vy * cosine - vx * sine, turning)
        qvel[self.wheels.dofs] = self.wheels.rates @ body
        return qpos, qvel
