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

from collections.abc import Callable, Mapping, Sequence
from functools import partial
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
from sym2real.robots.runge_kutta import Build, fastest, parts_of, stepped
from sym2real.robots.spatial import Values, exact
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.dry_friction import dry_friction
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
        parts_of(decay, dt, dry=True),
    )
    moved = [1.0 / float(way @ np.linalg.solve(inertia, way)) for way in wheels.ways]
    forces = Forces(model, links, actions, build.part, moved)
    against = partial(dry_friction, symbol(DRILLING), dt=build.part, inertia=inertia[1, 1])
    sine, cosine = symbol("sin_yaw"), symbol("cos_yaw")
    build.quantities |= {
        "push_ahead": symbol("fx") * cosine + symbol("fy") * sine,
        "push_left": symbol("fy") * cosine - symbol("fx") * sine,
    }
    speed = build.name("speed_ahead", symbol("vx") * cosine + symbol("vy") * sine)
    (moved, turned), (speed, turning) = stepped(
        build,
        lambda _, rates: _accelerations(build, rates, forces, lever, against),
        exact(np.zeros(2)),
        np.array([speed, symbol("wz")]),
    )
    build.quantities |= {
        "next_speed": speed,
        "half_turn": turned / 2,
        # sin(h)/h by its series, as of a car.
        "chord": moved * (1 - symbol("half_turn") ** 2 / 6),
    }
    following, notes = along_the_arc(turning), (WIDE.format(brakes),) if brakes else ()
    return Equations(following, layouts, dt, quantities=build.quantities, notes=notes)


def _accelerations(
    build: Build, rates: Values, forces: Forces, lever: Sequence[float], drilling: Callable[..., Expr]
) -> Values:
    """Of the speed ahead (m/s²) and the turning (rad/s²) ``# (2,)``.

    Args:
        build: takes intermediate results.
        rates: the speed ahead, and the turning ``# (2,)``.
        forces: along the wheels' joints.
        lever: where external forces act, in the body's axes, m ``# (2,)``.
        drilling: of wheels with a width: its torque by the turning rate and the other torques.
    """
    names, (speed, turning) = [link.joint for link in forces.links], rates
    ways = [_way(name) for name in names]
    of_wheels = [
        build.name(rate_column(name), a * speed + b * turning) for name, (a, b) in zip(names, ways, strict=True)
    ]
    along = forces.at(exact(np.zeros(len(names))), np.array(of_wheels, dtype=object))
    along = forces.held(of_wheels, build.each("drive", along))
    torques = [
        build.name(f"torque_{name}", within(force, -symbol(f"most_{name}"), symbol(f"most_{name}")))
        for name, force in zip(names, along, strict=True)
    ]
    centrifugal = symbol(MASS_MOMENT) * turning
    forward, aside, (x, y) = symbol("push_ahead"), symbol("push_left"), lever
    by_wheels = [sum(way[of] * torque for way, torque in zip(ways, torques, strict=True)) for of in (0, 1)]
    ahead = build.name("force", by_wheels[0] + forward + centrifugal * turning)
    turned = symbol("tz") + x * aside - y * forward - centrifugal * speed
    turned = build.name("turned", by_wheels[1] + turned)
    turn = build.name("moment", turned + drilling(turning, other=turned))
    whole, mixed, spun = (symbol(name) for name in MASSES)
    span = whole * spun - mixed**2
    return build.each("acceleration", np.array([spun * ahead - mixed * turn, whole * turn - mixed * ahead]) / span)


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
