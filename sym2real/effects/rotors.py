"""The rotors of a rotorcraft: the thrust of each, commanded itself or behind a thrust and three torques.

Commanded motors may be any number, at any places. Those behind a thrust and torques are four in X configuration,
motor1 to motor4 front right, back right, back left, front left; seen from above motor1 and motor3 turn so that their
reaction torque is negative (Crazyflie firmware, ``power_distribution_quadrotor.c``).
"""

import math
from collections.abc import Sequence

from sympy import Expr, Float, Integer

from sym2real.effects.body import Body
from sym2real.effects.loops import NUMBERS, rate_loops
from sym2real.effects.terms import acting, acting_thrust
from sym2real.layout import motors_of
from sym2real.symbolic import Equations
from sym2real.vocabulary import MOTOR_TORQUES

FRONT, LEFT, SPIN = (1, -1, -1, 1), (-1, -1, 1, 1), (-1, 1, -1, 1)


def levers(body: Body, rotor: int) -> tuple[float, float, float]:
    """Torque about body axes in N m per N of a rotor 0 to 3."""
    lever = body.number("arm") / math.sqrt(2.0)
    return (LEFT[rotor] * lever, -FRONT[rotor] * lever, SPIN[rotor] * body.number("torque_per_thrust"))


def shares(equations: Equations, body: Body) -> tuple[Expr, ...]:
    """Thrust of each rotor in N, by the mixer's inverse from thrust and the mean torque of the rate loop."""
    quarter = acting_thrust(equations) / 4
    if not all(name in body.numbers for name in NUMBERS) or "wx_cmd" not in body.names:
        return (quarter,) * 4
    torques = [loop.mean_torque() for loop in rate_loops(body, equations.dt)]
    return tuple(
        quarter + sum(torque / (4 * lever) for torque, lever in zip(torques, levers(body, rotor), strict=True))
        for rotor in range(4)
    )


def alone(equations: Equations, name: str, rotor: int) -> Expr:
    """What one motor adds to a quantity that is a sum over the motors."""
    names = motors_of(equations.layouts.action)
    whole, motors = equations.quantities[name], [acting(equations, motor) for motor in names]
    others = {motor: Integer(0) for number, motor in enumerate(motors) if number != rotor}
    nothing = dict.fromkeys(motors, Integer(0))
    return whole.xreplace(others) - whole.xreplace(nothing)


def driven_by_motors(equations: Equations) -> bool:
    """Whether the actions are motors and thrust is their sum."""
    return "thrust" in equations.quantities and bool(motors_of(equations.layouts.action))


def motor_forces(equations: Equations) -> Sequence[Expr]:
    """Thrust of each motor in N."""
    return [alone(equations, "thrust", rotor) for rotor in range(len(motors_of(equations.layouts.action)))]


def spins(equations: Equations) -> tuple[int, ...]:
    """Sign of every motor's reaction torque about body z, by the equations' torque of half a command."""
    if "torque_z" not in equations.quantities:
        return SPIN
    names = motors_of(equations.layouts.action)
    half = {acting(equations, motor): Float(0.5) for motor in names}
    torques = [alone(equations, "torque_z", rotor).xreplace(half) for rotor in range(len(names))]
    return tuple(1 if torque.is_number and float(torque) > 0 else -1 for torque in torques)


def motor_sums(equations: Equations) -> list[str]:
    """Names of the quantities that are sums over motors."""
    return ["thrust", *(name for name in MOTOR_TORQUES if name in equations.quantities)]
