"""One rotor gives less: (1 - ℓ) of its thrust, and the torques that follow."""

from __future__ import annotations

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
        Parameter("rotor", "1", null=1.0, low=1.0, high=4.0, scale=1.0, fitted=False),
        Parameter("value", "1", null=0.0, low=0.0, high=1.0, scale=0.1, domain=Domain(high=1.0)),
    )


def _number(value: Expr | float) -> int:
    """Rotor 0 to 3.

    Raises:
        ModelError: for anything but 1, 2, 3 or 4.
    """
    rotor = float(value) if getattr(value, "is_number", True) else 0.0
    if rotor not in (1.0, 2.0, 3.0, 4.0):
        raise ModelError(f"rotor_loss: rotor must be 1, 2, 3 or 4, found {value}")
    return int(rotor) - 1


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    rotor, loss = _number(values["rotor"]), values["value"]
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
    rotor = _number(values["rotor"])
    place, reaction = simulated_rotors.places(body)[rotor], simulated_rotors.reactions(body)[rotor]

    def lose(model: Any, data: Any) -> None:
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
    searching=Searching(choices=("rotor", (1.0, 2.0, 3.0, 4.0))),
)
