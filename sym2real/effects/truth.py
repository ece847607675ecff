"""Means of injection: what a simulated robot's own quantities are, and pushes at its points.

The robot is body 1 of the description, a free body; its first actuator is a quadrotor's thrust along body z, the
next three its rate loop. ``MjSpec`` bodies, actuators and geoms are edited before compilation.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from sym2real.effects.body import Body
from sym2real.effects.kind import Inject, Numbers
from sym2real.errors import ModelError
from sym2real.protocols import Change, Filter
from sym2real.trajectory import Array
from sym2real.vocabulary import MOTOR_COLUMNS

ROBOT = 1
FILTER, FILTER_EXACT = 2, 3  # mujoco.mjtDyn: for integrators of higher order, and for those of first order
RUNGE_KUTTA = 1  # mujoco.mjtIntegrator.mjINT_RK4


def rotation(data: Any) -> Array:
    """Body→world matrix ``# (3, 3)``."""
    matrix: Array = np.array(data.xmat[ROBOT]).reshape(3, 3)
    return matrix


def velocity(data: Any) -> Array:
    """Velocity of the body frame's origin in world axes ``# (3,)``."""
    linear: Array = np.array(data.qvel[:3])
    return linear


def rates(data: Any) -> Array:
    """Rates about body axes ``# (3,)``."""
    turning: Array = np.array(data.qvel[3:6])
    return turning


def thrust(data: Any) -> float:
    """What the thrust actuator, or all rotors of their own together, give now, N."""
    rotors = [index for index in range(len(data.actuator_force)) if data.actuator(index).name in MOTOR_COLUMNS]
    return float(data.actuator_force[rotors or [0]].sum())


def add_force(data: Any, force: Array) -> None:
    """A force along world axes at the centre of mass of the robot's first body."""
    data.xfrc_applied[ROBOT, :3] += force


def add_torque(data: Any, torque: Array) -> None:
    """A torque about body axes."""
    data.xfrc_applied[ROBOT, 3:] += rotation(data) @ torque


def add_thrust(data: Any, size: float, place: Array | None = None) -> None:
    """A force along body z in N at a place of the body frame ``# (3,)``: at the rotors' centre, its origin, if None."""
    turned = rotation(data)
    force = size * turned[:, 2]
    point = data.xpos[ROBOT] + (0.0 if place is None else turned @ place)
    data.xfrc_applied[ROBOT, :3] += force
    data.xfrc_applied[ROBOT, 3:] += np.cross(point - data.xipos[ROBOT], force)


def editing(edit: Callable[[Any, Body, Numbers], None]) -> Inject:
    """A truth that alters the ``MjSpec``."""
    return lambda body, values: Change("", edit=lambda spec: edit(spec, body, values))


def pushing(push: Callable[[Any, Body, Numbers], None]) -> Inject:
    """A truth that pushes the body before every physics step, by the ``MjData``."""
    return lambda body, values: Change("", force=lambda _, data: push(data, body, values))


def measuring(report: Callable[[Array, Body, Numbers], Array]) -> Inject:
    """A truth that reports another state ``# (state,)`` than there is, and needs no memory."""
    return lambda body, values: Change("", measure=lambda: lambda state: report(state.copy(), body, values))


def set_inertial(spec: Any, extra_mass: float = 0.0, offset: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
    """Mass of the robot's first body and its centre; inertia about the centre of mass stays."""
    plain, body = spec.copy().compile(), spec.worldbody.first_body()
    body.explicitinertial = True
    body.mass = plain.body_mass[ROBOT] + extra_mass
    body.inertia = plain.body_inertia[ROBOT]
    body.iquat = plain.body_iquat[ROBOT]
    body.ipos = plain.body_ipos[ROBOT] + np.array(offset)


def set_lag(spec: Any, actuator: Any, time: float) -> None:
    """A first-order filter of time constant ``time`` in s in front of an actuator's gain.

    Raises:
        ModelError: when it has one: a MuJoCo actuator has room for one.
    """
    if int(actuator.dyntype) != 0:
        raise ModelError(f"the actuator {actuator.name!r} has a filter already, and MuJoCo gives it one")
    kind = FILTER if int(spec.option.integrator) == RUNGE_KUTTA else FILTER_EXACT
    actuator.dyntype = type(actuator.dyntype)(kind)
    actuator.dynprm = [_filter_time(time, spec.option), *([0.0] * (len(actuator.dynprm) - 1))]


def set_time(model: Any, name: str, time: float) -> None:
    """The time constant in s of an actuator that :func:`set_lag` gave a filter, while the simulation runs."""
    model.actuator(name).dynprm[0] = _filter_time(time, model.opt)


def _filter_time(time: float, option: Any) -> float:
    """Of a filter that answers as one of that time constant; an integrator's step may be half a step late."""
    if int(option.integrator) == RUNGE_KUTTA:
        return time
    return max(time - 0.5 * float(option.timestep), 1e-6)  # the force of a step is that of its start


# Actuators of the descriptions by action column; of other columns the one of that name.
ACTUATORS = {
    "thrust": ("thrust",),
    "wx_cmd": ("wx",),
    "wy_cmd": ("wy",),
    "wz_cmd": ("wz",),
    "steer": ("front_left_steer", "front_right_steer"),
    "speed": ("front_left_spin", "front_right_spin", "rear_left_spin", "rear_right_spin"),
}


def actuators(spec: Any, body: Body) -> list[Any]:
    """Actuators of an ``MjSpec`` that the bound action column drives, or all of them."""
    columns = (body.column,) if body.column else tuple(body.layouts.action)
    names = [name for column in columns for name in ACTUATORS.get(column, (column,))]
    return [actuator for actuator in spec.actuators if actuator.name in names]


def commanding(change: Callable[[float, Body, Numbers], float], column: str = "") -> Inject:
    """A truth that maps a command to another one: the bound one, or that of a column."""

    def inject(body: Body, values: Numbers) -> Change:
        place = body.layouts.action.index(column or body.column)

        def apply(action: Array) -> Array:
            result = action.copy()
            result[place] = change(float(action[place]), body, values)
            return result

        return Change("", command=lambda: apply)

    return inject


def following(body: Body, follow: Callable[[float, float], tuple[float, float]]) -> Change:
    """A command with memory: (where the actuator was, command) → where it is after the period, its mean in it."""
    column = body.layouts.action.index(body.column)

    def begin() -> Filter:
        """An episode's actuator: it stands where the first command puts it."""
        last: list[float] = []

        def apply(action: Array) -> Array:
            result, command = action.copy(), float(action[column])
            after, result[column] = follow(last[0] if last else command, command)
            last[:] = [after]
            return result

        return apply

    return Change("", command=begin)
