"""Names that can be columns, for joints and actuators that a file calls otherwise or not at all."""

import re
from pathlib import Path
from typing import Any

import mujoco

from sym2real.field import is_name
from sym2real.vocabulary import EULER_ANGLES, VOCABULARY

# Of columns that mean the same of any robot: no joint is a position, no actuator a wind, and its motor is no rotor.
STANDARD = {*EULER_ANGLES, *(column for _, field in VOCABULARY for column in field.columns)}
ON_JOINT = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)


def give_names(spec: mujoco.MjSpec) -> dict[str, str]:
    """Name joints and actuators so that they can be columns of their own, and let what refers to them follow.

    Joints of tendons keep their names, to which a tendon's path is bound. An actuator without a name is called as the
    joint that it moves.

    Returns:
        What was named: ``{"joint robot0:WRJ1": "robot0_WRJ1", "unnamed actuator 0": "thigh"}``.
    """
    bound = {wrap.target.name for tendon in spec.tendons for wrap in tendon.path if wrap.target}
    free = mujoco.mjtJoint.mjJNT_FREE
    joints = [joint for joint in spec.joints if joint.type != free and joint.name not in bound]
    named = _given("joint", [(joint, f"{joint.parent.name}_joint".lstrip("_")) for joint in joints])
    _follow(spec, mujoco.mjtObj.mjOBJ_JOINT, named)
    driven = [(drive, drive.target if drive.trntype in ON_JOINT else "actuator") for drive in spec.actuators]
    moved = _given("actuator", driven)
    _follow(spec, mujoco.mjtObj.mjOBJ_ACTUATOR, moved)
    return named | moved


def named_in(file: Path) -> dict[str, str]:
    """What is named as a file is opened, as of :func:`give_names`."""
    return give_names(mujoco.MjSpec.from_file(str(file)))


def _given(kind: str, elements: list[tuple[Any, str]]) -> dict[str, str]:
    """Give names where there is none that can be a column of its own; by default those beside them."""
    taken, renamed = {element.name for element, _ in elements}, {}
    for number, (element, default) in enumerate(elements):
        if _fits(element, element.name):
            continue
        plain = re.sub(r"\W", "_", element.name or default, flags=re.ASCII)
        plain = plain if _fits(element, plain) else f"{kind}_{plain}"
        new, count = plain, 1
        while new in taken:
            count += 1
            new = f"{plain}_{count}"
        taken.add(new)
        label = f"{kind} {element.name}" if element.name else f"unnamed {kind} {number}"
        renamed[label] = element.name = new
    return renamed


def _fits(element: Any, name: str) -> bool:
    """Whether a name can be the column of a joint or an actuator; what acts at a site is of a body that flies."""
    at_site = getattr(element, "trntype", ON_JOINT[0]) not in ON_JOINT
    return is_name(name) and (at_site or name not in STANDARD)


def _follow(spec: mujoco.MjSpec, kind: mujoco.mjtObj, named: dict[str, str]) -> None:
    """Let actuators, sensors and constraints name what was renamed as it is called now."""
    new = {old.partition(" ")[2]: name for old, name in named.items()}
    joints = kind == mujoco.mjtObj.mjOBJ_JOINT
    for actuator in spec.actuators if joints else ():
        if actuator.trntype in ON_JOINT:
            actuator.target = new.get(actuator.target, actuator.target)
    for sensor in spec.sensors:
        if sensor.objtype == kind:
            sensor.objname = new.get(sensor.objname, sensor.objname)
    for equality in spec.equalities if joints else ():
        if equality.type == mujoco.mjtEq.mjEQ_JOINT:
            equality.name1, equality.name2 = (new.get(name, name) for name in (equality.name1, equality.name2))
