"""First-principles equations of any tree of hinges and slides, from its MJCF: no simulator runs, nothing is fitted.

Continuous time, for coordinates q and their rates::

    M(q) q̈ + c(q, q̇) = τ        τ = actuators + springs and dampers of the joints + pushes

M by the composite-rigid-body algorithm, c by recursive Newton–Euler (:mod:`sym2real.robots.spatial`), q̈ by
elimination. Discrete time: the midpoint rule, with actions and pushes held over the step; local error third order.
Every lengthy intermediate result has a name, so that equations stay short.

Effects bind to these quantities: ``gravity_x``, ``gravity_y``, ``gravity_z`` (m/s², world axes); of joint J
``armature_J`` (kg or kg m², inertia that turns with its motor), ``damping_J`` and ``friction_J`` (dry, N or N m); and
``load_S`` (kg, a point mass at site S).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from sympy import Expr, Integer, Max, Min, count_ops, tanh

from sym2real.errors import ModelError
from sym2real.layout import Layouts, push_column, rate_column
from sym2real.robots import mjcf_columns as columns
from sym2real.robots.spatial import (
    Inertia,
    Motion,
    Transform,
    Values,
    about,
    along,
    exact,
    force_cross,
    motion_cross,
)
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import names_in

# m/s², rad/s²: what dry friction takes of a rate, about; within a period of it a joint is held rather than slides.
SLOW = 0.3
LONGEST = 4  # operations of an expression that needs no name


@dataclass(frozen=True, eq=False)
class Link:
    """One joint, and what moves with it.

    Args:
        joint: its name.
        parent: number of the link that carries it; -1 for the ground.
        fixed: from the parent's axes to the joint's, with the joint at zero.
        axis: of the joint in the link's axes ``# (3,)``.
        turns: whether it is a hinge.
        inertia: of the bodies that move with it, in the link's axes about its origin.
        armature, damping, stiffness, rest: of the joint, SI units.
        friction: its dry friction, N or N m.
    """

    joint: str
    parent: int
    fixed: Transform
    axis: Values
    turns: bool
    inertia: Inertia
    armature: float
    damping: float
    stiffness: float
    rest: float
    friction: float

    def transform(self, coordinate: Expr) -> Transform:
        """From the parent's axes to the link's where the joint stands."""
        if not self.turns:
            return Transform(self.fixed.turn, self.fixed.place + self.fixed.turn.T @ (self.axis * coordinate))
        return Transform(about(self.axis, coordinate).T @ self.fixed.turn, self.fixed.place)

    @property
    def motion(self) -> Motion:
        """Of a unit rate of the joint."""
        zero = np.zeros(3, dtype=int).astype(object)
        return (self.axis, zero) if self.turns else (zero, self.axis)


@dataclass
class _Build:
    """Equations in the making: intermediate results by name, those of one evaluation with one prefix."""

    quantities: dict[str, Expr] = field(default_factory=dict)
    prefix: str = ""

    def short(self, name: str, expression: Expr) -> Expr:
        """The expression, or a name for it where it is long."""
        if count_ops(expression) <= LONGEST:
            return expression
        self.quantities[self.prefix + name] = expression
        return symbol(self.prefix + name)

    def each(self, name: str, values: Values) -> Values:
        """An array of expressions, each short; the numbers of entries are part of their names."""
        found = np.empty_like(values, dtype=object)
        for place in np.ndindex(values.shape):
            found[place] = self.short(f"{name}_{'_'.join(map(str, place))}", values[place])
        return found


def multibody(model: mujoco.MjModel, layouts: Layouts, actions: Mapping[str, str], dt: float) -> Equations:
    """Equations of a compiled MJCF.

    Args:
        model: the compiled file.
        layouts: of the robot; every joint's coordinate and rate must be in the state.
        actions: column of the action by actuator.
        dt: control period in s.

    Raises:
        ModelError: for what these equations do not cover, naming it.
    """
    _require_covered(model, layouts)
    links = links_of(model)
    build = _Build()
    build.quantities |= {name: _number(value) for name, value in zip(columns.GRAVITY, model.opt.gravity, strict=True)}
    build.quantities |= {f"armature_{link.joint}": _number(link.armature) for link in links}
    build.quantities |= {f"load_{model.site(one).name}": Integer(0) for one in columns.loaded_sites(model)}
    build.quantities |= {f"damping_{link.joint}": _number(link.damping) for link in links}
    build.quantities |= {f"friction_{link.joint}": _number(link.friction) for link in links}
    forces = _Forces(model, links, actions, SLOW * dt)
    names = [link.joint for link in links]
    place = np.array([symbol(name) for name in names], dtype=object)
    rate = np.array([symbol(rate_column(name)) for name in names], dtype=object)
    start = _accelerations(build, links, place, rate, forces.at(place, rate))
    build.prefix = "mid_"
    half = build.each("rate", rate + dt / 2 * start)
    middle = build.each("place", place + dt / 2 * rate + dt**2 / 8 * start)
    acceleration = _accelerations(build, links, middle, half, forces.at(middle, half))
    # Exact where the acceleration changes linearly over the step.
    moved = dt * rate + dt**2 / 6 * (start + 2 * acceleration)
    following = {name: p + change for name, p, change in zip(names, place, moved, strict=True)}
    following |= {rate_column(n): r + dt * a for n, r, a in zip(names, rate, acceleration, strict=True)}
    following = {column: following[column] for column in layouts.state}
    return Equations(
        following, layouts, dt, quantities=_used(build.quantities, following, columns.quantities_of(model))
    )


def _accelerations(build: _Build, links: Sequence[Link], place: Values, rate: Values, force: Values) -> Values:
    transforms = [_named(build, link, one) for link, one in zip(links, place, strict=True)]
    bias = _bias(build, links, transforms, rate)
    wanted = build.each("drive", force - bias)
    return _solved(build, _mass_matrix(build, links, transforms), wanted)


def _used(quantities: Mapping[str, Expr], following: Mapping[str, Expr], kept: Sequence[str]) -> dict[str, Expr]:
    """Quantities that lead to the next state, and those that are kept for effects."""
    seen, waiting = set(kept), [*following.values()]
    while waiting:
        fresh = (names_in(waiting.pop()) & quantities.keys()) - seen
        seen |= fresh
        waiting += [quantities[name] for name in fresh]
    return {name: value for name, value in quantities.items() if name in seen}


def _named(build: _Build, link: Link, coordinate: Expr) -> Transform:
    found = link.transform(coordinate)
    return Transform(build.each(f"turn_{link.joint}", found.turn), build.each(f"place_{link.joint}", found.place))


def _bias(build: _Build, links: Sequence[Link], transforms: Sequence[Transform], rate: Values) -> Values:
    """Forces along the joints that keep every acceleration at zero, by recursive Newton–Euler."""
    still = np.zeros(3, dtype=int).astype(object)
    upwards = -np.array([symbol(name) for name in columns.GRAVITY], dtype=object)
    velocities: list[Motion] = []
    accelerations: list[Motion] = []
    forces = []
    for link, transform, speed in zip(links, transforms, rate, strict=True):
        ground = link.parent < 0
        own = tuple(part * speed for part in link.motion)
        before = (still, still) if ground else velocities[link.parent]
        carried = transform.motion(before)
        velocity = (carried[0] + own[0], carried[1] + own[1])
        turning = motion_cross(velocity, (own[0], own[1]))
        lifted = transform.motion((still, upwards) if ground else accelerations[link.parent])
        acceleration = (lifted[0] + turning[0], lifted[1] + turning[1])
        velocities.append(_short_pair(build, f"velocity_{link.joint}", velocity))
        accelerations.append(_short_pair(build, f"lift_{link.joint}", acceleration))
        pushed, carried_on = (
            link.inertia.times(accelerations[-1]),
            force_cross(velocities[-1], link.inertia.times(velocities[-1])),
        )
        forces.append((pushed[0] + carried_on[0], pushed[1] + carried_on[1]))
    bias = np.empty(len(links), dtype=object)
    for number in reversed(range(len(links))):
        link, force = links[number], _short_pair(build, f"force_{links[number].joint}", forces[number])
        bias[number] = along(link.motion, force)
        if link.parent >= 0:
            back, other = transforms[number].force_back(force), forces[link.parent]
            forces[link.parent] = (other[0] + back[0], other[1] + back[1])
    return build.each("bias", bias)


def _mass_matrix(build: _Build, links: Sequence[Link], transforms: Sequence[Transform]) -> Values:
    """M by the composite-rigid-body algorithm ``# (n, n)``."""
    whole = [link.inertia for link in links]
    count = len(links)
    matrix = np.zeros((count, count), dtype=int).astype(object)
    for number in reversed(range(count)):
        link = links[number]
        name = f"whole_{link.joint}"
        own = whole[number]
        whole[number] = Inertia(own.mass, build.each(f"{name}_m", own.moment), build.each(name, own.about_origin))
        if link.parent >= 0:
            whole[link.parent] += whole[number].in_parent(transforms[number])
        force, at = whole[number].times(link.motion), number
        matrix[number, number] = along(link.motion, force) + symbol(f"armature_{link.joint}")
        while links[at].parent >= 0:
            force = _short_pair(build, f"reach_{link.joint}_{links[at].joint}", transforms[at].force_back(force))
            at = links[at].parent
            matrix[number, at] = matrix[at, number] = along(links[at].motion, force)
    return build.each("mass", matrix)


