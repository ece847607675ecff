"""Which compiled MJCF have first-principles equations here: what stands against it, in words."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco

from sym2real.layout import Layout
from sym2real.robots import mjcf_columns as columns
from sym2real.robots.planar import Wheels
from sym2real.vocabulary import rate_column

WHERE_IT_ROLLS = 'a caster without friction has condim="1" priority="1"; the body\'s origin is the middle of the axle'
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
    return _those_that_hold(wrong | _of_actuators(model))


def against_rolling(model: mujoco.MjModel, wheels: Wheels) -> list[str]:
    """What keeps a robot of the plane from rolling on wheels of one axle; empty for one that does."""
    forward, aside, turning = wheels.moves
    drags = " and ".join(way for way, free in (("as it goes ahead", forward), ("as it turns", turning)) if not free)
    wrong = {
        f"contacts with friction that drag {drags} ({WHERE_IT_ROLLS})": bool(drags),
        "no wheel that keeps it from going aside": aside,
        "joints that do not roll with it": not wheels.ways.any(axis=1).all(),
        "springs or servos of position on wheels": model.jnt_stiffness.any() or model.actuator_biasprm[:, 1].any(),
    }
    return _those_that_hold(wrong | _of_actuators(model))


def _of_actuators(model: mujoco.MjModel) -> dict[str, bool]:
    by_joint = (model.actuator_trntype == columns.BY_JOINT).all() and not model.actuator_dyntype.any()
    return {"an actuator with a filter, or on no joint": not by_joint}


def _those_that_hold(wrong: Mapping[str, bool]) -> list[str]:
    return [what for what, holds in wrong.items() if holds]
