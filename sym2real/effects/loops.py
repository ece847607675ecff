"""The loops on board a robot, and what is wrong with them.

``rate_loop``. The on-board rate loop ω̇ = K (ω_cmd - ω) + τ/J over one held step, from the robot's J and K.

``rate_loop_gain``. The on-board rate loop is stiffer or softer than nominal: ω̇ = k K (ω_cmd - ω) + τ/J, about yaw by a
further factor.

The torque that is put in makes the rate at the end of a step that of the changed loop, exactly.

``attitude_loop``. The on-board attitude loop is slower or faster than nominal: q goes to q_cmd in k τ, not in τ.

Over a step of dt the attitude goes the part p = 1 - e^(-dt/τ) of the way to the command. To go the part p(kτ) instead,
the nominal loop is given the command that lies p(kτ)/p(τ) of the way off.

``speed_loop``. The same of a car's speed along its heading: u goes to u_cmd in k τ, not in τ.

``rate_damping``. Air that brakes rotation: τ = -d∘ω.

On a closed rate loop it is a loop of gain K + d/J whose command is K/(K + d/J) of the command. Where motors turn the
body, the torque over a step is that of the mean rate (trapezoidal rule), with the rate that the other torques leave::

    τ_d = -d (ω + dt τ/(2J)) / (1 + d dt/(2J))
"""

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from sympy import Expr, Integer, exp, sign

from sym2real.effects import truth
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.kind import POSITIVE, Kind, Numbers, Parameter, Values, of_any_body, several
from sym2real.effects.manoeuvres import EXCITED
from sym2real.effects.searching import Searching
from sym2real.effects.terms import acting_torque
from sym2real.effects.wrench import AXES, FORWARD, apply_wrench, forward_speed, uses
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import ATTITUDE, ATTITUDE_COMMAND, RATE, RATE_COMMAND, SPEED_COLUMN

NUMBERS = ("jx", "jy", "jz", "kx", "ky", "kz")


@dataclass(frozen=True)
class RateLoop:
    """One axis of the loop.

    Args:
        axis: "x", "y" or "z".
        inertia: J in kg m².
        gain: K in 1/s.
        dt: step in s.
    """

    axis: str
    inertia: float
    gain: float
    dt: float

    @property
    def rate(self) -> Expr:
        """The axis's body rate, rad/s."""
        return symbol(f"w{self.axis}")

    @property
    def command(self) -> Expr:
        """The commanded body rate, rad/s."""
        return symbol(f"w{self.axis}_cmd")

    @property
    def kept(self) -> float:
        """Share of a rate's distance from its command that is left after a step."""
        return math.exp(-self.gain * self.dt)

    @property
    def response(self) -> float:
        """Rate after a step per angular acceleration that acts throughout it, s."""
        return (1.0 - self.kept) / self.gain

    def mean_torque(self) -> Expr:
        """Mean torque of the loop over the step, N m."""
        share = (1.0 - self.kept) / (self.gain * self.dt)
        return self.inertia * self.gain * share * (self.command - self.rate)

    def torque_that_ends_at(self, rate: Expr) -> Expr:
        """Held torque with which the loop's rate is ``rate`` after the step, N m."""
        return self.inertia / self.response * (rate - self.command - self.kept * (self.rate - self.command))

    def with_gain(self, factor: Expr, reach: Expr | float, torque: Expr) -> Expr:
        """Torque to add so that the loop's gain is ``factor`` times K and its command ``reach`` times the command.

        Args:
            factor: on the gain.
            reach: on the command.
            torque: N m, that acts besides.
        """
        kept = exp(-self.gain * self.dt * factor)
        aim = reach * self.command
        end = aim + (self.rate - aim) * kept + torque / self.inertia * (1 - kept) / (self.gain * factor)
        return self.torque_that_ends_at(end) - torque


def rate_loops(body: Body, dt: float) -> tuple[RateLoop, RateLoop, RateLoop]:
    """The three axes of a body's rate loop.

    Raises:
        ModelError: when the body's numbers lack inertia or gains.
    """
    x, y, z = (RateLoop(axis, body.number(f"j{axis}"), body.number(f"k{axis}"), dt) for axis in AXES)
    return x, y, z


def other_torque(equations: Equations, axis: str) -> Expr:
    """What else turns the body: the wrench input's symbol, or zero where the equations do not use it."""
    return symbol(f"t{axis}") if uses(equations, f"t{axis}") else Integer(0)


LOOPS = RATE.columns


def _rate_loop_gain_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    loops = rate_loops(body, equations.dt)
    factors = (values["value"], values["value"], values["value"] * values["yaw"])
    torque = [
        loop.with_gain(factor, 1.0, other_torque(equations, loop.axis))
        for loop, factor in zip(loops, factors, strict=True)
    ]
    return apply_wrench(equations, body, torque=torque)


def _multiply_stiffness(actuator: Any, by: float) -> None:
    actuator.gainprm = [by * number for number in actuator.gainprm]
    actuator.biasprm = [by * number for number in actuator.biasprm]


def _stiffen(spec: Any, body: Body, values: Numbers) -> None:
    for actuator in spec.actuators:
        if actuator.name in LOOPS:
            yaw = values["yaw"] if actuator.name == LOOPS[-1] else 1.0
            _multiply_stiffness(actuator, values["value"] * yaw)


