"""Which compiled MJCF have first-principles equations here: what stands against it, in words."""

from collections.abc import Mapping

import mujoco
import numpy as np

from sym2real.layout import Layout
from sym2real.robots import mjcf_columns as columns
from sym2real.robots.planar import Wheels
from sym2real.vocabulary import rate_column

WHERE_IT_ROLLS = 'a caster without friction has condim="1" priority="1"; the body\'s origin is the middle of the axle'
OF_A_GAS = 10.0  # kg/m³, most: what is lighter hardly brakes a robot
LEARN = "in Python, ROBOTS.register(name, robot) and then `learn` finds equations in the simulator"


def against_tree(model: mujoco.MjModel, state: Layout) -> list[str]:
    """What keeps a robot with this state from being a tree of hinges and slides; empty for one that is."""
    names = columns.names_of(model, "joint")
    missing = [column for name in names for column in (name, rate_column(name)) if column not in state]
    wrong = {
        "a free joint": columns.FREE in model.jnt_type.tolist(),
        f"no {', '.join(missing)} in the state": bool(missing),
        "tendons or equality constraints": bool(model.ntendon or model.neq),
    }
    return those_that_hold(wrong | beside_joints(model))


def against_rolling(model: mujoco.MjModel, wheels: Wheels) -> list[str]:
    """What keeps a robot of the plane from rolling on wheels of one axle; empty for one that does."""
    forward, aside, turning = wheels.moves
    drags = " and ".join(way for way, free in (("as it goes ahead", forward), ("as it turns", turning)) if not free)
    wrong = {
        f"contacts with friction that drag {drags} ({WHERE_IT_ROLLS})": bool(drags),
        "no wheel that keeps it from going aside": aside,
        "joints that do not roll with it": not wheels.ways.any(axis=1).all(),
        "gravity that is not along z": model.opt.gravity[:2].any(),
        "springs or servos of position on wheels": model.jnt_stiffness.any() or model.actuator_biasprm[:, 1].any(),
    }
    return those_that_hold(wrong | beside_joints(model))


def beside_joints(model: mujoco.MjModel) -> dict[str, bool]:
    """Forces of which no equations here know, and whether they act."""
    by_joint = (model.actuator_trntype == columns.BY_JOINT).all() and not model.actuator_dyntype.any()
    return {"an actuator with a filter, or on no joint": not by_joint} | forces_beside(model)


def forces_beside(model: mujoco.MjModel) -> dict[str, bool]:
    """The same of any robot, whatever its actuators act on."""
    fixed = model.actuator_gaintype == mujoco.mjtGain.mjGAIN_FIXED
    linear = np.isin(model.actuator_biastype, (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE))
    own = (model.actuator_damping, model.actuator_dampingpoly, model.actuator_armature)
    off = model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_ACTUATION or model.opt.disableactuator
    return {
        "an actuator whose gain depends on where it is (a damper, a muscle)": not (fixed & linear).all(),
        "an actuator with a delay": model.actuator_history.any(),
        "an actuator with a damping or an armature of its own": any(values.any() for values in own),
        "actuators that are switched off": bool(off),
        "springs or dampers that are not linear": model.jnt_stiffnesspoly.any() or model.dof_dampingpoly[:, 1:].any(),
        "a compensation of gravity (gravcomp)": model.body_gravcomp.any(),
        "a liquid around it": model.opt.density > OF_A_GAS,
    }


def those_that_hold(wrong: Mapping[str, bool]) -> list[str]:
    """Of what may stand against a robot, what does."""
    return [what for what, holds in wrong.items() if holds]
