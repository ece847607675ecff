"""A link is built otherwise than its description says. Its mass is ``link_mass``'s (``joints.py``).

``link_centre``. Its centre of mass lies nearer to its hinge, or further away: a rope, a pole or a link with another
tool has its weight elsewhere. m and the inertia J about the centre of mass stay,

    c → κ c,  and about the hinge  J - m [c]² → J - κ² m [c]².

``link_inertia``. It is harder or easier to turn than its mass and centre say: J → κ J. Where nothing turns the joint
itself, that is an ``armature`` on every path, and only that is named.

``link_length``. The next joints lie nearer or further away: p → κ p. Its mass and centre stay.
"""

from typing import Any

import numpy as np

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.kind import POSITIVE, Kind, Numbers, Parameter, of_any_body
from sym2real.effects.wrench import multiplying
from sym2real.inertias import write_inertia
from sym2real.trajectory import Array
from sym2real.vocabulary import MechanicalQuantity, quantity_of


def _of_link(name: MechanicalQuantity, *, most: float = 3.0, **described: Any) -> Kind:
    """So many times what the description says of the link behind a joint, likely at most ``most``."""
    return Kind(
        name=name,
        stage="mass",
        parameters=of_any_body(
            Parameter("value", "1", null=1.0, low=1.0 / most, high=most, scale=0.1, domain=POSITIVE)
        ),
        substitute=multiplying(name),
        needs=(quantity_of(name, "{column}"),),
        robot="robot with joints",
        columns="joint",
        **described,
    )


def _from_hinge(model: Any, body: Body, fixed: int, place: Array) -> Array:
    """From the bound joint to a place on one of those, in its axes, m ``# (3,)``."""
    link, _ = truth.link_of(model, body.column)
    there, turn = truth.placed(model, fixed, place, truth.UNTURNED, link)
    return np.asarray(turn.T @ (there - model.jnt_pos[model.joint(body.column).id]))


def _further_out(spec: Any, body: Body, values: Numbers) -> None:
    model = spec.compile()
    for fixed in truth.link_of(model, body.column)[1]:
        write_inertia(spec.bodies[fixed], model)
        away = _from_hinge(model, body, fixed, model.body_ipos[fixed])
        spec.bodies[fixed].ipos = model.body_ipos[fixed] + (values["value"] - 1.0) * away


LINK_CENTRE = _of_link(
    "link_centre",
    formula=r"c_j \to \kappa\,c_j",
    summary="The centre of mass of a link is so many times as far from its hinge as its description says.",
    confused_with="the link's mass beside an armature; a load at the link's end",
    shown_by="fast motion, and postures that gravity loads",
    fix="balance the link on an edge, or measure the rope or the pole, and put it into the description",
    inject=truth.editing(_further_out),
)


def _harder_to_turn(spec: Any, body: Body, values: Numbers) -> None:
    model = spec.compile()
    for fixed in truth.link_of(model, body.column)[1]:
        write_inertia(spec.bodies[fixed], model)
        spec.bodies[fixed].inertia = values["value"] * model.body_inertia[fixed]


LINK_INERTIA = _of_link(
    "link_inertia",
    most=10.0,  # estimated from a drawing, or left at a default
    formula=r"J_j \to \kappa\,J_j",
    summary="A link's moment of inertia about its centre of mass is so many times what its description says.",
    confused_with="an armature, where the joints before it stand still; the link's mass and centre together",
    shown_by="fast motion of this joint and of those before it",
    fix="swing the link on a string or take its inertia from the drawing, and put it into the description",
    inject=truth.editing(_harder_to_turn),
)


def _longer(spec: Any, body: Body, values: Numbers) -> None:
    model = spec.compile()
    _, carrying = truth.link_of(model, body.column)
    for child in range(1, model.nbody):
        parent = int(model.body_parentid[child])
        if parent in carrying and child not in carrying:
            hinge = model.jnt_pos[model.body_jntadr[child]]
            place, _ = truth.placed(model, child, hinge, truth.UNTURNED, parent)
            away = _from_hinge(model, body, parent, place)
            spec.bodies[child].pos = model.body_pos[child] + (values["value"] - 1.0) * away


LINK_LENGTH = _of_link(
    "link_length",
    formula=r"p_{j,\mathrm{next}} \to \kappa\,p_{j,\mathrm{next}}",
    summary="The next joints are so many times as far from a link's hinge as its description says.",
    confused_with="the masses of the links behind it; armatures",
    shown_by="fast motion of this joint and of those behind it",
    fix="measure from hinge to hinge, and put the length into the description",
    inject=truth.editing(_longer),
)
