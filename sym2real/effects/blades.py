r"""Rotors in moving air, and rotors that change their speed.

``flapping_moment``. Blades that flap in moving air turn the body: τ = (a·v, b·u, 0), u and v the velocity along body x
and y.

``translational_lift``. Rotors that lift more in moving air: T (1 + k (u² + v²)), u and v the velocity along body x and
y.

``rotor_reaction``. Rotors hold angular momentum: to speed up they turn the body the other way, and where it turns they
turn with it, like any gyroscope. With Ω = Σ± ω_i, the sign that of a rotor's reaction torque::

    τ = J_r (ω_y Ω, -ω_x Ω, dΩ/dt)

Rotor speeds are √(T_i/k_f). Of motors, their sum with signs changes at once when a command changes; its last value is
a hidden state. A rate loop moves it by G per torque, G = 1/(2 κ √(k_f T/4)), κ the
reaction torque per thrust, so that::

    (1 + ρ) ω̇ = K (ω_cmd - ω) + ρ dω_cmd/dt + τ/J        ρ = J_r G K

which is solved exactly over a held step; the last yaw rate command is a hidden state.
"""

from typing import Any

import numpy as np
from sympy import Expr, Max, exp, sqrt

from sym2real.effects import simulated_rotors, truth
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.frames import body_velocity
from sym2real.effects.kind import NOT_NEGATIVE, Kind, Numbers, Parameter, Values, of_any_body, several
from sym2real.effects.loops import other_torque, rate_loops
from sym2real.effects.rotors import driven_by_motors, motor_forces, spins
from sym2real.effects.searching import ALONE, Searching, Shown
from sym2real.effects.terms import acting_thrust, defined, hover_thrust, scaled, with_hidden
from sym2real.effects.wrench import apply_wrench
from sym2real.layout import motors_of
from sym2real.protocols import Change, Filter
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import ATTITUDE, RATE, VELOCITY


def _flapping_moment_parameters(body: Body) -> tuple[Parameter, ...]:
    # At 1 m/s the torque is that of the weight at a tenth of a millimetre.
    scale = 1e-4 * GRAVITY * body.numbers.get("mass", 1.0)
    return several(("a", "b"), "N s", null=0.0, low=-500 * scale, high=500 * scale, scale=scale)


def _flapping_moment_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    ahead, left, _ = body_velocity(body)
    return apply_wrench(equations, body, torque=(values["a"] * left, values["b"] * ahead))


def _turn(data: Any, body: Body, values: Numbers) -> None:
    along = truth.rotation(data).T @ truth.velocity(data)
    truth.add_torque(data, np.array([values["a"] * along[1], values["b"] * along[0], 0.0]))


FLAPPING_MOMENT = Kind(
    name="flapping_moment",
    stage="wrench",
    parameters=_flapping_moment_parameters,
    formula=r"\tau = (a\,v,\; b\,u,\; 0)",
    summary="Air that flows across the rotors tilts their discs and turns the body.",
    confused_with="a torque bias at one velocity, and drag",
    shown_by="several speeds in all directions of the body",
    fix="put the term into the model",
    inject=truth.with_force(_turn),
    substitute=_flapping_moment_substitute,
    needs=("wx", "wy", *VELOCITY.columns, *ATTITUDE.columns),
    robot="quadrotor",
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
    by_torque=lambda _: True,
)


def _translational_lift_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    ahead, left, _ = body_velocity(body)
    return scaled(equations, 1 + values["value"] * (ahead**2 + left**2))


def _lift(data: Any, body: Body, values: Numbers) -> None:
    along = truth.rotation(data).T @ truth.velocity(data)
    truth.scale_thrust(data, 1.0 + values["value"] * float(along[:2] @ along[:2]))


TRANSLATIONAL_LIFT = Kind(
    name="translational_lift",
    stage="thrust",
    parameters=of_any_body(Parameter("value", "s²/m²", null=0.0, low=-0.2, high=0.5, scale=0.02)),
    formula=r"T \to T\,(1 + k\,(u^2 + v^2))",
    summary="Rotors lift more when air flows across them.",
    confused_with="a thrust gain at one speed",
    shown_by="level flight at several speeds beside hover",
    fix="put the term into the model",
    inject=truth.with_force(_lift),
    substitute=_translational_lift_substitute,
    needs=("thrust", *VELOCITY.columns, *ATTITUDE.columns),
    robot="quadrotor",
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)


SUM, SUM_MEMORY, COMMAND_MEMORY = "rotor_speed_sum", "rotor_speed_memory", "yaw_command_memory"
LOWEST = 0.1  # of the hover thrust: rotors that hardly turn would react without bound


