"""Columns of a robot from the joints and actuators of a compiled MJCF, and the way to MuJoCo's coordinates.

A hinge or slide ``j`` gives the state columns ``j`` and ``j_rate`` and the input ``j_push``, a force in N or a torque
in N m along it; a free joint gives position, attitude, velocity and body rates, and as inputs the wrench.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain
from typing import Any

import mujoco
import numpy as np

from sym2real.errors import ModelError, UnknownNameError
from sym2real.field import Field, is_name
from sym2real.layout import Layout, Layouts
from sym2real.robots.description import is_text, spec_of
from sym2real.robots.link_quantities import link_quantities
from sym2real.robots.naming import STANDARD
from sym2real.trajectory import Array
from sym2real.vocabulary import (
    ATTITUDE,
    GRAVITY_COMPONENTS,
    JOINT_ANGLE,
    JOINT_DISPLACEMENT,
    JOINT_FORCE,
    JOINT_RATE,
    JOINT_SPEED,
    JOINT_TORQUE,
    POSITION,
    RATE,
    VELOCITY,
    VOCABULARY,
    WRENCH,
    MechanicalQuantity,
    push_column,
    quantity_of,
    rate_column,
)

FREE, BALL, SLIDE, HINGE = (
    int(getattr(mujoco.mjtJoint, f"mjJNT_{name}")) for name in ("FREE", "BALL", "SLIDE", "HINGE")
)
BY_JOINT = int(mujoco.mjtTrn.mjTRN_JOINT)
POSES = 256  # over the ranges of joints, at which inertias and contacts are looked at
# Field of the actions, and its unit, of an actuator on a slide and of one on a hinge, by its command.
COMMANDED = {
    "force": (("actuator force", "N"), ("actuator torque", "N m")),
    "position": (("displacement target", "m"), ("angle target", "rad")),
    "velocity": (("speed target", "m/s"), ("rate target", "rad/s")),
}


def controls_of(places: list[int], number: int, actions: Array) -> Array:
    """Controls of all actuators ``# (..., number)``; those that are no action stay at zero.

    Args:
        places: of every action among the actuators ``# (action,)``.
        number: of actuators.
        actions: ``# (..., action)``.
    """
    controls = np.zeros((*actions.shape[:-1], number))
    controls[..., places] = actions
    return controls


def names_of(model: mujoco.MjModel, kind: str) -> list[str]:
    """Names of all joints or actuators, which must be fit for columns.

    Raises:
        ModelError: for a joint of a tendon, which keeps its name, that is not.
    """
    names = [getattr(model, kind)(index).name for index in range(model.njnt if kind == "joint" else model.nu)]
    for index, name in enumerate(names):
        free = kind == "joint" and model.jnt_type[index] == FREE
        if not free and not is_name(name):
            raise ModelError(
                f"{kind} {index}, of a tendon: expected a name of letters, digits and _, found {name!r}; rename it"
            )
    return names


def state_columns(model: mujoco.MjModel) -> dict[str, tuple[Field, int]]:
    """Field, and place in qpos and qvel one after the other, of every column that the joints give.

    Raises:
        ModelError: for a ball joint, or a second free one.
    """
    kinds = model.jnt_type.tolist()
    if BALL in kinds or kinds.count(FREE) > 1:
        raise ModelError("expected hinges, slides and at most one free joint, found a ball or several free joints")
    fields: dict[str, tuple[Field, int]] = {}
    places = zip(model.jnt_qposadr.tolist(), (model.nq + model.jnt_dofadr).tolist(), strict=True)
    for name, kind, (at, dof) in zip(names_of(model, "joint"), kinds, places, strict=True):
        if kind == FREE:
            for field, first in ((POSITION, at), (ATTITUDE, at + 3), (VELOCITY, dof), (RATE, dof + 3)):
                fields |= {column: (field, first + place) for place, column in enumerate(field.columns)}
        else:
            place, speed = (JOINT_ANGLE, JOINT_RATE) if kind == HINGE else (JOINT_DISPLACEMENT, JOINT_SPEED)
            fields |= {name: (place, at), rate_column(name): (speed, dof)}
    return fields


def layout_of(columns: Iterable[tuple[str, Field]]) -> Layout:
    """Columns in the order in which fields are listed in the vocabulary of robots, each field once."""
    grouped: dict[str, tuple[Field, list[str]]] = {}
    for column, field in columns:
        grouped.setdefault(field.name, (field, []))[1].append(column)
    return Layout(tuple(Field(f.name, tuple(names), f.unit, f.frame, f.kind) for f, names in grouped.values()))


def inputs_of(model: mujoco.MjModel) -> Layout:
    """External forces: the wrench of a free body, and a force or torque along every hinge and slide."""
    joints = zip(names_of(model, "joint"), model.jnt_type.tolist(), strict=True)
    fields = [
        (push_column(name), JOINT_TORQUE if kind == HINGE else JOINT_FORCE) for name, kind in joints if kind != FREE
    ]
    wrench = Layout.of(WRENCH) if FREE in model.jnt_type.tolist() else Layout()
    return wrench + layout_of(fields)


def quantities_of(model: mujoco.MjModel) -> tuple[str, ...]:
    """Names of what effects may change in equations from the file: gravity, what joints have, loads at sites."""
    joints = [name for name, kind in zip(names_of(model, "joint"), model.jnt_type, strict=True) if kind != FREE]
    loads = [quantity_of("load", model.site(site).name) for site in loaded_sites(model)]
    kinds: tuple[MechanicalQuantity, ...] = ("armature", "damping", "drag", "friction", "stiffness")
    of_servos: tuple[MechanicalQuantity, ...] = ("servo_gain", "servo_limit")
    servos = (quantity_of(kind, joint) for joint in servos_of(model) for kind in of_servos)
    return (
        *GRAVITY_COMPONENTS,
        *(quantity_of(kind, name) for kind in kinds for name in joints),
        *link_quantities(model),
        *servos,
        *loads,
    )


def servos_of(model: mujoco.MjModel) -> tuple[str, ...]:
    """Joints that an actuator holds against a position or a velocity."""
    held = (driven_joint(model, index) for index in range(model.nu) if command_kind(model, index) != "force")
    return tuple(dict.fromkeys(filter(None, held)))


def loaded_sites(model: mujoco.MjModel) -> list[int]:
    """Sites that something may hang at: those with a name, on a body that moves."""
    moves = model.body_weldid[model.site_bodyid] != 0
    return [site for site in range(model.nsite) if moves[site] and is_name(model.site(site).name)]


def driven_joint(model: mujoco.MjModel, actuator: int) -> str:
    """Name of the joint that an actuator is on; empty where it is on none."""
    on_joint = model.actuator_trntype[actuator] == BY_JOINT
    return str(model.joint(int(model.actuator_trnid[actuator, 0])).name) if on_joint else ""


def command_kind(model: mujoco.MjModel, actuator: int) -> str:
    """What an actuator is commanded: a force, a position or a velocity, by its gain and bias."""
    gain, bias = model.actuator_gainprm[actuator, 0], model.actuator_biasprm[actuator]
    if bias[1] and np.isclose(bias[1], -gain):
        return "position"
    return "velocity" if bias[2] and np.isclose(bias[2], -gain) else "force"


def actions_of(model: mujoco.MjModel, wanted: Mapping[str, str]) -> Layout:
    """One column per wanted actuator, with the unit of its command; motor1, motor2 … are rotors."""
    known, columns = names_of(model, "actuator"), []
    if taken := sorted({*wanted.values()} & ({*known} - {*wanted})):
        raise ModelError(f"expected columns that are called like no other actuator, found {', '.join(taken)}")
    for name, column in wanted.items():
        if name not in known:
            raise UnknownNameError("actuator", name, known)
        index = known.index(name)
        field, unit = _quantity_of(model, index)
        if column in STANDARD and driven_joint(model, index):
            raise ModelError(
                f"actuator {name!r}, on a joint: expected a column of its own, "
                f"found {column}, which means something else of robots that fly or drive"
            )
        usual = next(
            (standard for group, standard in VOCABULARY if group == "action" and column in standard.columns), None
        )
        columns.append((column, usual or Field(field, (column,), unit, "body")))
    return layout_of(columns)


def _quantity_of(model: mujoco.MjModel, actuator: int) -> tuple[str, str]:
    """Field and unit of a control: of a force before its gear, which on a slide may be a turning motor's."""
    joint, kind = int(model.actuator_trnid[actuator, 0]), command_kind(model, actuator)
    on_joint = model.actuator_trntype[actuator] == BY_JOINT
    if model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_SITE and kind == "force":
        wrench = model.actuator_gainprm[actuator, 0] * model.actuator_gear[actuator].reshape(2, 3)
        force, torque = np.linalg.norm(wrench, axis=1)
        alone = not (force and torque) and np.isclose(force + torque, 1.0)
        return COMMANDED[kind][int(torque > 0.0)] if alone else ("actuator command", "1")
    gain = abs(model.actuator_gainprm[actuator, 0] * model.actuator_gear[actuator, 0])
    if on_joint and model.jnt_type[joint] == SLIDE and kind == "force" and not np.isclose(gain, 1.0):
        return "actuator command", "1"
    return COMMANDED[kind][int(on_joint and model.jnt_type[joint] == HINGE)]


