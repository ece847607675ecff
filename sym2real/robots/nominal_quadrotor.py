"""Rigid-body equations of any quadrotor from its numbers alone: no simulator, no regression.

Continuous time, forces in world axes, torques in body axes::

    ṗ = v        m v̇ = R(q) e₃ T + F - m g e₃        q̇ = ½ q ⊗ ω        J ω̇ = τ - ω × J ω

Discrete time: mean rates over the step and over its first half (exponential response of the rate loop), attitude
turned by the mean rate, thrust along the axis at mid-step, p += v dt + ½ a dt², v += a dt. Local error: third order.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from sympy import Expr, sign, sqrt

from sym2real import vocabulary
from sym2real.errors import ModelError
from sym2real.layout import Layout, Layouts
from sym2real.robots import crazyflie
from sym2real.robots.likely import unlikely_in_quadrotor
from sym2real.robots.motors import Motors, Wrenches
from sym2real.robots.rigid_body import FirstOrder, Vector, free_fall, gyroscopic, increment, symbols
from sym2real.robots.robot import GRAVITY
from sym2real.rotation import axes, product
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.mass_normalised import PER_KILOGRAM
from sym2real.vocabulary import MOTOR_TORQUES, MOTORS, THRUST_COLUMN

Interface = Literal["thrust_rates", "thrust_torques", "thrust_attitude", "motors"]
Attitude = Literal["predicted", "measured"]

POSITION, VELOCITY = vocabulary.POSITION.columns, vocabulary.VELOCITY.columns
QUATERNION, RATES = vocabulary.ATTITUDE.columns, vocabulary.RATE.columns
# Intermediate results: accelerations besides the rate loop's, at the step's start and over the step; mean rates with
# the former, over the step and over its first half; rotation over the step and its first half; attitude at mid-step.
START_DRIFT, DRIFT = ("start_drift_x", "start_drift_y", "start_drift_z"), ("drift_x", "drift_y", "drift_z")
ROUGH = ("rough_wx", "rough_wy", "rough_wz")
MEAN, FIRST_HALF = ("mean_wx", "mean_wy", "mean_wz"), ("half_wx", "half_wy", "half_wz")
TURN = ("turn_w", "turn_x", "turn_y", "turn_z")
HALF_TURN = ("half_turn_w", "half_turn_x", "half_turn_y", "half_turn_z")
MIDDLE = ("mid_qw", "mid_qx", "mid_qy", "mid_qz")
FORCE, TORQUE = vocabulary.FORCE.columns, vocabulary.TORQUE.columns
# No moment of a body exceeds the sum of the others. A flat one's is nearly that sum, and published ones, measured to
# some per cent each, are above it: a Crazyflie's 1.43, 1.43 and 2.89e-5 kg m².
FLAT = 1.05
ABOVE = "the largest moment of inertia is above the sum of the others, as measured ones of a flat robot may be"
COMMANDS: Mapping[str, tuple[str, ...]] = {
    "thrust_rates": ("thrust", *vocabulary.RATE_COMMAND.columns),
    "thrust_torques": ("thrust", *vocabulary.TORQUE_COMMAND.columns),
    "thrust_attitude": ("thrust", *vocabulary.ATTITUDE_COMMAND.columns),
    "motors": MOTORS,
}


@dataclass
class _Build:
    """Equations in the making: next states, and intermediate results by name so that equations stay short."""

    next: dict[str, Expr] = field(default_factory=dict)
    quantities: dict[str, Expr] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    numbers: dict[str, float] = field(default_factory=dict)

    def name(self, names: Sequence[str], expressions: Sequence[Expr]) -> Vector:
        """The expressions become quantities of these names, and their symbols stand for them."""
        self.quantities |= dict(zip(names, expressions, strict=True))
        return symbols(names)

    def follow(self, columns: Sequence[str], expressions: Sequence[Expr]) -> None:
        """The expressions become the next values of these columns."""
        self.next |= dict(zip(columns, expressions, strict=True))


def quadrotor(
    mass: float | None = None,
    inertia: Sequence[float] | None = None,
    *,
    interface: Interface = "thrust_rates",
    attitude: Attitude = "predicted",
    dt: float = 0.02,
    rate_gains: Sequence[float] | None = None,
    attitude_time_constant: float = 0.15,
    motors: Motors | Wrenches | None = None,
    robot: str = "",
) -> Equations:
    """First-principles equations of a quadrotor.

    Args:
        mass: in kg; 1 where a log's thrust is mass-normalised (m/s²); None is 1 too, and ``notes`` says so.
        inertia: principal moments in kg m²; None scales the Crazyflie's by mass.
        interface: actions are thrust in N and body rates in rad/s; thrust and torques about the body axes in N m;
            thrust and attitude; or motors, four or those of ``motors``.
        attitude: "predicted", or "measured": the quaternion is then an input, which is halfway to the next row along a
            log, and held where no row is known yet; the state is position and velocity, and only thrust along body z
            remains of the actions.
        dt: time step in s.
        rate_gains: gains of the on-board rate loop in 1/s (interface "thrust_rates"); None for the Crazyflie's.
        attitude_time_constant: of the on-board attitude loop in s (interface "thrust_attitude"); 0 answers at once.
        motors: the rotors, or what else acts on the body (interface "motors"); None for rotors in scaled Crazyflie
            geometry that hover at half command.
        robot: name of the robot they describe.

    Raises:
        ModelError: for numbers that no quadrotor has.

    Examples:
        >>> quadrotor(0.027).numbers["mass"]
        0.027
    """
    notes, mass = ([PER_KILOGRAM], 1.0) if mass is None else ([], mass)
    _check(mass, inertia, interface, attitude, dt)
    gains = crazyflie.RATE_GAINS if rate_gains is None else rate_gains
    if not (0 <= attitude_time_constant < math.inf and all(0 < gain < math.inf for gain in gains)):
        raise ModelError(f"loops need τ ≥ 0 s and gains > 0 1/s, found {attitude_time_constant} and {gains}")
    build = _Build(notes=notes, numbers={"mass": mass})
    actuators = motors if interface == "motors" else Wrenches() if interface == "thrust_torques" else None
    if interface == "motors" and actuators is None:
        actuators = _scaled_motors(mass)
        build.notes.append("motors in scaled Crazyflie geometry that hover at command 0.5: fit the thrust per unit")
    torque = symbols(TORQUE) if actuators is None else _actuated(build, actuators, attitude)
    middle = symbols(QUATERNION)
    if attitude == "predicted" and interface == "thrust_attitude":
        middle = _attitude_loop(build, attitude_time_constant, dt)
        build.numbers |= {"attitude_time": attitude_time_constant} if attitude_time_constant else {}
    elif attitude == "predicted":
        moments = _scaled_inertia(build, mass) if inertia is None else tuple(inertia)
        build.notes += [ABOVE] if _beyond_others(moments) > 1.0 + 1e-6 else []
        build.numbers |= dict(zip(("jx", "jy", "jz"), moments, strict=True))
        if interface == "thrust_rates":
            if rate_gains is None:
                known = " ".join(f"{gain:g}" for gain in gains)
                build.notes.append(f"the rate loop has the Crazyflie's gains, {known} 1/s: give those of your own")
            build.numbers |= dict(zip(("kx", "ky", "kz"), gains, strict=True))
            middle = _rate_loop(build, moments, gains, torque, dt)
        else:
            middle = _free_rotation(build, moments, torque, dt)
    _translation(build, mass, middle, dt)
    layouts, numbers = _layouts(interface, attitude, actuators), build.numbers
    remarks = (*build.notes, *unlikely_in_quadrotor(mass, numbers))
    return Equations(build.next, layouts, dt, quantities=build.quantities, robot=robot, notes=remarks, numbers=numbers)


def _layouts(interface: Interface, attitude: Attitude, actuators: Motors | Wrenches | None) -> Layouts:
    commands = COMMANDS[interface] if actuators is None else actuators.columns
    if attitude == "measured":
        actions = commands if interface == "motors" else commands[:1]
        return Layouts(Layout.of(POSITION + VELOCITY), Layout.of(actions), Layout.of(FORCE + QUATERNION))
    if interface == "thrust_attitude":
        return Layouts(Layout.of(POSITION + QUATERNION + VELOCITY), Layout.of(commands), Layout.of(FORCE))
    return Layouts(Layout.of(POSITION + QUATERNION + VELOCITY + RATES), Layout.of(commands), Layout.of(FORCE + TORQUE))


def _actuated(build: _Build, motors: Motors | Wrenches, attitude: Attitude) -> Vector:
    """Names the thrust and, where it turns the body, the torque of actuators; the whole torque about the body axes."""
    build.numbers |= motors.numbers
    thrust, torque = motors.wrench(symbols(motors.columns))
    if thrust != symbol(THRUST_COLUMN):
        build.name((THRUST_COLUMN,), (thrust,))
    external = symbols(TORQUE)
    return external if attitude == "measured" else external + build.name(MOTOR_TORQUES, torque)


def _translation(build: _Build, mass: float, attitude: Vector, dt: float) -> None:
    up = build.name(("axis_x", "axis_y", "axis_z"), axes(attitude)[2])
    for p, v, force, axis in zip(POSITION, VELOCITY, FORCE, up, strict=True):
        acceleration = (symbol("thrust") * axis + symbol(force)) / mass - (GRAVITY if p == "z" else 0)
        build.follow((p, v), free_fall(symbol(p), symbol(v), acceleration, dt))


def _rate_loop(build: _Build, inertia: Sequence[float], gains: Sequence[float], torque: Vector, dt: float) -> Vector:
    """Rates follow their commands: ω̇ = K (ω_cmd - ω) + J⁻¹ (τ - ω × J ω), the last term at the mean rate."""
    rates, commands = symbols(RATES), symbols(COMMANDS["thrust_rates"][1:])
    whole, half = FirstOrder(gains, dt), FirstOrder(gains, dt / 2)
    accelerations = torque / inertia
    at_start = build.name(START_DRIFT, accelerations + gyroscopic(inertia, rates))
    rough = build.name(ROUGH, whole.mean(rates, commands, at_start))
    drift = build.name(DRIFT, accelerations + gyroscopic(inertia, rough))
    build.follow(RATES, whole.end(rates, commands, drift))
    return _turned(build, whole.mean(rates, commands, drift), half.mean(rates, commands, drift), dt)


def _free_rotation(build: _Build, inertia: Sequence[float], torque: Vector, dt: float) -> Vector:
    """J ω̇ = τ - ω × J ω by the mid-point rule."""

    def acceleration(rates: Vector) -> Vector:
        return torque / inertia + gyroscopic(inertia, rates)

    rates = symbols(RATES)
    drift = build.name(DRIFT, acceleration(rates))
    attitude = _turned(build, rates + dt / 2 * drift, rates + dt / 4 * drift, dt)
    build.follow(RATES, rates + dt * acceleration(symbols(MEAN)))
    return attitude


def _turned(build: _Build, mean: Vector, first_half: Vector, dt: float) -> Vector:
    """Next attitude from the mean rates; returns the attitude at mid-step."""
    start = symbols(QUATERNION)
    turn = build.name(TURN, increment(dt * build.name(MEAN, mean)))
    build.follow(QUATERNION, product(start, turn))
    half_turn = build.name(HALF_TURN, increment(dt / 2 * build.name(FIRST_HALF, first_half)))
    return build.name(MIDDLE, product(start, half_turn))


def _attitude_loop(build: _Build, time_constant: float, dt: float) -> Vector:
    """The attitude goes a fraction 1 - e^(-t/τ) of the short way to the command, along the chord."""
    start, wanted = symbols(QUATERNION), symbols(COMMANDS["thrust_attitude"][1:])
    same_side = sign(start @ wanted)

    def towards(time: float) -> Vector:
        part = 1.0 - math.exp(-time / time_constant) if time_constant > 0 else 1.0
        return (1.0 - part) * start + part * same_side * wanted

    build.follow(QUATERNION, towards(dt))
    middle = towards(dt / 2)
    return build.name(MIDDLE, middle / sqrt((middle**2).sum()))


def _scaled_motors(mass: float) -> Motors:
    scale = (mass / crazyflie.MASS) ** (1.0 / 3.0)
    return Motors(
        thrust=mass * GRAVITY / 4.0 / 0.5,
        torque_per_thrust=crazyflie.TORQUE_PER_THRUST * scale,
        arm=crazyflie.ARM * scale,
    )


def _scaled_inertia(build: _Build, mass: float) -> tuple[float, ...]:
    build.notes.append("inertia scaled from the Crazyflie by mass^(5/3): measure it")
    return tuple(moment * (mass / crazyflie.MASS) ** (5.0 / 3.0) for moment in crazyflie.INERTIA)


def _beyond_others(inertia: Sequence[float]) -> float:
    """The largest moment over the sum of the others."""
    return max(inertia) / (sum(inertia) - max(inertia))


def _check(mass: float, inertia: Sequence[float] | None, interface: str, attitude: str, dt: float) -> None:
    if interface not in COMMANDS:
        raise ModelError(f"interface must be one of {', '.join(COMMANDS)}, found {interface!r}")
    if attitude not in ("predicted", "measured"):
        raise ModelError(f"attitude must be 'predicted' or 'measured', found {attitude!r}")
    if not 0 < mass < math.inf or not 0 < dt < math.inf:
        raise ModelError(f"mass in kg and dt in s must be positive, found {mass} and {dt}")
    if inertia is not None and (len(inertia) != 3 or min(inertia) <= 0 or _beyond_others(inertia) > FLAT):
        raise ModelError(
            f"inertia must be three positive moments in kg m², none above the sum of the others, found {tuple(inertia)}"
        )
