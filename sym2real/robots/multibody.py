"""First-principles equations of any tree of hinges and slides, from its MJCF: no simulator runs, nothing is fitted.

Continuous time, for coordinates q and their rates::

    M(q) q̈ + c(q, q̇) = τ        τ = actuators + springs and dampers of the joints + external forces

M by the composite-rigid-body algorithm, c by recursive Newton–Euler (:mod:`sym2real.robots.spatial`), q̈ by
elimination. Discrete time: the classical Runge–Kutta method in as many parts of a period as the joint needs
that brakes fastest, in whatever pose, actions and forces held: local error fifth order. Of dry friction the mean of a
part is held, by the accelerations at its start, damped as the implicit midpoint rule has it. Every lengthy intermediate
result has a name.

Effects bind to these quantities: ``gravity_x``, ``gravity_y``, ``gravity_z`` (m/s², world axes); of joint J
``armature_J`` (kg or kg m², inertia that turns with its motor), ``damping_J``, ``drag_J`` (by the squared rate),
``friction_J`` (dry, N or N m), ``stiffness_J``, ``link_mass_J`` (times the mass that the description gives its link),
``link_centre_J`` (times how far its centre of mass lies from a hinge), ``link_inertia_J`` (times its moment of
inertia), ``link_length_J`` (times how far the next joints lie from a hinge), ``servo_gain_J`` (times its servo's gain);
and ``load_S`` (kg, a point mass at site S).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, sqrt

import mujoco
import numpy as np
from sympy import Expr, Integer

from sym2real.errors import ModelError
from sym2real.layout import Layouts
from sym2real.robots import mjcf_columns as columns
from sym2real.robots.covered import LEARN, against_tree
from sym2real.robots.driven import braking, springing
from sym2real.robots.joint_forces import Forces
from sym2real.robots.joint_tree import Link, as_expression, links_of
from sym2real.robots.link_quantities import link_quantities
from sym2real.robots.runge_kutta import Build, Known, fastest, mean_friction, parts_of, stepped
from sym2real.robots.spatial import Force, Inertia, Motion, Transform, Values, along, force_cross, motion_cross
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import names_in
from sym2real.vocabulary import GRAVITY_COMPONENTS, quantity_of, rate_column

# Every part has all of the equations once more.
MOST_PARTS = 8
# What turns fast goes right in parts this long, s, and what dry friction holds; what swings on a spring to a thousandth
# in parts of so many rad. As far as squares of the number of joints, by which equations grow, times parts stay within
# those of six joints in one part.
SHARP, SWING, SHORT = 0.005, 0.5, 36
ROUNDING = 1e-9
TOO_FAST = (
    "somewhere in the joints' ranges a joint is so light that it rests within a small part of a period: predictions "
    "there may run away; narrow the range, give the joint its armature, or take a shorter --dt"
)

LONG = (
    "a period takes {steps} steps, which makes the equations long and slow: {joint} is so light beside what brakes it "
    "that it rests within {rest:.1g} s; give the joint its armature, or take a shorter --dt"
)


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
    if reasons := against_tree(model, layouts.state):
        raise ModelError(
            "expected a robot of hinges and slides that the state holds, with actuators on joints, found "
            f"{' and '.join(reasons)}: {LEARN}"
        )
    links = links_of(model)
    brakes, springs = np.diag(braking(model)), np.diag(springing(model))
    inertias = list(columns.inertias_over_range(model))
    start, *poses = (fastest(inertia, brakes) for inertia in inertias)
    swing = sqrt(max(0.0, *(fastest(inertia, springs) for inertia in inertias)))
    needed = parts_of(max(start, *poses), dt)
    sharp = min(ceil(max(dt / SHARP, swing * dt / SWING) - ROUNDING), MOST_PARTS, SHORT // len(links) ** 2)
    build = Build({}, dt, max(sharp, min(needed, max(MOST_PARTS, parts_of(start, dt)))))
    build.quantities |= {
        name: as_expression(value) for name, value in zip(GRAVITY_COMPONENTS, model.opt.gravity, strict=True)
    }
    for link in links:
        build.quantities |= link.quantities
    build.quantities |= dict.fromkeys(link_quantities(model), Integer(1))
    build.quantities |= {quantity_of("load", model.site(site).name): Integer(0) for site in columns.loaded_sites(model)}
    names = [link.joint for link in links]
    place = np.array([symbol(name) for name in names], dtype=object)
    rate = np.array([symbol(rate_column(name)) for name in names], dtype=object)
    moved, rate = stepped(build, Tree(build, Forces(model, links, actions)), place, rate)
    place = place + moved
    changed = dict(zip(names, place, strict=True)) | dict(zip(map(rate_column, names), rate, strict=True))
    following = {column: changed[column] for column in layouts.state}
    quantities = _used(build.quantities, following, columns.quantities_of(model))
    notes = [TOO_FAST] if needed > build.parts else []
    if build.parts > MOST_PARTS:
        dofs = [model.joint(name).dofadr[0] for name in names]
        lightest = names[int(np.argmax(np.diag(brakes) * model.dof_invweight0[dofs]))]
        notes.append(LONG.format(steps=build.parts, joint=lightest, rest=1.0 / start))
    return Equations(following, layouts, dt, quantities=quantities, notes=tuple(notes))


@dataclass(frozen=True, eq=False)
class Tree:
    """Equations of motion of joints: what ``known`` returns is M ``# (n, n)``, and τ - c without dry friction.

    Args:
        build: takes intermediate results.
        forces: along the joints.
    """

    build: Build
    forces: Forces

    def known(self, place: Values, rate: Values) -> Known:
        """At coordinates in m or rad and rates ``# (n,)``."""
        links, build = self.forces.links, self.build
        transforms = [_named(build, link, coordinate) for link, coordinate in zip(links, place, strict=True)]
        bias = _bias(build, links, transforms, rate)
        drive = build.each("drive", self.forces.at(place, rate) - bias)
        return _mass_matrix(build, links, transforms), drive

    def friction(self, known: Known, rate: Values) -> tuple[Values, Values]:
        """Mean along each joint, N or N m, and what coordinates are off by behind the part, m or rad ``# (n,)``."""
        matrix, drive = known
        damped = matrix + np.diag(self.build.part / 2 * self.forces.brakes)
        unit = np.eye(len(drive), dtype=int).astype(object)
        solved = _solved(self.build, "mean", damped, np.column_stack([drive, unit]))
        friction, early = mean_friction(self.build, self.forces.friction, rate, solved[:, 0], solved[:, 1:])
        return friction, self.build.each("further", solved[:, 1:] @ early)

    def accelerations(self, known: Known, friction: Values) -> Values:
        """Of the coordinates, m/s² or rad/s² ``# (n,)``."""
        matrix, drive = known
        return _solved(self.build, "now", matrix, self.build.each("wanted", drive + friction)[:, None])[:, 0]


