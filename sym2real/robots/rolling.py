"""First-principles equations of a robot in a plane on wheels that roll without slip, all on one axle.

Two degrees of freedom, the speed u along the heading and the turning rate ω; the wheels turn with them at W (u, ω)
(:mod:`sym2real.robots.planar`). With m and its moments m c about the origin, from the MJCF::

    M (u̇, ω̇) + (-m c_x ω², m c_x u ω) = Wᵀ τ + external forces

Lagrange's equations of a body in a plane, M with all that turns with a wheel; e.g. Y. Yamamoto, X. Yun, "Coordinating
locomotion and manipulation of a mobile manipulator", 1994. Discrete time: the classical Runge–Kutta method in as many
parts of a period as the servos of the wheels need, moved along the arc of the mean rates. Contacts hold here, but for
wheels that spin or lock (``J_grip``): a robot that slides aside, tips or lifts a wheel is not described.

Effects bind to the rate ``J_rate`` of wheel J, which is a quantity, to ``damping_J``, ``friction_J`` and ``armature_J``
as of :mod:`sym2real.robots.multibody`, to ``J_per_speed`` (rad/m), ``J_lever`` (m) and ``J_grip`` (N m, without a
limit), to the masses (``mass_ahead``, ``mass_moment``, ``mass_turning``), to ``drilling`` (N m, of wheels with a
width), and to the external forces.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from sympy import Expr, Float

from sym2real.errors import ModelError
from sym2real.layout import Layouts
from sym2real.robots import mjcf_columns as columns
from sym2real.robots.covered import LEARN, against_rolling
from sym2real.robots.driven import braking
from sym2real.robots.joint_forces import Forces, within
from sym2real.robots.joint_tree import Link, as_expression, links_of
from sym2real.robots.nominal_car import along_the_arc
from sym2real.robots.planar import OF_FREE, Wheels, drilling
from sym2real.robots.runge_kutta import Build, Known, fastest, mean_friction, parts_of, stepped
from sym2real.robots.spatial import Values, exact
from sym2real.symbolic import Equations, symbol
from sym2real.trajectory import Array
from sym2real.vocabulary import (
    DRILLING,
    MASS_AHEAD,
    MASS_MOMENT,
    MASS_TURNING,
    UNLIMITED,
    quantity_of,
    rate_column,
    rate_per_speed,
    wheel_grip,
    wheel_lever,
)

WIDE = "wide wheels brake a turn by {:.3g} N m where they drill on the floor; how they creep then is not described"
MASSES = (MASS_AHEAD, "mass_both", MASS_TURNING)  # kg, kg m, kg m²


def rolling(model: mujoco.MjModel, data: Any, layouts: Layouts, actions: Mapping[str, str], dt: float) -> Equations:
    """Equations of a compiled MJCF.

    Args:
        model: the compiled file.
        data: where the robot stands on its wheels, facing along x.
        layouts: of the robot.
        actions: column of the action by actuator.
        dt: control period in s.

    Raises:
        ModelError: for what these equations do not cover, naming it.
    """
    wheels = Wheels.of(model, data)
    if why := against_rolling(model, wheels):
        raise ModelError(f"expected wheels of one axle that roll with the robot, found {' and '.join(why)}: {LEARN}")
    links = [link for link in links_of(model) if link.joint in wheels.names]
    aside, turn = (wheels.first + dof for dof in OF_FREE[1:])
    moment = float(columns.inertias(model, data)[aside, turn])
    lever = (data.subtree_com[wheels.body] - data.xpos[wheels.body])[:2].tolist()
    inertia, brakes = wheels.inertia(model, data), drilling(model, data)
    spinning = columns.inertias(model, data)[wheels.dofs, wheels.dofs]
    decay = fastest(inertia, wheels.ways.T @ np.diag(braking(model)[wheels.dofs]) @ wheels.ways)
    build = Build(
        _numbers(links, wheels, inertia, spinning)
        | {MASS_MOMENT: as_expression(moment), DRILLING: as_expression(brakes)},
        dt,
        parts_of(decay, dt),
    )
    sine, cosine = symbol("sin_yaw"), symbol("cos_yaw")
    build.quantities |= {
        "push_ahead": symbol("fx") * cosine + symbol("fy") * sine,
        "push_left": symbol("fy") * cosine - symbol("fx") * sine,
    }
    speed = build.name("speed_ahead", symbol("vx") * cosine + symbol("vy") * sine)
    axle = Axle(build, Forces(model, links, actions), lever)
    rates = np.array([speed, symbol("wz")])
    (moved, turned), (speed, turning) = stepped(build, axle, exact(np.zeros(2)), rates)
    build.quantities |= {
        "next_speed": speed,
        "half_turn": turned / 2,
        # sin(h)/h by its series, as of a car.
        "chord": moved * (1 - symbol("half_turn") ** 2 / 6),
    }
    following, notes = along_the_arc(turning), (WIDE.format(brakes),) if brakes else ()
    return Equations(following, layouts, dt, quantities=build.quantities, notes=notes)


@dataclass(frozen=True, eq=False)
class Axle:
    """Equations of motion: what ``known`` returns is forces along the wheels, and what else pushes and turns.

    Their friction is that of the wheels' joints, and behind it of wheels with a width that drill ``# (n + 1,)``.

    Args:
        build: takes intermediate results.
        forces: along the wheels' joints.
        lever: where external forces act, in the body's axes, m ``# (2,)``.
    """

    build: Build
    forces: Forces
    lever: Sequence[float]

    def known(self, place: Values, rate: Values) -> Known:
        """At a speed ahead in m/s and a turning rate in rad/s ``# (2,)``, wherever that is."""
        speed, turning = rate
        names = [link.joint for link in self.forces.links]
        of_wheels = [
            self.build.name(rate_column(name), along) for name, along in zip(names, self._ways @ rate, strict=True)
        ]
        along = self.forces.at(exact(np.zeros(len(names))), np.array(of_wheels, dtype=object))
        forward, aside, (x, y) = symbol("push_ahead"), symbol("push_left"), self.lever
        centrifugal = symbol(MASS_MOMENT) * turning
        ahead = self.build.name("push", forward + centrifugal * turning)
        turned = self.build.name("turned", symbol("tz") + x * aside - y * forward - centrifugal * speed)
        return self.build.each("drive", along), np.array([ahead, turned])

    def friction(self, known: Known, rate: Values) -> tuple[Values, Values]:
        """Mean torques in N m ``# (n + 1,)``, and what the way in m and the turn in rad are off by ``# (2,)``."""
        along, body = known
        ways = np.vstack([self._ways, exact(np.array([[0.0, 1.0]]))])
        brakes = self._ways.T @ np.diag(self.build.part / 2 * self.forces.brakes) @ self._ways
        inverse = self._inverse("mean", brakes)
        free = self.build.each("free", inverse @ self._sum("mean", along, body))
        by_forces = self.build.each("by", ways @ inverse @ ways.T)
        friction, early = mean_friction(
            self.build, [*self.forces.friction, symbol(DRILLING)], ways @ rate, ways @ free, by_forces
        )
        return friction, self.build.each("further", inverse @ ways.T @ early)

    def accelerations(self, known: Known, friction: Values) -> Values:
        """Of the speed ahead (m/s²) and the turning (rad/s²) ``# (2,)``."""
        along, (ahead, turned) = known
        body = np.array([ahead, turned + friction[-1]])
        return self.build.each("acceleration", self._inverse("now") @ self._sum("now", along + friction[:-1], body))

    @property
    def _ways(self) -> Values:
        """Rate of every wheel per speed forward and per turning rate ``# (n, 2)``."""
        return np.array([_way(link.joint) for link in self.forces.links], dtype=object)

    def _sum(self, name: str, along: Values, body: Values) -> Values:
        """Force ahead in N and torque in N m of the wheels, as far as they grip, and what else acts ``# (2,)``."""
        torques = [
            self.build.name(
                f"torque_{name}_{link.joint}",
                within(force, -symbol(f"most_{link.joint}"), symbol(f"most_{link.joint}")),
            )
            for link, force in zip(self.forces.links, along, strict=True)
        ]
        return self.build.each(f"moment_{name}", self._ways.T @ torques + body)

    def _inverse(self, name: str, more: Values | int = 0) -> Values:
        """Of the masses, and what is added to them ``# (2, 2)``."""
        whole, mixed, spun = (symbol(mass) for mass in MASSES)
        (a, b), (_, c) = self.build.each(f"masses_{name}", np.array([[whole, mixed], [mixed, spun]]) + more)
        span = self.build.name(f"span_{name}", a * c - b**2)
        return np.array([[c, -b], [-b, a]]) / span