def _solved(build: _Build, matrix: Values, wanted: Values) -> Values:
    """M⁻¹ times a vector by elimination without pivots: M is positive definite."""
    matrix, wanted, count = matrix.copy(), wanted.copy(), len(wanted)
    for pivot in range(count):
        for row in range(pivot + 1, count):
            if matrix[row, pivot] == 0:
                continue
            factor = build.short(f"factor_{row}_{pivot}", matrix[row, pivot] / matrix[pivot, pivot])
            for column in range(pivot + 1, count):
                matrix[row, column] = build.short(
                    f"left_{row}_{column}_{pivot}", matrix[row, column] - factor * matrix[pivot, column]
                )
            wanted[row] = build.short(f"asked_{row}_{pivot}", wanted[row] - factor * wanted[pivot])
    for row in reversed(range(count)):
        rest = wanted[row] - sum(matrix[row, column] * wanted[column] for column in range(row + 1, count))
        wanted[row] = build.short(f"acceleration_{row}", rest / matrix[row, row])
    return wanted


@dataclass(frozen=True, eq=False)
class _Forces:
    """Along the joints: pushes, springs, dampers, dry friction and actuators.

    Args:
        model: the compiled file.
        links: its joints.
        actions: column of the action by actuator.
        slow: rate below which dry friction holds rather than brakes, m/s or rad/s.
    """

    model: mujoco.MjModel
    links: Sequence[Link]
    actions: Mapping[str, str]
    slow: float

    def at(self, place: Values, rate: Values) -> Values:
        """Where the joints are and how fast they move ``# (n,)``."""
        force = np.array([symbol(push_column(link.joint)) for link in self.links], dtype=object)
        for number, link in enumerate(self.links):
            force[number] += -symbol(f"damping_{link.joint}") * rate[number]
            force[number] += -symbol(f"friction_{link.joint}") * tanh(rate[number] / self.slow)
            force[number] += -_number(link.stiffness) * (place[number] - _number(link.rest))
        numbers = {link.joint: number for number, link in enumerate(self.links)}
        for name, column in self.actions.items():
            index = self.model.actuator(name).id
            joint = numbers[self.model.joint(int(self.model.actuator_trnid[index, 0])).name]
            force[joint] += self._given(index, symbol(column), place[joint], rate[joint])
        return force

    def _given(self, index: int, told: Expr, place: Expr, rate: Expr) -> Expr:
        """By an actuator's gain and bias, within its limits."""
        model = self.model
        gear, gain = _number(model.actuator_gear[index, 0]), _number(model.actuator_gainprm[index, 0])
        constant, by_place, by_rate = (_number(one) for one in model.actuator_biasprm[index, :3])
        given = gain * told + constant + by_place * gear * place + by_rate * gear * rate
        if model.actuator_forcelimited[index]:
            low, high = model.actuator_forcerange[index]
            given = Max(Min(given, float(high)), float(low))
        return gear * given


