"""Rotors that speed up turn the body the other way: τ_z = J_r Σ± dω_i/dt.

Rotor speeds are √(T_i/k_f). The derivative is that of the step means, with the last one as a hidden state that starts
at the first row's.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from sympy import Expr, Integer, Max, sqrt

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.effect import Kind, Numbers, Parameter, Values
from sym2real.effects.hidden import with_hidden
from sym2real.effects.rotors import SPIN, driven_by_motors, motor_forces, shares
from sym2real.effects.thrust import defined
from sym2real.effects.wrench import push
from sym2real.protocols import Array, Change, Filter
from sym2real.symbolic import Equations, symbol

SUM, MEMORY = "rotor_speed_sum", "rotor_speed_memory"


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return (Parameter("value", "kg m²", null=0.0, low=0.0, high=1e-5, scale=3e-8),)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    forces = motor_forces(equations) if driven_by_motors(equations) else shares(equations, body)
    speeds: list[Expr] = [sqrt(Max(force, 0) / body.number("rotor_thrust")) for force in forces]
    equations = defined(equations, {SUM: sum(sign * speed for sign, speed in zip(SPIN, speeds, strict=True))})
    equations = with_hidden(equations, MEMORY, "rad/s", symbol(SUM), start=symbol(SUM))
    torque = values["value"] * (symbol(SUM) - symbol(MEMORY)) / equations.dt
    return push(equations, body, torque=(Integer(0), Integer(0), torque))


def _inject(body: Body, values: Numbers) -> Change:
    """From what the actuators give at every physics step; ``command`` only tells that an episode begins."""
    reaction, arm = body.number("torque_per_thrust"), body.number("arm") / np.sqrt(2.0)
    signs = np.array([[1, 1, 1, 1], [-1, -1, 1, 1], [-1, 1, 1, -1], [-1, 1, -1, 1]])
    mixer = signs * np.array([[1.0], [arm], [arm], [reaction]])
    last: list[float] = []

    def begin() -> Filter:
        last.clear()
        return lambda action: action

    def turn(model: Any, data: Any) -> None:
        pushes: Array = np.linalg.solve(mixer, np.array(data.actuator_force[:4]))
        total = float(signs[3] @ np.sqrt(np.maximum(pushes, 0.0) / body.number("rotor_thrust")))
        change = (total - (last[0] if last else total)) / model.opt.timestep
        last[:] = [total]
        truth.add_torque(data, np.array([0.0, 0.0, values["value"] * change]))

    return Change("", force=turn, command=begin)


ROTOR_REACTION = Kind(
    name="rotor_reaction",
    stage="wrench",
    parameters=_parameters,
    formula=r"\tau_z = J_r \sum \pm \dot\omega_i",
    summary="Rotors that speed up or slow down turn the body about yaw.",
    confused_with="a stiffer yaw rate loop",
    shown_by="fast changes of the yaw rate command",
    fix="put the rotors' inertia into the model; a softer yaw loop makes it matter less",
    inject=_inject,
    substitute=_substitute,
    needs=("thrust", "wz"),
    numbers=("rotor_thrust",),
    robot="quadrotor",
)
