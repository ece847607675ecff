"""Means of injection: what a simulated robot's own quantities are, and forces at its points.

The robot is the free body of the description, the first that moves. Its actuators are rotors of their own, or the first
is a quadrotor's thrust along body z, and the next three its rate loop. ``MjSpec`` bodies, actuators and geoms are
edited before compilation.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from sym2real.effects.body import Body
from sym2real.effects.kind import Inject, Numbers
from sym2real.errors import ModelError
from sym2real.protocols import Change, Filter
from sym2real.trajectory import Array
from sym2real.vocabulary import MOTOR_COLUMNS

FREE = 0  # mujoco.mjtJoint.mjJNT_FREE
FILTER, FILTER_EXACT = 2, 3  # mujoco.mjtDyn: for integrators of higher order, and for those of first order
RUNGE_KUTTA = 1  # mujoco.mjtIntegrator.mjINT_RK4
SHORTEST = 1e-12  # s, of a ramp that is none
UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])


def robot_in(model: Any) -> int:
    """Number of the robot's first body: a scene may hold bodies before it that do not move."""
    return int(model.dof_bodyid[0])


def free_body(spec: Any) -> Any:
    """The same body in an ``MjSpec``."""
    return next(joint.parent for joint in spec.joints if int(joint.type) == FREE)


def placed(model: Any, body: int, place: Array, quaternion: Array, onto: int | None = None) -> tuple[Array, Array]:
    """What is placed on any of the robot's bodies, in the robot's axes: place ``# (3,)`` and matrix ``# (3, 3)``.

    Or in those of another body, ``onto`` which it is fixed.
    """
    turn, root = Rotation.from_quat(np.roll(quaternion, -1)), robot_in(model) if onto is None else onto
    while body != root:
        carried = Rotation.from_quat(np.roll(model.body_quat[body], -1))
        place, turn = model.body_pos[body] + carried.apply(place), carried * turn
        body = int(model.body_parentid[body])
    return place, turn.as_matrix()


def link_of(model: Any, joint: str) -> tuple[int, list[int]]:
    """The body that a joint moves, and all that are fixed to it with that."""
    link = int(model.jnt_bodyid[model.joint(joint).id])
    return link, [int(fixed) for fixed in np.flatnonzero(model.body_weldid == link)]


def rotation(data: Any) -> Array:
    """Body→world matrix ``# (3, 3)``."""
    return np.array(data.xmat[robot_in(data.model)]).reshape(3, 3)


def velocity(data: Any) -> Array:
    """Velocity of the body frame's origin in world axes ``# (3,)``."""
    return np.array(data.qvel[:3])


def rates(data: Any) -> Array:
    """Rates about body axes ``# (3,)``."""
    return np.array(data.qvel[3:6])


def thrust(data: Any) -> float:
    """What the thrust actuator, or all rotors of their own together, give now, N."""
    return float(np.array(data.qfrc_actuator[:3]) @ rotation(data)[:, 2])


def scale_thrust(data: Any, factor: float) -> None:
    """So many times what the rotors give: their torques scale alike where they are commanded without a loop."""
    add_thrust(data, (factor - 1.0) * thrust(data))
    if any(data.actuator(index).name in MOTOR_COLUMNS for index in range(len(data.actuator_force))):
        add_torque(data, (factor - 1.0) * np.array(data.qfrc_actuator[3:6]))


def bend_rotors(data: Any, given: Callable[[float], float]) -> None:
    """Every rotor gives what is made of its own thrust in N, with as many times its torques."""
    moments = np.zeros((data.model.nu, data.model.nv))  # MuJoCo has them sparse, by rows
    for row, first, count in zip(moments, data.moment_rowadr, data.moment_rownnz, strict=True):
        places = slice(first, first + count)
        row[data.moment_colind[places]] = data.actuator_moment.ravel()[places]
    own, along = moments * np.array(data.actuator_force)[:, None], rotation(data)[:, 2]
    more = np.array([given(alone) / alone - 1.0 if alone else 0.0 for alone in own[:, :3] @ along]) @ own
    add_thrust(data, float(more[:3] @ along))
    add_torque(data, more[3:6])


def add_force(data: Any, force: Array) -> None:
    """A force along world axes at the centre of mass of the robot with all that it carries."""
    robot = robot_in(data.model)
    data.xfrc_applied[robot] += [*force, *np.cross(data.subtree_com[robot] - data.xipos[robot], force)]


def add_torque(data: Any, torque: Array) -> None:
    """A torque about body axes."""
    data.xfrc_applied[robot_in(data.model), 3:] += rotation(data) @ torque


def add_thrust(data: Any, size: float, place: Array | None = None) -> None:
    """A force along body z in N at a place of the body frame ``# (3,)``: at the rotors' centre, its origin, if None."""
    turned, robot = rotation(data), robot_in(data.model)
    force = size * turned[:, 2]
    point = data.xpos[robot] + (0.0 if place is None else turned @ place)
    data.xfrc_applied[robot] += [*force, *np.cross(point - data.xipos[robot], force)]


def editing(edit: Callable[[Any, Body, Numbers], None]) -> Inject:
    """A truth that alters the ``MjSpec``."""
    return lambda body, values: Change("", edit=lambda spec: edit(spec, body, values))