def links_of(model: mujoco.MjModel) -> list[Link]:
    """Joints in MuJoCo's order, each with the bodies that move with it; several joints of a body follow each other."""
    found: list[Link] = []
    # Of every body: the link that carries it, and the way from that link's axes to the body's.
    carried = {0: (-1, Transform(np.eye(3, dtype=int).astype(object), exact(np.zeros(3))))}
    for body in range(1, model.nbody):
        parent, frame = carried[int(model.body_parentid[body])]
        here = _placed(frame, model.body_pos[body], _matrix(model.body_quat[body]))
        for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            turns = bool(model.jnt_type[joint] == columns.HINGE)
            anchor = exact(model.jnt_pos[joint]) if turns else exact(np.zeros(3))
            fixed = Transform(here.turn, here.place + here.turn.T @ anchor)
            found.append(_link(model, joint, parent, fixed))
            parent, here = len(found) - 1, Transform(np.eye(3, dtype=int).astype(object), -anchor)
        carried[body] = (parent, here)
        if parent >= 0:
            link = found[parent]
            added = _body_inertia(model, body, here)
            found[parent] = Link(**{**vars(link), "inertia": link.inertia + added})
    return found


def _link(model: mujoco.MjModel, joint: int, parent: int, fixed: Transform) -> Link:
    dof, nothing = int(model.jnt_dofadr[joint]), exact(np.zeros(3))
    return Link(
        joint=model.joint(joint).name,
        parent=parent,
        fixed=fixed,
        axis=exact(model.jnt_axis[joint]),
        turns=bool(model.jnt_type[joint] == columns.HINGE),
        inertia=Inertia(0, nothing, exact(np.zeros((3, 3)))),
        armature=float(model.dof_armature[dof]),
        damping=float(model.dof_damping[dof]),
        stiffness=float(model.jnt_stiffness[joint]),
        rest=float(model.qpos_spring[model.jnt_qposadr[joint]]),
        friction=float(model.dof_frictionloss[dof]),
    )


