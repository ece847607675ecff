"""Kinematic bicycle from its numbers alone, in world-frame states.

Origin in the middle of the rear axle, u the speed along the heading::

    ẋ = u cos ψ     ẏ = u sin ψ     ψ̇ = u tan δ / L     u̇ = (u_cmd - u)/τ + P/m, or a_cmd + P/m
    P = F·e + (τ_z + c F·n) tan δ / L

While the tyres hold, the car has one degree of freedom, along the heading e; a yaw torque, and a force along n, left
of the heading, at the centre of mass c ahead of the rear axle, do work on it because the heading turns: P by virtual
work.

Discrete time: mean speed over the step, heading turned by the exact angle, position moved along the arc's chord, so
that a steady turn stays on its circle. Velocity across the heading is zero after a step: the tyres hold.
"""

import math

from sympy import Expr, cos, sin, tan

from sym2real.errors import ModelError
from sym2real.layout import Layout, Layouts
from sym2real.robots.likely import unlikely_in_car
from sym2real.robots.rigid_body import FirstOrder
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import CarCommand

STATE, WRENCH = Layout.of(("x", "y", "sin_yaw", "cos_yaw", "vx", "vy", "wz")), Layout.of(("fx", "fy", "tz"))


def car(
    wheelbase: float,
    *,
    command: CarCommand = "speed",
    time_constant: float = 0.0,
    mass: float = 3.5,
    centre: float | None = None,
    dt: float = 0.05,
    robot: str = "",
) -> Equations:
    """First-principles equations of a front-steered car at speeds where its tyres hold.

    Args:
        wheelbase: in m.
        command: actions are steering in rad, and speed in m/s or acceleration along the heading in m/s².
        time_constant: of the speed loop in s; 0 reaches the commanded speed at once, but for what a force gives in one
            step, which the loop leaves.
        mass: that a force must move, with spinning wheels, in kg.
        centre: distance of the centre of mass ahead of the rear axle in m; by default half the wheelbase.
        dt: time step in s.
        robot: name of the robot they describe.

    Raises:
        ModelError: for a wheelbase, mass or time step that is not positive, a negative time constant, or one of a speed
            loop where there is none.

    Examples:
        >>> car(wheelbase=0.3).next["x"]
        chord*(cos_yaw*cos(half_turn) - sin_yaw*sin(half_turn)) + x
    """
    if not (0 < wheelbase < math.inf and 0 < mass < math.inf and 0 < dt < math.inf and 0 <= time_constant < math.inf):
        raise ModelError(
            "wheelbase in m, mass in kg and dt in s must be positive and the time constant in s at least 0, "
            f"found {wheelbase}, {mass}, {dt} and {time_constant}"
        )
    if command != "speed" and (command != "acceleration" or time_constant):
        raise ModelError(
            f"expected command speed, or acceleration without time_constant, found {command}, {time_constant}"
        )
    centre = wheelbase / 2 if centre is None else centre
    sine, cosine = symbol("sin_yaw"), symbol("cos_yaw")
    forward = symbol("vx") * cosine + symbol("vy") * sine
    curvature = tan(symbol("steer")) / wheelbase
    ahead = symbol("fx") * cosine + symbol("fy") * sine
    left = symbol("fy") * cosine - symbol("fx") * sine
    pull = (ahead + (symbol("tz") + centre * left) * curvature) / mass
    speed, mean = _speeds(symbol(command), pull, forward, None if command == "acceleration" else time_constant, dt)
    return Equations(
        next=along_the_arc(symbol("next_speed") * curvature),
        layouts=Layouts(STATE, Layout.of(("steer", command)), WRENCH),
        dt=dt,
        quantities={
            "next_speed": speed,
            "mean_speed": mean,
            "half_turn": symbol("mean_speed") * curvature * dt / 2,
            # sin(h)/h by its series: 1e-6 for a turn of 0.2 rad in one step, and finite where the car goes straight.
            "chord": symbol("mean_speed") * dt * (1 - symbol("half_turn") ** 2 / 6),
        },
        robot=robot,
        notes=tuple(unlikely_in_car(wheelbase, mass)),
        numbers={"mass": mass, "wheelbase": wheelbase, "centre": centre}
        | ({"speed_time": time_constant} if time_constant else {}),
    )


def _speeds(command: Expr, pull: Expr, forward: Expr, time_constant: float | None, dt: float) -> tuple[Expr, Expr]:
    """Along the heading, at the end of a step and in its mean; without a time constant an acceleration is commanded."""
    if time_constant is None:
        gained = dt * (command + pull)
        return forward + gained, forward + gained / 2
    if not time_constant:  # a loop that takes one step to make up for a force: the speed is off by what that gives
        return command + dt * pull, command + dt * pull
    loop = FirstOrder(1.0 / time_constant, dt)
    return loop.end(forward, command, pull), loop.mean(forward, command, pull)


def along_the_arc(turning: Expr) -> dict[str, Expr]:
    """Next states by the quantities ``chord`` (m), ``half_turn`` (rad), ``next_speed`` (m/s), and the rate reached."""
    speed, chord = symbol("next_speed"), symbol("chord")
    (sine_between, cosine_between), (sine, cosine) = (_heading(times * symbol("half_turn")) for times in (1, 2))
    return {
        "x": symbol("x") + chord * cosine_between,
        "y": symbol("y") + chord * sine_between,
        "sin_yaw": sine,
        "cos_yaw": cosine,
        "vx": speed * cosine,
        "vy": speed * sine,
        "wz": turning,
    }


def _heading(turned: Expr) -> tuple[Expr, Expr]:
    """Sine and cosine of the heading, turned by an angle."""
    sine, cosine = symbol("sin_yaw"), symbol("cos_yaw")
    return sine * cos(turned) + cosine * sin(turned), cosine * cos(turned) - sine * sin(turned)
