"""Air that brakes rotation: τ = -d∘ω.

On a closed rate loop it is a loop of gain K + d/J whose command is K/(K + d/J) of the command. Where motors turn the
body, the torque over a step is that of the mean rate (trapezoidal rule), with the rate that the other torques leave::

    τ_d = -d (ω + dt τ/(2J)) / (1 + d dt/(2J))
"""

from typing import Any

import numpy as np
from sympy import Expr

from sym2real.effects import truth
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.rate_loop import NUMBERS, other_torque, rate_loops
from sym2real.effects.searching import Searching
from sym2real.effects.thrust import acting_torque
from sym2real.effects.wrench import AXES, push
from sym2real.symbolic import Equations, symbol

NAMES = ("dx", "dy", "dz")


def _parameters(body: Body) -> tuple[Parameter, ...]:
    # The weight at 0.3 mm brakes 1 rad/s; for a Crazyflie a tenth of what its rate loop does.
    scale = 3e-4 * GRAVITY * body.numbers.get("mass", 1.0)
    return tuple(Parameter(name, "N m s", null=0.0, low=0.0, high=500 * scale, scale=scale) for name in NAMES)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    dampings = [values[name] for name in NAMES]
    if not all(name in body.numbers and f"w{name[1]}_cmd" in body.names for name in NUMBERS):
        return push(
            equations, body, torque=[_held(equations, body, *pair) for pair in zip(AXES, dampings, strict=True)]
        )
    torque = []
    for loop, damping in zip(rate_loops(body, equations.dt), dampings, strict=True):
        factor = 1 + damping / (loop.inertia * loop.gain)
        torque.append(loop.with_gain(factor, 1 / factor, other_torque(equations, loop.axis)))
    return push(equations, body, torque=torque)


def _held(equations: Equations, body: Body, axis: str, damping: Expr) -> Expr:
    """Mean torque about an axis over a step, N m."""
    rate = symbol(f"w{axis}")
    if f"j{axis}" not in body.numbers:
        return -damping * rate
    half = equations.dt / (2 * body.number(f"j{axis}"))
    others = other_torque(equations, axis) + acting_torque(equations, axis)
    return -damping * (rate + half * others) / (1 + half * damping)


def _why_not(body: Body) -> str:
    """A search has no place for it beside what it is on a closed rate loop."""
    looped = any(field.name == "rate command" for field in body.layouts.action.fields)
    return "rate_loop_gain and the gains of the rate commands stand for it together" if looped else ""


def _brake(data: Any, body: Body, values: Numbers) -> None:
    truth.add_torque(data, -np.array([values[name] for name in NAMES]) * truth.rates(data))


RATE_DAMPING = Kind(
    name="rate_damping",
    stage="loop",
    parameters=_parameters,
    formula=r"\tau = -d \circ \omega",
    summary="Air brakes the body's rotation.",
    confused_with="a rate loop gain together with gains of the rate commands: on a closed rate loop it is these two",
    shown_by="rates that are held: flips, fast yaw",
    fix="put the damping into the model, or an integral part into the rate loop",
    inject=truth.pushing(_brake),
    of_joints="joint_damping",
    substitute=_substitute,
    needs=("wx", "wy", "wz"),
    robot="quadrotor",
    counts_as=("rate_loop_gain", "gain:w?_cmd"),
    searching=Searching(why_not=_why_not),
)