def _body_inertia(model: mujoco.MjModel, body: int, frame: Transform) -> Inertia:
    """Of a body and the loads at its sites, in the axes of the link that carries it."""
    to_link = np.array(frame.turn.T, dtype=object)
    principal = _matrix(model.body_iquat[body])
    about_centre = exact(principal @ np.diag(model.body_inertia[body]) @ principal.T)
    centre = frame.place + to_link @ exact(model.body_ipos[body])
    whole = Inertia.of_body(_number(model.body_mass[body]), centre, to_link @ about_centre @ to_link.T)
    for site in columns.loaded_sites(model):
        if model.site_bodyid[site] == body:
            place = frame.place + to_link @ exact(model.site_pos[site])
            whole += Inertia.of_body(symbol(f"load_{model.site(site).name}"), place, exact(np.zeros((3, 3))))
    return whole


def _placed(frame: Transform, place: Values, turn: Values) -> Transform:
    """A frame in a frame: where it is, and the matrix from its axes to those of the other."""
    return Transform(exact(turn).T @ frame.turn, frame.place + frame.turn.T @ exact(place))


def _matrix(quaternion: Values) -> Values:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quaternion, dtype=np.float64))
    return matrix.reshape(3, 3)


def _short_pair(build: _Build, name: str, pair: tuple[Values, Values]) -> tuple[Values, Values]:
    return build.each(f"{name}_w", pair[0]), build.each(f"{name}_v", pair[1])


def _number(value: Any) -> Expr:
    return exact(np.array([float(value)]))[0] + Integer(0)


def _require_covered(model: mujoco.MjModel, layouts: Layouts) -> None:
    names = columns.names_of(model, "joint")
    missing = [one for name in names for one in (name, rate_column(name)) if one not in layouts.state]
    by_joint = (model.actuator_trntype == columns.BY_JOINT).all() and not model.actuator_dyntype.any()
    wrong = {
        "a free joint": columns.FREE in model.jnt_type.tolist(),
        f"no {', '.join(missing)} in the state": bool(missing),
        "tendons or equality constraints": bool(model.ntendon or model.neq),
        "an actuator with a filter, or on no joint": not by_joint,
    }
    found = [what for what, holds in wrong.items() if holds]
    if found:
        raise ModelError(
            "expected a robot of hinges and slides that the state holds, with actuators on joints, found "
            f"{' and '.join(found)}: learn its equations from the simulator"
        )