def _way(wheel: str) -> tuple[Expr, Expr]:
    """Rate of a wheel per speed forward and per turning rate."""
    per_speed = symbol(rate_per_speed(wheel))
    return per_speed, per_speed * symbol(wheel_lever(wheel))


def _numbers(links: Sequence[Link], wheels: Wheels, inertia: Array, spinning: Array) -> dict[str, Expr]:
    """What joints have, by the names of :mod:`sym2real.robots.multibody`, and the matrix of masses with them.

    Args:
        links: the wheels' joints.
        wheels: how they roll.
        inertia: of all that moves with the body, wheels and all ``# (2, 2)``.
        spinning: of each wheel about its axle, kg m² ``# (n,)``.
    """
    quantities: dict[str, Expr] = {}
    moved = 1.0 / np.einsum("wi,ij,wj->w", wheels.ways, np.linalg.inv(inertia), wheels.ways)
    # A wheel that slips turns with what its servo gives; here it goes on to turn with the robot, and that takes a part.
    shares = moved / (moved - spinning)
    for link, (ahead, turn), share in zip(links, wheels.ways.tolist(), shares.tolist(), strict=True):
        quantities[rate_per_speed(link.joint)] = as_expression(ahead)
        quantities[wheel_lever(link.joint)] = as_expression(turn / ahead)
        quantities[wheel_grip(link.joint)] = Float(UNLIMITED)
        quantities[f"most_{link.joint}"] = share * symbol(wheel_grip(link.joint))
        quantities |= link.quantities
    for name, (row, column) in zip(MASSES, ((0, 0), (0, 1), (1, 1)), strict=True):
        body = float(inertia[row, column] - wheels.ways[:, row] * wheels.ways[:, column] @ spinning)
        turned = [
            float(spin) - link.armature + symbol(quantity_of("armature", link.joint))
            for link, spin in zip(links, spinning, strict=True)
        ]
        ways = [_way(link.joint) for link in links]
        quantities[name] = body + sum(spin * way[row] * way[column] for spin, way in zip(turned, ways, strict=True))
    return quantities
