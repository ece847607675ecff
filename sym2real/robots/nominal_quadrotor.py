"""Rigid-body equations of any quadrotor from its numbers alone: no simulator, no regression.

Continuous time, forces in world axes, torques in body axes::

    ṗ = v        m v̇ = R(q) e₃ T + F - m g e₃        q̇ = ½ q ⊗ ω        J ω̇ = τ - ω × J ω

Discrete time: mean rates over the step and over its first half (exponential response of the rate loop), attitude
turned by the mean rate, thrust along the axis at mid-step, p += v dt + ½ a dt², v += a dt. Local error: third order.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from sympy import Expr, sign

from sym2real.errors import ModelError
from sym2real.layout import Layout, Layouts
from sym2real.robots.motors import NAMES, Motors
from sym2real.robots.rigid_body import FirstOrder, Vector, body_z, free_fall, gyroscopic, symbols, turn
from sym2real.robots.robot import GRAVITY
from sym2real.symbolic import Equations, symbol

Interface = Literal["thrust_rates", "thrust_attitude", "motors"]
Attitude = Literal["predicted", "measured"]

POSITION, VELOCITY = ("x", "y", "z"), ("vx", "vy", "vz")
QUATERNION, RATES = ("qw", "qx", "qy", "qz"), ("wx", "wy", "wz")
FORCE, TORQUE = ("fx", "fy", "fz"), ("tx", "ty", "tz")
COMMANDS: Mapping[str, tuple[str, ...]] = {
    "thrust_rates": ("thrust", "wx_cmd", "wy_cmd", "wz_cmd"),
    "thrust_attitude": ("thrust", "qw_cmd", "qx_cmd", "qy_cmd", "qz_cmd"),
    "motors": NAMES,
}

# The Crazyflie, from which a robot of another mass and the same shape and density is scaled.
REFERENCE_MASS = 0.027
REFERENCE_INERTIA = (1.66e-5, 1.67e-5, 2.93e-5)
REFERENCE_MOTORS = Motors(thrust=0.0)


@dataclass(frozen=True)
class _Step:
    """What the attitude equations hand to the others: the attitude at mid-step and the next attitude and rates."""

    middle: Vector
    after: Mapping[str, Expr]


def quadrotor(
    mass: float = 1.0,
    inertia: Sequence[float] | None = None,
    *,
    interface: Interface = "thrust_rates",
    attitude: Attitude = "predicted",
    dt: float = 0.02,
    rate_gains: Sequence[float] = (50.0, 50.0, 20.0),
    attitude_time_constant: float = 0.15,
    motors: Motors | None = None,
    robot: str = "",
) -> Equations:
    """First-principles equations of a quadrotor.

    Args:
        mass: in kg; 1 where a log's thrust is mass-normalised (m/s²).
        inertia: principal moments in kg m²; None scales the Crazyflie's by mass.
        interface: actions are thrust in N and body rates in rad/s; thrust and attitude; or four motors.
        attitude: "predicted", or "measured": the quaternion is then an input, known along a log and held over a
            horizon, the state is position and velocity, and only what pushes along body z remains of the actions.
        dt: time step in s.
        rate_gains: gains of the on-board rate loop in 1/s (interface "thrust_rates").
        attitude_time_constant: of the on-board attitude loop in s (interface "thrust_attitude").
        motors: the rotors; None for rotors in scaled Crazyflie geometry that hover at half command.
        robot: name of the robot they describe.

    Raises:
        ModelError: for numbers that no quadrotor has.
    """
    _check(mass, inertia, interface, attitude, dt)
    notes: list[str] = []
    if inertia is None:
        inertia = tuple(moment * (mass / REFERENCE_MASS) ** (5.0 / 3.0) for moment in REFERENCE_INERTIA)
        if _uses_inertia(interface, attitude):
            notes.append("inertia scaled from the Crazyflie by mass^(5/3): measure it")
    quantities: dict[str, Expr] = {}
    torque = symbols(TORQUE)
    if interface == "motors":
        if motors is None:
            motors = _scaled_motors(mass)
            notes.append("motors in scaled Crazyflie geometry, hover at command 0.5: fit the thrust per unit")
        forces = motors.forces(symbols(NAMES))
        quantities["thrust"] = sum(forces)
        if attitude == "predicted":
            names = ("torque_x", "torque_y", "torque_z")
            quantities |= dict(zip(names, motors.torques(forces), strict=True))
            torque = tuple(held + symbol(name) for held, name in zip(torque, names, strict=True))
    if attitude == "measured":
        step = _Step(symbols(QUATERNION), {})
    elif interface == "thrust_attitude":
        step = _attitude_loop(attitude_time_constant, dt)
    elif interface == "thrust_rates":
        step = _rate_loop(inertia, rate_gains, torque, dt)
    else:
        step = _free_rotation(inertia, torque, dt)
    moved = _translation(mass, step.middle, dt)
    columns = _layouts(interface, attitude)
    after = {**moved, **step.after}
    return Equations(
        next={column: after[column] for column in columns.state},
        layouts=columns,
        dt=dt,
        quantities=quantities,
        robot=robot,
        notes=tuple(notes),
    )


def _uses_inertia(interface: Interface, attitude: Attitude) -> bool:
    return attitude == "predicted" and interface != "thrust_attitude"


def _layouts(interface: Interface, attitude: Attitude) -> Layouts:
    commands = COMMANDS[interface]
    if attitude == "measured":
        actions = commands if interface == "motors" else commands[:1]
        return Layouts(Layout.of(POSITION + VELOCITY), Layout.of(actions), Layout.of(FORCE + QUATERNION))
    if interface == "thrust_attitude":
        return Layouts(Layout.of(POSITION + QUATERNION + VELOCITY), Layout.of(commands), Layout.of(FORCE))
    return Layouts(Layout.of(POSITION + QUATERNION + VELOCITY + RATES), Layout.of(commands), Layout.of(FORCE + TORQUE))


def _translation(mass: float, attitude: Vector, dt: float) -> dict[str, Expr]:
    after: dict[str, Expr] = {}
    thrust = symbol("thrust")
    for axis, direction in enumerate(body_z(attitude)):
        acceleration = (thrust * direction + symbol(FORCE[axis])) / mass - (GRAVITY if axis == 2 else 0)
        p, v = POSITION[axis], VELOCITY[axis]
        after[p], after[v] = free_fall(symbol(p), symbol(v), acceleration, dt)
    return after


def _rate_loop(inertia: Sequence[float], gains: Sequence[float], torque: Vector, dt: float) -> _Step:
    """Rates follow their commands: ω̇ = K (ω_cmd - ω) + J⁻¹ (τ - ω × J ω), the last term at the mean rate."""
    rates, commands = symbols(RATES), symbols(COMMANDS["thrust_rates"][1:])
    whole = [FirstOrder(gain, dt) for gain in gains]
    half = [FirstOrder(gain, dt / 2) for gain in gains]
    still = [loop.mean(rate, command, 0) for loop, rate, command in zip(whole, rates, commands, strict=True)]
    drift = [
        push / moment + turning
        for push, moment, turning in zip(torque, inertia, gyroscopic(inertia, still), strict=True)
    ]
    loops = list(zip(rates, commands, drift, strict=True))
    mean = [loop.mean(*terms) for loop, terms in zip(whole, loops, strict=True)]
    first_half = [loop.mean(*terms) for loop, terms in zip(half, loops, strict=True)]
    after = dict(zip(RATES, (loop.end(*terms) for loop, terms in zip(whole, loops, strict=True)), strict=True))
    return _turned(mean, first_half, after, dt)


def _free_rotation(inertia: Sequence[float], torque: Vector, dt: float) -> _Step:
    """J ω̇ = τ - ω × J ω by the mid-point rule."""

    def acceleration(rates: Sequence[Expr]) -> Vector:
        turning = gyroscopic(inertia, rates)
        return tuple(push / moment + turned for push, moment, turned in zip(torque, inertia, turning, strict=True))

    rates = symbols(RATES)
    middle = [rate + dt / 2 * change for rate, change in zip(rates, acceleration(rates), strict=True)]
    end = [rate + dt * change for rate, change in zip(rates, acceleration(middle), strict=True)]
    first_half = [(rate + half) / 2 for rate, half in zip(rates, middle, strict=True)]
    return _turned(middle, first_half, dict(zip(RATES, end, strict=True)), dt)


def _turned(mean: Sequence[Expr], first_half: Sequence[Expr], rates: Mapping[str, Expr], dt: float) -> _Step:
    start = symbols(QUATERNION)
    end = turn(start, [dt * rate for rate in mean])
    middle = turn(start, [dt / 2 * rate for rate in first_half])
    return _Step(middle, {**dict(zip(QUATERNION, end, strict=True)), **rates})


def _attitude_loop(time_constant: float, dt: float) -> _Step:
    """The attitude goes a fraction 1 - e^(-t/τ) of the short way to the command, along the chord."""
    start, wanted = symbols(QUATERNION), symbols(COMMANDS["thrust_attitude"][1:])
    same_side = sign(sum(a * b for a, b in zip(start, wanted, strict=True)))

    def towards(time: float) -> Vector:
        part = 1.0 - math.exp(-time / time_constant) if time_constant > 0 else 1.0
        return tuple((1.0 - part) * a + part * same_side * b for a, b in zip(start, wanted, strict=True))

    middle, end = towards(dt / 2), towards(dt)
    length = sum(component**2 for component in middle) ** 0.5
    return _Step(tuple(component / length for component in middle), dict(zip(QUATERNION, end, strict=True)))


def _scaled_motors(mass: float) -> Motors:
    scale = (mass / REFERENCE_MASS) ** (1.0 / 3.0)
    return Motors(
        thrust=mass * GRAVITY / 4.0 / 0.5,
        torque_per_thrust=REFERENCE_MOTORS.torque_per_thrust * scale,
        arm=REFERENCE_MOTORS.arm * scale,
    )


def _check(mass: float, inertia: Sequence[float] | None, interface: str, attitude: str, dt: float) -> None:
    if interface not in COMMANDS:
        raise ModelError(f"interface must be one of {', '.join(COMMANDS)}, found {interface!r}")
    if attitude not in ("predicted", "measured"):
        raise ModelError(f"attitude must be 'predicted' or 'measured', found {attitude!r}")
    if not mass > 0 or not dt > 0:
        raise ModelError(f"mass in kg and dt in s must be positive, found {mass} and {dt}")
    if inertia is not None and (len(inertia) != 3 or min(inertia) <= 0 or 2 * max(inertia) > sum(inertia) * 1.000001):
        raise ModelError(
            f"inertia must be three positive moments in kg m², none above the sum of the others, found {tuple(inertia)}"
        )
