"""The tree of joints of a compiled MJCF: each with its frame, its numbers, and the inertia that moves with it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np
from sympy import Expr, Float, Integer

from sym2real.robots import mjcf_columns as columns
from sym2real.robots.link_quantities import link_quantities
from sym2real.robots.spatial import Inertia, Motion, Transform, Values, about, exact
from sym2real.symbolic import symbol
from sym2real.vocabulary import UNLIMITED, MechanicalQuantity, quantity_of


@dataclass(frozen=True, eq=False)
class Link:
    """One joint, and what moves with it.

    Args:
        joint: its name.
        parent: number of the link that carries it; -1 for the ground.
        fixed: from the parent's axes to the joint's, with the joint at ``zero``.
        axis: of the joint in the link's axes ``# (3,)``.
        turns: whether it is a hinge.
        inertia: of the bodies that move with it, in the link's axes about its origin.
        zero: coordinate at which the bodies lie as the file places them (its ``ref``), rad or m.
        armature: of the joint, kg m² or kg.
        rest: where its spring rests, rad or m.
        quantities: what equations hold of it by name, for effects to change: armature, damping, drag, dry friction,
            stiffness, its servo's gain.
    """

    joint: str
    parent: int
    fixed: Transform
    axis: Values
    turns: bool
    inertia: Inertia
    zero: float
    armature: float
    rest: float
    quantities: Mapping[str, Expr]

    def transform(self, coordinate: Expr) -> Transform:
        """From the parent's axes to the link's where the joint stands."""
        moved = coordinate - as_expression(self.zero)
        if not self.turns:
            return Transform(self.fixed.turn, self.fixed.place + self.fixed.turn.T @ (self.axis * moved))
        return Transform(about(self.axis, moved).T @ self.fixed.turn, self.fixed.place)

    @property
    def motion(self) -> Motion:
        """Of a unit rate of the joint."""
        zero = np.zeros(3, dtype=int).astype(object)
        return np.concatenate([self.axis, zero] if self.turns else [zero, self.axis])


def links_of(model: mujoco.MjModel) -> list[Link]:
    """Joints in MuJoCo's order, each with the bodies that move with it; several joints of a body follow each other."""
    links: list[Link] = []
    # Of every body: the link that carries it, and the way from that link's axes to the body's.
    carried = {0: (-1, Transform(np.eye(3, dtype=int).astype(object), exact(np.zeros(3))))}
    for body in range(1, model.nbody):
        parent, frame = carried[int(model.body_parentid[body])]
        here = _placed(frame, model.body_pos[body], _matrix(model.body_quat[body]))
        for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            anchor = exact(model.jnt_pos[joint])
            further = _times(model, "link_length", links[parent].joint) if parent >= 0 else 1
            fixed = Transform(here.turn, further * (here.place + here.turn.T @ anchor))
            links.append(_link(model, joint, parent, fixed))
            parent, here = len(links) - 1, Transform(np.eye(3, dtype=int).astype(object), -anchor)
        carried[body] = (parent, here)
        if parent >= 0:
            link = links[parent]
            links[parent] = replace(link, inertia=link.inertia + _body_inertia(model, body, here, link))
    return links


def _link(model: mujoco.MjModel, joint: int, parent: int, fixed: Transform) -> Link:
    name, dof, nothing = model.joint(joint).name, int(model.jnt_dofadr[joint]), exact(np.zeros(3))
    return Link(
        joint=name,
        parent=parent,
        fixed=fixed,
        axis=exact(model.jnt_axis[joint]),
        turns=bool(model.jnt_type[joint] == columns.HINGE),
        inertia=Inertia(0, nothing, exact(np.zeros((3, 3)))),
        zero=float(model.qpos0[model.jnt_qposadr[joint]]),
        armature=float(model.dof_armature[dof]),
        rest=float(model.qpos_spring[model.jnt_qposadr[joint]]) if model.jnt_stiffness[joint] else 0.0,
        quantities={
            quantity_of("armature", name): as_expression(model.dof_armature[dof]),
            quantity_of("damping", name): as_expression(model.dof_damping[dof]),
            quantity_of("drag", name): as_expression(model.dof_dampingpoly[dof, 0]),
            quantity_of("friction", name): as_expression(model.dof_frictionloss[dof]),
            quantity_of("stiffness", name): as_expression(model.jnt_stiffness[joint]),
            **(_of_servo(name) if name in columns.servos_of(model) else {}),
        },
    )


def _of_servo(joint: str) -> dict[str, Expr]:
    return {quantity_of("servo_gain", joint): Integer(1), quantity_of("servo_limit", joint): Float(UNLIMITED)}


def _times(model: mujoco.MjModel, kind: MechanicalQuantity, joint: str) -> Expr:
    """How many times what the description says of a link, where an effect may change that."""
    name = quantity_of(kind, joint)
    return symbol(name) if name in link_quantities(model) else Integer(1)


def _body_inertia(model: mujoco.MjModel, body: int, frame: Transform, link: Link) -> Inertia:
    """Of a body that is so many times heavier, further out and harder to turn, and the loads at its sites, in the axes
    of the link that carries it.
    """
    heavier, further, harder = (
        _times(model, kind, link.joint) for kind in ("link_mass", "link_centre", "link_inertia")
    )
    to_link = np.array(frame.turn.T, dtype=object)
    principal = _matrix(model.body_iquat[body])
    about_centre = to_link @ exact(principal @ np.diag(model.body_inertia[body]) @ principal.T) @ to_link.T
    centre = further * (frame.place + to_link @ exact(model.body_ipos[body]))
    described = Inertia.of_body(as_expression(model.body_mass[body]), centre, harder * about_centre)
    whole = Inertia(heavier * described.mass, heavier * described.moment, heavier * described.about_origin)
    for site in columns.loaded_sites(model):
        if model.site_bodyid[site] == body:
            place = frame.place + to_link @ exact(model.site_pos[site])
            whole += Inertia.of_body(symbol(quantity_of("load", model.site(site).name)), place, exact(np.zeros((3, 3))))
    return whole


def _placed(frame: Transform, place: Values, turn: Values) -> Transform:
    """A frame in a frame: where it is, and the matrix from its axes to those of the other."""
    return Transform(exact(turn).T @ frame.turn, frame.place + frame.turn.T @ exact(place))


def _matrix(quaternion: Values) -> Values:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quaternion, dtype=np.float64))
    return matrix.reshape(3, 3)


def as_expression(value: Any) -> Expr:
    """A number as an expression, a whole one as an integer."""
    return exact(np.array([float(value)]))[0] + Integer(0)