def _used(quantities: Mapping[str, Expr], following: Mapping[str, Expr], kept: Sequence[str]) -> dict[str, Expr]:
    """Quantities that lead to the next state, and those that are kept for effects."""
    seen, waiting = set(kept), [*following.values()]
    while waiting:
        fresh = (names_in(waiting.pop()) & quantities.keys()) - seen
        seen |= fresh
        waiting += [quantities[name] for name in fresh]
    return {name: value for name, value in quantities.items() if name in seen}


def _named(build: Build, link: Link, coordinate: Expr) -> Transform:
    placed = link.transform(coordinate)
    return Transform(build.each(f"turn_{link.joint}", placed.turn), build.each(f"place_{link.joint}", placed.place))


def _bias(build: Build, links: Sequence[Link], transforms: Sequence[Transform], rate: Values) -> Values:
    """Forces along the joints that keep every acceleration at zero, by recursive Newton–Euler."""
    still = np.zeros(6, dtype=int).astype(object)
    upwards = np.concatenate([still[:3], -np.array([symbol(name) for name in GRAVITY_COMPONENTS], dtype=object)])
    velocities, accelerations, forces = list[Motion](), list[Motion](), list[Force]()
    for link, transform, speed in zip(links, transforms, rate, strict=True):
        ground, own = link.parent < 0, link.motion * speed
        velocity = transform.motion(still if ground else velocities[link.parent]) + own
        lifted = transform.motion(upwards if ground else accelerations[link.parent])
        velocities.append(_short_vector(build, f"velocity_{link.joint}", velocity))
        accelerations.append(_short_vector(build, f"lift_{link.joint}", lifted + motion_cross(velocity, own)))
        coriolis = force_cross(velocities[-1], link.inertia.times(velocities[-1]))
        forces.append(link.inertia.times(accelerations[-1]) + coriolis)
    bias = np.empty(len(links), dtype=object)
    for number in reversed(range(len(links))):
        link, force = links[number], _short_vector(build, f"force_{links[number].joint}", forces[number])
        bias[number] = along(link.motion, force)
        if link.parent >= 0:
            forces[link.parent] = forces[link.parent] + transforms[number].force_back(force)
    return build.each("bias", bias)


def _mass_matrix(build: Build, links: Sequence[Link], transforms: Sequence[Transform]) -> Values:
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
        matrix[number, number] = along(link.motion, force) + symbol(quantity_of("armature", link.joint))
        while links[at].parent >= 0:
            force = _short_vector(build, f"reach_{link.joint}_{links[at].joint}", transforms[at].force_back(force))
            at = links[at].parent
            matrix[number, at] = matrix[at, number] = along(links[at].motion, force)
    return build.each("mass", matrix)


def _solved(build: Build, name: str, matrix: Values, wanted: Values) -> Values:
    """M⁻¹ times columns ``# (n, k)`` by elimination without pivots: M is positive definite."""
    matrix, wanted, count = matrix.copy(), wanted.copy(), len(wanted)
    for pivot in range(count):
        for row in range(pivot + 1, count):
            if matrix[row, pivot] == 0:
                continue
            factor = build.short(f"{name}_factor_{row}_{pivot}", matrix[row, pivot] / matrix[pivot, pivot])
            for column in range(pivot + 1, count):
                matrix[row, column] = build.short(
                    f"{name}_left_{row}_{column}_{pivot}", matrix[row, column] - factor * matrix[pivot, column]
                )
            wanted[row] = build.each(f"{name}_asked_{row}_{pivot}", wanted[row] - factor * wanted[pivot])
    for row in reversed(range(count)):
        rest = wanted[row] - matrix[row, row + 1 :] @ wanted[row + 1 :]
        wanted[row] = build.each(f"{name}_acceleration_{row}", rest / matrix[row, row])
    return wanted


def _short_vector(build: Build, name: str, vector: Motion | Force) -> Motion | Force:
    return np.concatenate([build.each(f"{name}_w", vector[:3]), build.each(f"{name}_v", vector[3:])])