def _rotor_reaction_parameters(body: Body) -> tuple[Parameter, ...]:
    """Rotors have a thousandth of the body's inertia about yaw; as much as all of it where that is given too large."""
    whole = body.number("jz")
    return (Parameter("value", "kg m²", null=0.0, low=0.0, high=whole, scale=1e-4 * whole, domain=NOT_NEGATIVE),)


def _rotor_reaction_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    if driven_by_motors(equations):
        return _of_motors(equations, values["value"], body)
    return _of_loop(equations, values["value"], body)


def _of_motors(equations: Equations, inertia: Expr, body: Body) -> Equations:
    speeds = [sqrt(Max(force, 0) / body.number("rotor_thrust")) for force in motor_forces(equations)]
    total = sum(sign * speed for sign, speed in zip(spins(equations), speeds, strict=True))
    equations = defined(equations, {SUM: total})
    equations = with_hidden(equations, SUM_MEMORY, "rad/s", symbol(SUM), start=symbol(SUM))
    about_z = inertia * ((symbol(SUM) - symbol(SUM_MEMORY)) / equations.dt)
    return apply_wrench(equations, body, torque=(*_gyroscopic(equations, inertia * symbol(SUM), body), about_z))


def _gyroscopic(equations: Equations, momentum: Expr, body: Body) -> tuple[Expr, Expr]:
    """Torques about x and y, N m, held over a step, that turn the rates about z as rotors' momentum does.

    By the implicit midpoint rule: the torque does no work, and explicit steps would add energy until rates overflow.
    """
    jx, jy = body.number("jx"), body.number("jy")
    ahead, left = symbol("wx"), symbol("wy")
    half = equations.dt * momentum / 2
    shrink = 1 + half**2 / (jx * jy)
    return momentum * (left - half * ahead / jy) / shrink, -momentum * (ahead + half * left / jx) / shrink


def _of_loop(equations: Equations, inertia: Expr, body: Body) -> Equations:
    loop, torque = rate_loops(body, equations.dt)[2], other_torque(equations, "z")
    thrust = Max(acting_thrust(equations), LOWEST * hover_thrust(body))
    speeds = 1 / (2 * body.number("torque_per_thrust") * sqrt(body.number("rotor_thrust") * thrust / 4))
    share = inertia * speeds * loop.gain
    equations = with_hidden(equations, COMMAND_MEMORY, "rad/s", loop.command, start=loop.command)
    jump = share / (1 + share) * (loop.command - symbol(COMMAND_MEMORY))
    kept = exp(-loop.gain * loop.dt / (1 + share))
    end = loop.command + (loop.rate + jump - loop.command) * kept
    end += torque / loop.inertia * (1 - kept) / loop.gain
    about_z = loop.torque_that_ends_at(end) - torque
    return apply_wrench(
        equations, body, torque=(*_gyroscopic(equations, inertia * speeds * loop.mean_torque(), body), about_z)
    )


def _inject(body: Body, values: Numbers) -> Change:
    """From what the actuators give at every physics step; ``command`` only tells that an episode begins."""
    last: list[float] = []

    def begin() -> Filter:
        last.clear()
        return lambda action: action

    def turn(model: Any, data: Any) -> None:
        """Put in what the rotors' spin takes of the body's, by its change and as a gyroscope."""
        thrusts = np.maximum(simulated_rotors.thrusts(model, data, body), 0.0)
        signs = np.sign(simulated_rotors.reactions(model, body))
        total = float(signs @ np.sqrt(thrusts / body.number("rotor_thrust")))
        change = (total - (last[0] if last else total)) / model.opt.timestep
        last[:] = [total]
        momentum = values["value"] * np.array([0.0, 0.0, -total])
        truth.add_torque(data, [0.0, 0.0, values["value"] * change] - np.cross(truth.rates(data), momentum))

    return Change("", force=turn, command=begin)


ROTOR_REACTION = Kind(
    name="rotor_reaction",
    stage="loop",
    parameters=_rotor_reaction_parameters,
    formula=r"\tau = J_r\,(q\,\Omega,\; -p\,\Omega,\; \dot\Omega), \quad \Omega = \sum \pm \omega_i",
    summary="Rotors resist a change of their speed, about yaw, and of their axis, as a gyroscope does.",
    confused_with="a stiffer yaw rate loop",
    shown_by="fast changes of the yaw rate, to both sides",
    fix="put the rotors' inertia into the model; a softer yaw loop makes it matter less",
    inject=_inject,
    substitute=_rotor_reaction_substitute,
    needs=("thrust", *RATE.columns),
    numbers=("rotor_thrust", "torque_per_thrust", "jx", "jy", "jz"),
    hidden=(SUM_MEMORY, COMMAND_MEMORY),
    robot="quadrotor",
    searching=Searching(why_not=lambda body: "" if motors_of(body.layouts.action) else ALONE),
)