def with_force(force: Callable[[Any, Body, Numbers], None]) -> Inject:
    """A truth that applies a force or torque before every physics step, by the ``MjData``."""
    return lambda body, values: Change("", force=lambda _, data: force(data, body, values))


def of_attitude_commands(name: str) -> Inject:
    """No truth: of an effect on a robot that is commanded an attitude."""

    def refuse(_body: Body, _values: Numbers) -> Change:
        raise ModelError(f"{name}: no simulated robot here is commanded an attitude")

    return refuse


def measuring(report: Callable[[Array, Body, Numbers], Array]) -> Inject:
    """A truth that reports another state ``# (state,)`` than there is, and needs no memory."""
    return lambda body, values: Change("", measure=lambda: lambda state: report(state.copy(), body, values))


def weld(parent: Any, place: Sequence[float] | Array, mass: float, inertia: Sequence[float]) -> Any:
    """A body of that mass (kg) and inertia (kg m²) about its own middle, fixed to another at a place (m)."""
    return parent.add_body(pos=place, mass=mass, ipos=[0.0] * 3, inertia=inertia, explicitinertial=True)


def set_inertial(
    spec: Any,
    extra_mass: float = 0.0,
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0),
    inertia: Array | None = None,
) -> None:
    """Mass of the robot's first body, where the whole robot's centre lies, and more inertia ``# (3, 3)`` about it."""
    plain, body = spec.copy().compile(), free_body(spec)
    robot = robot_in(plain)
    own = plain.body_mass[robot] + extra_mass
    body.explicitinertial = True
    body.mass = own
    body.inertia, body.iquat = plain.body_inertia[robot], plain.body_iquat[robot]
    if inertia is not None:
        axes = Rotation.from_quat(np.roll(body.iquat, -1)).as_matrix()
        tensor = axes @ np.diag(body.inertia) @ axes.T + inertia
        body.inertia, body.iquat = [0.0] * 3, [1.0, 0.0, 0.0, 0.0]
        body.fullinertia = [*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2]]
    # Bodies that it carries stay where they are, so that it moves by more than the centre of all.
    body.ipos = plain.body_ipos[robot] + (plain.body_subtreemass[robot] + extra_mass) / own * np.array(offset)


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


# Actuators of the descriptions by action column, beside the one of that name.
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
    return [actuator for actuator in spec.actuators if actuator.name in _driven(body)]


def _driven(body: Body) -> list[str]:
    """What actuators may be called that the bound action column drives, or all do."""
    return [name for column in body.bound for name in (*ACTUATORS.get(column, ()), column)]


def delay(spec: Any, actuators: Iterable[Any], seconds: float) -> None:
    """Actuators of an ``MjSpec`` act so much later: its rollouts know what is under way."""
    for actuator in actuators:
        actuator.delay += seconds
        actuator.nsample = int(np.ceil(actuator.delay / spec.option.timestep)) + 2


def commanding(change: Callable[[float, Body, Numbers], float], column: str = "") -> Inject:
    """A truth that maps a command to another one: the bound one, all where none is, or that of a column.

    Where thrust is none, but what motors give together, they give so many times more.
    """

    def scale(data: Any, body: Body, values: Numbers) -> None:
        if given := thrust(data):
            scale_thrust(data, change(given, body, values) / given)

    def inject(body: Body, values: Numbers) -> Change:
        if (column or body.column) in body.quantities:
            return with_force(scale)(body, values)
        places = [body.layouts.action.index(column)] if column else body.action_indices()

        def apply(action: Array) -> Array:
            result = action.copy()
            result[places] = [change(float(action[place]), body, values) for place in places]
            return result

        return Change("", command=lambda: apply)

    return inject


def following(body: Body, follow: Callable[[float, float], tuple[float, float]]) -> Change:
    """A command with memory: (where the actuator was, command) → where it is after the period, what acts in it."""
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


class Ramp:
    """A filter of commands that leads an actuator, within a control period, to where it is after that.

    Args:
        body: with the command's column.
        rate: by which it moves at most, in the command's unit per s.
    """

    def __init__(self, body: Body, rate: float) -> None:
        self._column, self._names = body.layouts.action.index(body.column), _driven(body)
        self._rate, self._dt = rate, body.dt
        self._position: float | None = None  # it stands where the first command puts it
        self._duration, self._begin = 0.0, np.nan
        self._controls: tuple[Array, Array] | None = None  # before the period and after it

    def __call__(self, action: Array) -> Array:
        """The action with where the actuator is after the period."""
        result, command = action.copy(), float(action[self._column])
        before = command if self._position is None else self._position
        after = before + float(np.clip(command - before, -self._rate * self._dt, self._rate * self._dt))
        self._position, self._begin = after, np.nan
        self._duration = abs(after - before) / max(self._rate, SHORTEST)
        result[self._column] = after
        return result

    def move(self, model: Any, data: Any) -> None:
        """Control of a physics step: at its middle the actuator has come that far."""
        places = [place for place in range(model.nu) if model.actuator(place).name in self._names]
        if np.isnan(self._begin):
            after = np.array(data.ctrl[places])
            self._begin, self._controls = data.time, (after if self._controls is None else self._controls[1], after)
        assert self._controls is not None
        before, after = self._controls
        done = (data.time - self._begin + 0.5 * model.opt.timestep) / max(self._duration, SHORTEST)
        data.ctrl[places] = before + min(1.0, done) * (after - before)
