"""The centre of mass of a link lies nearer to its hinge, or further away, than the description says.

A rope, a pole or a link with another tool has its weight elsewhere: m and the inertia J about the centre of mass stay,

    c → κ c,  and about the hinge  J - m [c]² → J - κ² m [c]².
"""

from typing import Any

import numpy as np

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.kind import POSITIVE, Kind, Numbers, Parameter, of_any_body
from sym2real.effects.wrench import multiplying
from sym2real.inertias import write_inertia
from sym2real.vocabulary import quantity_of


def _further_out(spec: Any, body: Body, values: Numbers) -> None:
    """Of the body that the joint moves, and of those that are fixed to it."""
    model = spec.compile()
    joint = model.joint(body.column).id
    link = int(model.jnt_bodyid[joint])
    for fixed in map(int, np.flatnonzero(model.body_weldid == link)):
        centre, turn = truth.placed(model, fixed, model.body_ipos[fixed], truth.UNTURNED, link)
        write_inertia(spec.bodies[fixed], model)
        away = centre - model.jnt_pos[joint]
        spec.bodies[fixed].ipos = model.body_ipos[fixed] + (values["value"] - 1.0) * turn.T @ away


LINK_CENTRE = Kind(
    name="link_centre",
    stage="mass",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.3, high=3.0, scale=0.1, domain=POSITIVE)),
    formula=r"c_j \to \kappa\,c_j",
    summary="The centre of mass of a link is so many times as far from its hinge as its description says.",
    confused_with="the link's mass beside an armature; a load at the link's end",
    shown_by="fast motion, and postures that gravity loads",
    fix="balance the link on an edge, or measure the rope or the pole, and put it into the description",
    inject=truth.editing(_further_out),
    substitute=multiplying("link_centre"),
    needs=(quantity_of("link_centre", "{column}"),),
    robot="robot with joints",
    columns="joint",
)
