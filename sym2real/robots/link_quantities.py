"""Which of a link's numbers its effects may change: mass, centre, moment of inertia, and the way to the next joints."""

from collections.abc import Iterator

import mujoco
import numpy as np

from sym2real.vocabulary import MechanicalQuantity, quantity_of

HINGE, FREE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_FREE)
TINY = 1e-9  # m off a hinge's axis


def link_quantities(model: mujoco.MjModel) -> tuple[str, ...]:
    """Names of all of them; the last joint of a body carries it."""
    return tuple(
        quantity_of(kind, model.joint(joint).name)
        for joint in range(model.njnt)
        if int(model.jnt_type[joint]) != FREE and joint == _joints_of(model, int(model.jnt_bodyid[joint]))[-1]
        for kind in _kinds(model, joint)
    )


def _kinds(model: mujoco.MjModel, joint: int) -> Iterator[MechanicalQuantity]:
    yield "link_mass"
    if _turns(model, joint):
        yield "link_centre"
    # Of a link that nothing else turns, it is an armature.
    if any(_turns(model, before) for before in _before(model, joint)):
        yield "link_inertia"
    if _turns(model, joint) and any(_off_axis(model, joint, after) for after in _next(model, joint)):
        yield "link_length"


def _turns(model: mujoco.MjModel, joint: int) -> bool:
    return int(model.jnt_type[joint]) == HINGE


def _joints_of(model: mujoco.MjModel, body: int) -> range:
    first = int(model.body_jntadr[body])
    return range(first, first + int(model.body_jntnum[body]))


def _before(model: mujoco.MjModel, joint: int) -> Iterator[int]:
    """Joints that carry one."""
    body = int(model.jnt_bodyid[joint])
    yield from (own for own in _joints_of(model, body) if own < joint)
    while body := int(model.body_parentid[body]):
        yield from _joints_of(model, body)


def _next(model: mujoco.MjModel, joint: int) -> Iterator[int]:
    """First joints of the bodies that hang on the one that a joint moves."""
    link = int(model.jnt_bodyid[joint])
    for body in range(link + 1, model.nbody):
        if model.body_weldid[model.body_parentid[body]] == link:
            yield from _joints_of(model, body)[:1]


def _off_axis(model: mujoco.MjModel, joint: int, other: int) -> bool:
    """Whether another joint's place is not on a hinge's axis, where the file places all bodies."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    away = data.xanchor[other] - data.xanchor[joint]
    return bool(np.linalg.norm(np.cross(data.xaxis[joint], away)) > TINY)
