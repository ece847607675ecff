r"""What turns a rotorcraft beside its loops: torques that are constant, scaled, or late.

``torque_bias``. A constant torque about body axes.

``torque_scale``. Motors that turn the body by more or less than the model says: τ = (k_x τ_x, k_y τ_y, k_z τ_z).

What turns the body is torque over inertia, so that k_i is at once the factor on the lever (arm, reaction torque per
thrust) and the inverse of that on the inertia: no flight parts the two. Of published numbers of small robots the lever
about yaw is the least sure one, by an order of magnitude.

``motor_lag``. Rotors that follow their commands as a first-order filter, inside the rate loop.

Thrust: τ dT'/dt = T - T'. Each axis of the rate loop, with α its angular acceleration::

    ω̇ = α        τ α̇ = K (ω_cmd - ω) + τ_ext/J - α

Memory: hidden states for the thrust, which starts at its first command, and for α, which starts at zero. Both
are exact over a held step; x = ω - ω_cmd - τ_ext/(J K) obeys, with r = √(1 - 4Kτ) and D = (e₁ - e₂)/r::

    x' = x (C + D/2) + α τ D        α' = α (C - D/2) - x K D        C = (e₁ + e₂)/2

where e₁, e₂ = exp(-(1 ∓ r) dt/(2τ)); for a complex r the same in sine and cosine. At τ = 0 this is the plain loop.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from sympy import Abs, Expr, Integer, Max, Piecewise, cos, exp, sin, sqrt

from sym2real.effects import truth
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.kind import NOT_NEGATIVE, POSITIVE, Kind, Numbers, Parameter, Values, of_any_body, several
from sym2real.effects.loops import NUMBERS, RateLoop, other_torque, rate_loops
from sym2real.effects.manoeuvres import EXCITED
from sym2real.effects.searching import Searching, Shown, steps
from sym2real.effects.simulated_rotors import require_rotors, stands
from sym2real.effects.terms import LAGGED, defined, lagging, with_hidden
from sym2real.effects.wrench import AXES, apply_wrench
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import MOTOR_COLUMNS, MOTOR_TORQUES, RATE, RATE_COMMAND

BIASES = ("tx", "ty", "tz")


def _parameters(body: Body) -> tuple[Parameter, ...]:
    # Sized as the weight at a tenth of a millimetre.
    scale = 1e-4 * GRAVITY * body.numbers.get("mass", 1.0)
    return several(BIASES, "N m", null=0.0, low=-100 * scale, high=100 * scale, scale=scale)


TORQUE_BIAS = Kind(
    name="torque_bias",
    stage="wrench",
    parameters=_parameters,
    formula=r"\tau = \mathrm{const}",
    summary="A constant torque turns the body.",
    confused_with="an offset of the rate commands, always; a centre of mass that is off where thrust hardly varies",
    shown_by="thrust that varies, against a centre of mass",
    fix="replace the weak motor or the bent propeller, or trim the mixer",
    inject=truth.with_force(
        lambda data, body, values: truth.add_torque(data, np.array([values[name] for name in BIASES]))
    ),
    substitute=lambda equations, values, body: apply_wrench(equations, body, torque=[values[name] for name in BIASES]),
    needs=RATE.columns,
    robot="quadrotor",
    by_torque=lambda _: True,
)


FACTORS = ("kx", "ky", "kz")


def _lengthen(spec: Any, body: Body, values: Numbers) -> None:
    """Gears: what rotors that stand nearer or further, and react less or more, turn the body by."""
    require_rotors(spec)
    plain = spec.copy().compile()
    for number, actuator in enumerate(spec.actuators):
        if actuator.name in MOTOR_COLUMNS:
            (x, y, _), axes = stands(plain, number)
            lift, reaction = actuator.gear[2], values["kz"] * actuator.gear[5]
            lever = axes.T @ [(values["kx"] - 1.0) * y * lift, (1.0 - values["ky"]) * x * lift, 0.0]
            actuator.gear = [*actuator.gear[:3], *(actuator.gear[3:5] + lever[:2]), reaction]


TORQUE_SCALE = Kind(
    name="torque_scale",
    stage="thrust",
    parameters=of_any_body(*several(FACTORS, "1", null=1.0, low=1e-3, high=1e3, scale=0.3, domain=POSITIVE)),
    formula=r"\tau_i \to k_i\,\tau_i",
    summary="The motors turn the body by more or less than the model says: a lever or an inertia is another one.",
    confused_with="gains of all motors, which change the thrust as well; an inertia that is off is the same thing",
    shown_by="turns about all axes, to both sides: dither of the motors, each on its own",
    fix="set arm, reaction torque per thrust or inertia by this factor; a bifilar pendulum measures the inertia",
    inject=truth.editing(_lengthen),
    substitute=lambda equations, values, body: equations.substitute(
        {torque: values[name] * symbol(torque) for name, torque in zip(FACTORS, MOTOR_TORQUES, strict=True)}
    ),
    needs=("thrust", *MOTOR_TORQUES, *RATE.columns),
    robot="quadrotor",
    searching=Searching(attenuated=True),
)


LOOP = (*NUMBERS, *RATE_COMMAND.columns, *RATE.columns)
FEEDBACK, FIRST_FEEDBACK = RATE.columns, 4
NEAR_CRITICAL = 1e-6  # of |1 - 4Kτ|, where both branches divide by its root


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    time, torques = values["value"], [name for name in MOTOR_TORQUES if name in equations.quantities]
    if torques or "thrust" in equations.quantities:
        for name in torques:
            equations = _lagging(equations, name, lagging(name), "N m", time)
    elif all(name in (*body.names, *body.numbers) for name in LOOP):
        for loop in rate_loops(body, equations.dt):
            equations = _lagging_loop(equations, body, loop, time)
    return _lagging(equations, "thrust", LAGGED, "N", time)


def _lagging(equations: Equations, name: str, mean_name: str, unit: str, time: Expr) -> Equations:
    """A symbol, wherever it is used, by the mean over the step of a filter that follows it."""
    wanted, memory = symbol(name), symbol(f"{mean_name}_memory")
    left = exp(-equations.dt / time)
    away = memory - wanted
    equations = defined(equations, {mean_name: Integer(0)}).substitute({name: symbol(mean_name)})
    equations = with_hidden(equations, memory.name, unit, wanted + away * left, start=wanted)
    return defined(equations, {mean_name: wanted + away * (time / equations.dt * (1 - left))})


def _lagging_loop(equations: Equations, body: Body, loop: RateLoop, time: Expr) -> Equations:
    """One axis of the rate loop as an oscillator of second order, by the torque that ends at its rate."""
    memory = symbol(f"rotor_turn_{loop.axis}_memory")
    torque = other_torque(equations, loop.axis)
    away = loop.rate - loop.command - torque / (loop.inertia * loop.gain)
    middle, difference = symbol(f"lag_c_{loop.axis}"), symbol(f"lag_d_{loop.axis}")
    exponentials = _exponentials(loop, time)
    after = away * (middle + difference / 2) + memory * time * difference
    change = loop.torque_that_ends_at(loop.command + torque / (loop.inertia * loop.gain) + after) - torque
    turning = memory * (middle - difference / 2) - away * loop.gain * difference
    equations = defined(equations, dict(zip((middle.name, difference.name), exponentials, strict=True)))
    equations = with_hidden(equations, memory.name, "rad/s²", Integer(0), start=Integer(0))
    components = [change if axis == loop.axis else Integer(0) for axis in AXES]
    equations = apply_wrench(equations, body, torque=components)
    return replace(equations, next={**equations.next, memory.name: turning})


def _exponentials(loop: RateLoop, time: Expr) -> tuple[Expr, Expr]:
    """C and D of the module's formula."""
    discriminant = 1 - 4 * loop.gain * time
    root = sqrt(Max(Abs(discriminant), NEAR_CRITICAL))
    slow, fast = exp(-2 * loop.gain * loop.dt / (1 + root)), exp(-(1 + root) * loop.dt / (2 * time))
    decay, angle = exp(-loop.dt / (2 * time)), root * loop.dt / (2 * time)
    return (
        Piecewise(((slow + fast) / 2, discriminant > 0), (decay * cos(angle), True)),
        Piecewise(((slow - fast) / root, discriminant > 0), (2 * decay * sin(angle) / root, True)),
    )