def ranges_of(model: mujoco.MjModel, actuators: Sequence[int]) -> tuple[Array, Array]:
    """Least and largest control of each: its ctrlrange, the forcerange of a motor, the joint's range of a position.

    A ctrlrange in degrees, which MuJoCo takes for rad, ends where the joint's range does.

    Raises:
        ModelError: for one that has none.
    """
    limits = []
    for index in actuators:
        joint, gain = int(model.actuator_trnid[index, 0]), model.actuator_gainprm[index, 0]
        on_joint = model.actuator_trntype[index] == BY_JOINT
        placed = command_kind(model, index) == "position" and on_joint and model.jnt_limited[joint]
        # A servo compares its control with the joint's place times the gear.
        reach = np.sort(model.jnt_range[joint] * model.actuator_gear[index, 0]) if placed else (-np.inf, np.inf)
        if model.actuator_ctrllimited[index]:
            both = np.clip(model.actuator_ctrlrange[index], *reach)
            limits.append(both if both[0] < both[1] else model.actuator_ctrlrange[index])
        elif command_kind(model, index) == "force" and model.actuator_forcelimited[index]:
            limits.append(np.sort(model.actuator_forcerange[index] / gain))
        elif placed:
            limits.append(reach)
        else:
            name = model.actuator(index).name
            if model.actuator_gaintype[index] == mujoco.mjtGain.mjGAIN_MUSCLE:
                raise ModelError(f"actuator {name!r}: expected a motor or a servo, found a muscle")
            raise ModelError(f"actuator {name!r}: expected a ctrlrange, or a forcerange of a motor, found neither")
    ranges = np.array(limits, dtype=np.float64)
    return ranges[:, 0], ranges[:, 1]