_STIFFER = partial(Parameter, unit="1", null=1.0, low=0.1, high=10.0, scale=0.2, domain=POSITIVE)

RATE_LOOP_GAIN = Kind(
    name="rate_loop_gain",
    stage="loop",
    parameters=of_any_body(_STIFFER("value"), _STIFFER("yaw")),
    formula=r"\tau = k\,\mathrm{diag}(1, 1, k_\mathrm{yaw})\,J K\,(\omega_\mathrm{cmd} - \omega)",
    summary="The on-board rate loop is stiffer or softer than the nominal one.",
    confused_with="an inertia that is off, always; motor lag or delay in hover",
    shown_by=EXCITED,
    fix="set the rate loop's gain in the firmware, or in the model (`nominal quadrotor --rate-gains`)",
    inject=truth.editing(_stiffen),
    substitute=_rate_loop_gain_substitute,
    needs=(*RATE_COMMAND.columns, *RATE.columns),
    numbers=NUMBERS,
    robot="quadrotor",
    nuisance=(0.8, 1.25),
)


ATTITUDE_TIME, SPEED_TIME = "attitude_time", "speed_time"  # the numbers τ of robots that are commanded one, s
SLOWER = Parameter("value", "1", null=1.0, low=0.1, high=10.0, scale=0.3, domain=POSITIVE)


def _further(values: Values, body: Body, name: str) -> Expr:
    """How many times as far a loop goes in a step whose time constant is so many times the robot's number."""
    nominal, changed = (1 - exp(-body.dt / time) for time in (body.number(name), values["value"] * body.number(name)))
    return changed / nominal


def _attitude_loop_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    further, start = _further(values, body, ATTITUDE_TIME), [symbol(column) for column in ATTITUDE.columns]
    commanded = [symbol(column) for column in ATTITUDE_COMMAND.columns]
    same_side = sign(sum(a * b for a, b in zip(start, commanded, strict=True)))
    moved = [a + further * (same_side * b - a) for a, b in zip(start, commanded, strict=True)]
    return equations.substitute(dict(zip(ATTITUDE_COMMAND.columns, moved, strict=True)))


ATTITUDE_LOOP = Kind(
    name="attitude_loop",
    stage="loop",
    parameters=of_any_body(SLOWER),
    formula=r"\tau \to k\,\tau",
    summary="The on-board attitude loop is slower or faster than the nominal one.",
    confused_with="a lag of the attitude commands, where the loop is fast beside it",
    shown_by=EXCITED,
    fix="multiply the model's time constant by it (`nominal quadrotor --attitude-time-constant`)",
    inject=truth.of_attitude_commands("attitude_loop"),
    substitute=_attitude_loop_substitute,
    needs=(*ATTITUDE_COMMAND.columns, *ATTITUDE.columns),
    numbers=(ATTITUDE_TIME,),
    scales=ATTITUDE_TIME,
    robot="quadrotor",
)


def _speed_loop_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    start, commanded = forward_speed(body), symbol(SPEED_COLUMN)
    return equations.substitute({SPEED_COLUMN: start + _further(values, body, SPEED_TIME) * (commanded - start)})


def _slow(spec: Any, body: Body, values: Numbers) -> None:
    for actuator in truth.actuators(spec, replace(body, column=SPEED_COLUMN)):
        _multiply_stiffness(actuator, 1.0 / values["value"])


SPEED_LOOP = Kind(
    name="speed_loop",
    stage="loop",
    parameters=of_any_body(SLOWER),
    formula=r"\tau \to k\,\tau",
    summary="The speed loop is slower or faster than the nominal one.",
    confused_with="a lag of the speed command, where it is slower",
    shown_by="steps of the speed",
    fix="multiply the model's time constant by it (`nominal car --time-constant`)",
    inject=truth.editing(_slow),
    substitute=_speed_loop_substitute,
    needs=(SPEED_COLUMN, *FORWARD),
    numbers=(SPEED_TIME,),
    scales=SPEED_TIME,
    robot="car",
)


NAMES = ("dx", "dy", "dz")


def _parameters(body: Body) -> tuple[Parameter, ...]:
    # The weight at 0.3 mm brakes 1 rad/s; for a Crazyflie a tenth of what its rate loop does.
    scale = 3e-4 * GRAVITY * body.numbers.get("mass", 1.0)
    return several(NAMES, "N m s", null=0.0, low=0.0, high=500 * scale, scale=scale)


def _rate_damping_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    dampings = [values[name] for name in NAMES]
    if not all(name in body.numbers and f"w{name[1]}_cmd" in body.names for name in NUMBERS):
        return apply_wrench(
            equations, body, torque=[_held(equations, body, *pair) for pair in zip(AXES, dampings, strict=True)]
        )
    torque = []
    for loop, damping in zip(rate_loops(body, equations.dt), dampings, strict=True):
        factor = 1 + damping / (loop.inertia * loop.gain)
        torque.append(loop.with_gain(factor, 1 / factor, other_torque(equations, loop.axis)))
    return apply_wrench(equations, body, torque=torque)


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
    inject=truth.with_force(_brake),
    of_joints="joint_damping",
    substitute=_rate_damping_substitute,
    needs=RATE.columns,
    robot="quadrotor",
    counts_as=("rate_loop_gain", "gain:w?_cmd"),
    searching=Searching(why_not=_why_not),
)
