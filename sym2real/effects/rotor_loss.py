"""One rotor gives less: (1 - ℓ) of its thrust, and the torques that follow."""

from typing import Any

import numpy as np
from sympy import Expr

from sym2real.effects import simulated_rotors, truth
from sym2real.effects.body import Body
from sym2real.effects.domain import Domain
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.rotors import alone, driven_by_motors, levers, motor_sums, shares
from sym2real.effects.searching import Searching
from sym2real.effects.thrust import acting_thrust, defined
from sym2real.effects.wrench import push
from sym2real.errors import ModelError
from sym2real.protocols import Change
from sym2real.symbolic import Equations


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return (
        Parameter("rotor", "1", null=1.0, low=1.0, high=float(body.rotors), scale=1.0, fitted=False),
        Parameter("value", "1", null=0.0, low=0.0, high=1.0, scale=0.1, domain=Domain(high=1.0)),
    )


def _choices(body: Body) -> tuple[float, ...]:
    return tuple(float(number) for number in range(1, body.rotors + 1))


def _number(value: Expr | float, body: Body) -> int:
    """Rotor, from 0.

    Raises:
        ModelError: for anything but the number of a rotor, from 1.
    """
    rotor = float(value) if getattr(value, "is_number", True) else 0.0
    if rotor not in _choices(body):
        *first, last = (f"{choice:g}" for choice in _choices(body))
        raise ModelError(f"rotor_loss: rotor must be {', '.join(first)} or {last}, found {value}")
    return int(rotor) - 1


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    rotor, loss = _number(values["rotor"], body), values["value"]
    if driven_by_motors(equations):
        sums = {
            name: equations.quantities[name] - loss * alone(equations, name, rotor) for name in motor_sums(equations)
        }
        return defined(equations, sums)
    lost, thrust = loss * shares(equations, body)[rotor], acting_thrust(equations)
    # Thrust first: what the torque is made of is the thrust that was meant.
    equations = equations.substitute({thrust.name: thrust - lost})
    return push(equations, body, torque=[-lever * lost for lever in levers(body, rotor)])


def _inject(body: Body, values: Numbers) -> Change:
    """A push at the rotor against what it gives, from what all actuators give now."""
    rotor = _number(values["rotor"], body)

    def lose(model: Any, data: Any) -> None:
        place, reaction = (found(model, body)[rotor] for found in (simulated_rotors.places, simulated_rotors.reactions))
        lost = values["value"] * simulated_rotors.pushes(model, data, body)[rotor]
        truth.add_thrust(data, -lost, place)
        truth.add_torque(data, np.array([0.0, 0.0, -lost * reaction]))

    return Change("", force=lose)


ROTOR_LOSS = Kind(
    name="rotor_loss",
    stage="wrench",
    parameters=_parameters,
    formula=r"T_i \to (1 - \ell)\,T_i",
    summary="One rotor gives less thrust than the others: a chipped propeller, a tired motor.",
    confused_with="a thrust gain with a centre of mass that is off along a diagonal",
    shown_by="yaw, which a centre of mass leaves alone, with thrust that varies",
    fix="change that propeller, or that motor",
    inject=_inject,
    substitute=_substitute,
    needs=("thrust", "wx", "wy", "wz"),
    numbers=("arm", "torque_per_thrust"),
    robot="quadrotor",
    searching=Searching(choices=lambda body: ("rotor", _choices(body))),
)