def stops_of(model: mujoco.MjModel) -> dict[str, tuple[float, float]]:
    """Least and largest place of the hinges and slides that have a range, rad or m."""
    limited = [joint for joint in range(model.njnt) if model.jnt_limited[joint]]
    return {
        model.joint(joint).name: (float(low), float(high))
        for joint in limited
        for low, high in [model.jnt_range[joint]]
    }


def opened(mjcf: str) -> tuple[mujoco.MjModel, Any]:
    """The compiled model of a file or a text, and data at its first keyframe, or where it starts without one.

    Raises:
        ModelError: when MuJoCo cannot read or compile it.
    """
    with failures_of(mjcf, "an MJCF that MuJoCo opens"):
        model = spec_of(mjcf).compile()
    _leave_out_what_is_off(model)
    return model, data_at_start(model)


@contextmanager
def failures_of(mjcf: str, expected: str) -> Iterator[None]:
    """Inside, what MuJoCo says against a file or a text becomes an error that names it.

    Raises:
        ModelError: when MuJoCo cannot read, compile or write it.
    """
    try:
        yield
    except (ValueError, OSError, mujoco.FatalError) as error:
        name = "the robot's description" if is_text(mjcf) else mjcf
        raise ModelError(f"{name}: expected {expected}, found: {' '.join(str(error).split())}") from None


def _leave_out_what_is_off(model: mujoco.MjModel) -> None:
    """Numbers that MuJoCo does not read become zero: what the file's flags disable, biases of actuators without one."""
    numbers = {
        "GRAVITY": model.opt.gravity,
        "SPRING": model.jnt_stiffness,
        "DAMPER": model.dof_damping,
        "FRICTIONLOSS": model.dof_frictionloss,
    }
    for name, values in numbers.items():
        if model.opt.disableflags & getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}"):
            values[:] = 0.0
    model.actuator_biasprm[model.actuator_biastype == mujoco.mjtBias.mjBIAS_NONE] = 0.0


def data_at_start(model: mujoco.MjModel) -> Any:
    """Data of a compiled file at its first keyframe, or where it starts without one."""
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return data


def inertias(model: mujoco.MjModel, data: Any) -> Array:
    """What accelerates with every degree of freedom, kg, kg m and kg m² ``# (nv, nv)``."""
    whole = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, whole)
    return whole


def over_range(model: mujoco.MjModel, slide: float = 0.0) -> Iterator[Any]:
    """Data of a robot of hinges and slides in many poses, all over the ranges of its joints.

    A hinge without a range turns a whole turn, a slide without one goes so far to either side, in m.
    """
    from scipy.stats.qmc import Halton  # noqa: PLC0415 — heavy, and only needed for equations

    data = data_at_start(model)
    free = np.where(model.jnt_type == HINGE, np.pi, slide)[:, None] * np.array([-1.0, 1.0])
    ranges = np.where(model.jnt_limited[:, None] != 0, model.jnt_range, data.qpos[:, None] + free)
    for place in Halton(model.njnt, scramble=False).random(POSES):
        data.qpos[:] = ranges[:, 0] + place * (ranges[:, 1] - ranges[:, 0])
        mujoco.mj_forward(model, data)
        yield data


def inertias_over_range(model: mujoco.MjModel) -> list[Array]:
    """What accelerates with the joints of a robot of hinges and slides, as :func:`inertias`, in many poses.

    The first pose is the first keyframe. An arm that is stretched out weighs many times as much on its first joint as
    one that is folded.
    """
    return [inertias(model, data) for data in chain([data_at_start(model)], over_range(model))]


def layouts_of(model: mujoco.MjModel, state: Layout, actions: Mapping[str, str]) -> Layouts:
    """All columns; an action that has a state column's name must be given another."""
    action = actions_of(model, actions)
    twice = [column for column in action if column in state]
    if twice:
        raise ModelError(f"expected columns of actions named otherwise than those of joints, found {', '.join(twice)}")
    return Layouts(state, action, inputs_of(model))