def _inject(body: Body, values: Numbers) -> Change:
    """MuJoCo's actuator filters: on thrust, on the loop's command, and on its feedback as an actuator of its own."""
    time = values["value"]

    def edit(spec: Any) -> None:
        """Filters on every actuator; the feedback leaves its actuator's bias and becomes one that is filtered too."""
        for actuator in list(spec.actuators):
            truth.set_lag(spec, actuator, time)
            if actuator.name in FEEDBACK:
                feedback = spec.add_actuator(name=f"{actuator.name}_feedback", target=actuator.target)
                feedback.trntype, feedback.gear = actuator.trntype, actuator.gear
                feedback.gainprm = [actuator.biasprm[2], *([0.0] * 9)]
                truth.set_lag(spec, feedback, time)
                actuator.biasprm = [0.0] * 10
                actuator.biastype = type(actuator.biastype)(0)

    def feed(model: Any, data: Any) -> None:
        """Send the body rates (rad/s) to the feedback's actuators."""
        # A control is held for a physics step: the rate in its middle.
        middle = truth.rates(data) + 0.5 * model.opt.timestep * data.qacc[3:6]
        data.ctrl[FIRST_FEEDBACK : FIRST_FEEDBACK + 3] = middle
        if data.time == 0.0:
            # In rest the loop's torque is zero: command and feedback have been equal.
            first = data.act[1:4].copy()
            data.act[FIRST_FEEDBACK : FIRST_FEEDBACK + 3] = first

    return Change("", edit=edit, force=feed if "wx_cmd" in body.layouts.action else None)


MOTOR_LAG = Kind(
    name="motor_lag",
    stage="loop",
    parameters=of_any_body(Parameter("value", "s", null=0.0, low=0.0, high=0.3, scale=0.03, domain=NOT_NEGATIVE)),
    formula=r"\tau \dot T' = T - T', \quad \tau \dot\alpha = K(\omega_\mathrm{cmd} - \omega) - \alpha",
    summary="The rotors spin up and down slowly, inside the rate loop.",
    confused_with="a delay in hover, and a common lag of the rate commands without dither",
    shown_by=f"steps of thrust, {EXCITED}",
    fix="put the lag into the model; lighter propellers or a softer rate loop make it matter less",
    inject=_inject,
    substitute=_substitute,
    needs=("thrust",),
    hidden=(f"{LAGGED}_memory",),
    robot="quadrotor",
    lagging=True,
    searching=Searching(starts=steps(1.5, 3.0), shown_in=lambda _: (Shown.DITHER,)),
)
