"""Rotors of a rotorcraft: their forces and torques.

By default four, with positions, directions and numbers as in the Crazyflie firmware's
``power_distribution_quadrotor.c``, seen from above with x forward and y left::

    motor4 (front left)    x    motor1 (front right)
                           ↑
    motor3 (back left)  y ←     motor2 (back right)
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from sympy import Add, Expr, Float

from sym2real.errors import ModelError
from sym2real.vocabulary import MOTOR_COLUMNS, THRUST_COLUMN, TORQUE_COMMAND

MotorUnit = Literal["command", "rad/s"]


@dataclass(frozen=True)
class Motors:
    """Rotors in one plane, all with thrust along body z.

    Args:
        unit: "command" for numbers 0–1, "rad/s" for speeds.
        thrust: N per unit of command, or N s² per rad² (k_f in k_f ω²), of one rotor.
        torque_per_thrust: reaction torque per thrust in m (k_m / k_f).
        arm: centre to rotor in m, one for all or one each.
        spin: sign of the reaction torque about body z, motor1 first; a rotor that turns counter-clockwise seen from
            above has -1.
        angles: direction of every rotor from the centre, in degrees from x towards y.

    Raises:
        ModelError: for numbers that no rotors have.
    """

    thrust: float
    unit: MotorUnit = "command"
    torque_per_thrust: float = 0.00596  # m: Crazyflie firmware, thrustToTorque
    arm: float | tuple[float, ...] = 0.046  # m: Crazyflie 2.1
    spin: tuple[int, ...] = (-1, 1, -1, 1)
    angles: tuple[float, ...] = (-45.0, -135.0, 135.0, 45.0)

    def __post_init__(self) -> None:
        if min(self.thrust, self.torque_per_thrust) < 0 or not min(self.arms) > 0:
            raise ModelError(
                f"thrust and torque of rotors must not be negative and their arm in m positive, found {self}"
            )
        if {abs(sign) for sign in self.spin} != {1}:
            raise ModelError(f"the spin of a rotor must be 1 or -1, found {self.spin}")
        if not 0 < len(self.spin) == len(self.angles) == len(self.arms) <= len(MOTOR_COLUMNS):
            raise ModelError(
                f"expected a spin and an angle of each of at most {len(MOTOR_COLUMNS)} rotors, "
                f"found {len(self.spin)} and {len(self.angles)}"
            )

    @property
    def columns(self) -> tuple[str, ...]:
        """Their columns, motor1 first."""
        return MOTOR_COLUMNS[: len(self.spin)]

    @property
    def arms(self) -> tuple[float, ...]:
        """Centre to every rotor in m."""
        return self.arm if isinstance(self.arm, tuple) else (self.arm,) * len(self.spin)

    @property
    def numbers(self) -> dict[str, float]:
        """By the names of a body's."""
        geometry = {"arm": sum(self.arms) / len(self.arms), "torque_per_thrust": self.torque_per_thrust}
        return geometry | ({"rotor_thrust": self.thrust} if self.unit == "rad/s" else {})

    def wrench(self, motors: Sequence[Expr]) -> tuple[Expr, tuple[Expr, ...]]:
        """Thrust in N along body z, and torque about the body axes in N m."""
        forces = self.forces(motors)
        return sum(forces), self.torques(forces)

    def forces(self, motors: Sequence[Expr]) -> list[Expr]:
        """Thrust of each rotor in N."""
        power = 2 if self.unit == "rad/s" else 1
        return [self.thrust * motor**power for motor in motors]

    def torques(self, forces: Sequence[Expr]) -> tuple[Expr, ...]:
        """Torque about the body axes in N m from the rotors' thrusts in N."""
        places = [*zip(self.arms, self.angles, forces, strict=True)]
        return (
            sum(arm * _sine(angle) * force for arm, angle, force in places),
            -sum(arm * _sine(angle + 90.0) * force for arm, angle, force in places),
            self.torque_per_thrust * sum(sign * force for sign, force in zip(self.spin, forces, strict=True)),
        )

    def hover(self, weight: float) -> float:
        """What each motor must do to carry a weight in N, in the motors' unit."""
        share = weight / len(self.spin)
        if self.unit == "rad/s":
            return math.sqrt(share / self.thrust)
        return share / self.thrust


def _sine(degrees: float) -> float:
    """Sine of an angle, equal in size for equal places, and zero where it is."""
    return round(math.sin(math.radians(degrees)), 15)


@dataclass(frozen=True)
class Wrenches:
    """Actuators that each give a thrust and a torque by themselves, as simulators have them; by default in N and N m.

    Args:
        columns: their commands.
        thrusts: along body z for a command of 1, N.
        moments: about the body axes, of the same, N m.

    Raises:
        ModelError: where a command called "thrust" is none in N.
    """

    columns: tuple[str, ...] = (THRUST_COLUMN, *TORQUE_COMMAND.columns)
    thrusts: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
    moments: tuple[tuple[float, float, float], ...] = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))

    def __post_init__(self) -> None:
        units = tuple(float(name == THRUST_COLUMN) for name in self.columns)
        if THRUST_COLUMN in self.columns and self.thrusts != units:
            actual = ", ".join(f"{name} {value:g}" for name, value in zip(self.columns, self.thrusts, strict=True))
            raise ModelError(f"expected a command called {THRUST_COLUMN} that is all of it in N, found N per {actual}")

    @property
    def numbers(self) -> dict[str, float]:
        """They need none."""
        return {}

    def wrench(self, commands: Sequence[Expr]) -> tuple[Expr, tuple[Expr, ...]]:
        """Thrust in N along body z, and torque about the body axes in N m."""

        def along(factors: Sequence[float]) -> Expr:
            pairs = zip(factors, commands, strict=True)
            return Add(*(own if factor == 1.0 else Float(factor) * own for factor, own in pairs if factor))

        return along(self.thrusts), tuple(map(along, zip(*self.moments, strict=True)))
