"""Rotorcraft that are heavier, lean on their thrust, or give another thrust than was commanded.

``added_mass``. More mass than the nominal robot's: thrust and forces times m₀/(m₀ + Δm). Gravity is an acceleration and
stays.

Masses add up: on equations that have a mass already, m₀ is that of the robot which carries it.

``thrust_curve``. Thrust that bends against its command: T → T₀ (T/T₀)^p, T₀ the hover thrust. Where motors turn the
body each rotor's thrust bends so, with the torques that it makes.

``battery_sag``. Thrust that fades as the battery empties: T (1 - s·t), or T (1 - s·(V₀ - V)) where the voltage is an
input.

V₀ is where the thrust map holds: the number ``full_battery`` of the equations, else that of a full cell.

``com_offset``. The centre of mass beside the thrust line: τ = -r × T e₃ = T (-r_y, r_x, 0).

``rotor_loss``. One rotor gives less: (1 - ℓ) of its thrust, and the torques that follow.

``ground_effect``. More thrust near the ground: T (1 + g e^(-z/h)), h 0.07 m of a Crazyflie, and of another robot as
many times that as it is larger, by its arm or the cube root of its mass: the smaller, as a mass that nobody gave counts
as 1 kg. Heights of a log may count from elsewhere: below zero the ground is as near as at zero.
"""

import math
from functools import partial
from typing import Any

import numpy as np
from sympy import Expr, Max, exp

from sym2real.effects import simulated_rotors, truth
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.commands import LEAST, MOST
from sym2real.effects.kind import Domain, Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.rotors import alone, driven_by_motors, levers, motor_forces, motor_sums, shares
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.terms import acting_thrust, defined, hover_thrust, scaled, with_time
from sym2real.effects.voltage import VOLTAGE
from sym2real.effects.wrench import apply_wrench
from sym2real.errors import ModelError
from sym2real.layout import motors_of
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol

_of_rotorcraft = partial(Kind, robot="quadrotor")


def _added_mass_parameters(body: Body) -> tuple[Parameter, ...]:
    mass = body.numbers.get("mass", 1.0)
    left = Domain(-mass, open=True)  # some of it must be
    low, high = (mass * (1.0 / gain - 1.0) for gain in (MOST, LEAST))  # as far as the thrust gains that it stands for
    return (Parameter("value", "kg", null=0.0, low=low, high=high, scale=0.1 * mass, domain=left),)


def _added_mass_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    before = body.mass + _carried(equations)
    factor = before / (before + values["value"])
    forces = [name for name in ("fx", "fy", "fz") if name in equations.layouts.inputs]
    names = [acting_thrust(equations).name, *forces]
    return equations.substitute({name: symbol(name) * factor for name in names})


def _carried(equations: Equations) -> float:
    """Mass in kg that equations have beyond the nominal one."""
    names = {"added_mass": "value", "payload": "mass"}
    return sum(values.get(names[key], 0.0) for key, values in equations.effects if key in names)


ADDED_MASS = _of_rotorcraft(
    name="added_mass",
    stage="mass",
    parameters=_added_mass_parameters,
    formula=r"T, F \to \frac{m_0}{m_0 + \Delta m}\,(T, F)",
    summary="The robot is heavier than the nominal one, at its centre.",
    confused_with="a thrust gain below one, unless motors turn the body; near one thrust a thrust offset",
    shown_by="no flight tells it from a thrust gain, unless motors turn the body: weigh the robot",
    fix="weigh the robot and set its mass; if the mass is right, correct the thrust map by this factor instead",
    inject=truth.editing(lambda spec, body, values: truth.set_inertial(spec, extra_mass=values["value"])),
    of_joints="load",
    substitute=_added_mass_substitute,
    needs=("thrust",),
    numbers=("mass",),
    distinguished_by="scales do: weigh the robot",
)


# Below this share of the hover thrust the curve goes straight to zero: its slope there would be infinite for p < 1.
STRAIGHT_BELOW = 0.01


def _thrust_curve_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    def bending(thrust: Expr, rotors: int) -> Expr:
        """Factor of the thrust of some among the body's rotors."""
        in_hover = hover_thrust(body) * rotors / body.rotors
        return Max(thrust / in_hover, STRAIGHT_BELOW) ** (values["value"] - 1)

    if not driven_by_motors(equations):
        return scaled(equations, bending(symbol("thrust"), body.rotors))
    more = [bending(thrust, 1) - 1 for thrust in motor_forces(equations)]
    sums = {
        name: equations.quantities[name] + sum(bent * alone(equations, name, rotor) for rotor, bent in enumerate(more))
        for name in motor_sums(equations)
    }
    return defined(equations, sums)


def _bend(command: float, body: Body, values: Numbers) -> float:
    hover = body.mass * GRAVITY
    return float(hover * (max(command, 0.0) / hover) ** values["value"])


def _bent(body: Body, values: Numbers) -> Change:
    """Of the thrust command, or of every motor's thrust."""
    if "thrust" not in body.quantities:
        return truth.commanding(_bend, "thrust")(body, values)

    def bend(data: Any, body: Body, values: Numbers) -> None:
        truth.bend_rotors(data, lambda alone: _bend(body.rotors * alone, body, values) / body.rotors)

    return truth.with_force(bend)(body, values)


THRUST_CURVE = _of_rotorcraft(
    name="thrust_curve",
    stage="thrust",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.3, high=3.0, scale=0.2)),
    formula=r"T \to T_0\,(T/T_0)^p",
    summary="The thrust map is bent, each rotor's where motors turn the body: right in hover, wrong above and below.",
    confused_with="a thrust gain with an offset, where thrust varies little",
    shown_by="thrust over a wide range: hard climbs and descents",
    fix="measure thrust against command on a scale and replace the thrust map",
    inject=_bent,
    substitute=_thrust_curve_substitute,
    needs=("thrust",),
    numbers=("mass",),
    searching=Searching(shown_in=lambda _: (Shown.CLIMBS,)),
)


FULL_BATTERY = 4.2  # V, one lithium-polymer cell


def _battery_sag_parameters(body: Body) -> tuple[Parameter, ...]:
    if VOLTAGE in body.layouts.inputs:
        return (Parameter("value", "1/V", null=0.0, low=0.0, high=1.0, scale=0.1),)
    return (Parameter("value", "1/s", null=0.0, low=0.0, high=0.1, scale=0.005),)


def _battery_sag_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    if VOLTAGE in body.layouts.inputs:
        full = body.numbers.get("full_battery", FULL_BATTERY)
        return scaled(equations, 1 - values["value"] * (full - symbol(VOLTAGE)))
    equations, time = with_time(equations)
    return scaled(equations, 1 - values["value"] * time)


def _why_not(body: Body) -> str:
    """A battery lets rotors turn more slowly; what a rotor of some speed gives is the air's."""
    known = motors_of(body.layouts.action) and "rotor_thrust" in body.numbers
    through = "the battery acts through the rotors' speeds, which are in the logs; where these are commands, and not"
    return f"{through} measured, `sym2real add MODEL battery_sag --fit LOG` tests it" if known else ""


BATTERY_SAG = _of_rotorcraft(
    name="battery_sag",
    stage="thrust",
    parameters=_battery_sag_parameters,
    formula=r"T \to T\,(1 - s\,t) \;\text{or}\; T\,(1 - s\,(V_0 - V))",
    summary="Thrust fades while the battery empties: by s a second, or a volt V below V₀ where logs hold the voltage.",
    confused_with="a thrust gain in short logs",
    shown_by="logs of at least 8 s, better with the battery's voltage in them (V₀ is that of their first 2 s)",
    fix="switch the firmware's battery compensation on, log the voltage, or charge more often",
    inject=truth.with_force(lambda data, body, values: truth.scale_thrust(data, 1.0 - values["value"] * data.time)),
    substitute=_battery_sag_substitute,
    needs=("thrust",),
    reads=(VOLTAGE,),
    searching=Searching(why_not=_why_not, shown_in=lambda _: (Shown.TIME,)),
)


# m: no robot of these is so large, and its centre of mass is inside of it.
WITHIN = Domain(-1.0, 1.0)


def _com_offset_parameters(body: Body) -> tuple[Parameter, ...]:
    along = (Parameter(name, "m", null=0.0, low=-0.03, high=0.03, scale=0.002, domain=WITHIN) for name in ("rx", "ry"))
    # Thrust passes through a centre of mass that is only higher or lower.
    return (*along, Parameter("rz", "m", null=0.0, low=-0.03, high=0.03, scale=0.002, fitted=False, domain=WITHIN))


def _com_offset_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    thrust = acting_thrust(equations)
    return apply_wrench(equations, body, torque=(-values["ry"] * thrust, values["rx"] * thrust))


COM_OFFSET = _of_rotorcraft(
    name="com_offset",
    stage="wrench",
    parameters=_com_offset_parameters,
    formula=r"\tau = -r \times T e_3",
    summary="The centre of mass lies beside the thrust line, r forward and left of it, so that thrust turns the body.",
    confused_with="a constant torque or an offset of the rate commands, where thrust hardly varies",
    shown_by="thrust that varies: climbs and descents, fast turns",
    fix="move the battery or the load by minus this offset, or trim the mixer",
    inject=truth.editing(
        lambda spec, body, values: truth.set_inertial(spec, offset=(values["rx"], values["ry"], values["rz"]))
    ),
    substitute=_com_offset_substitute,
    needs=("thrust", "wx", "wy"),
    by_torque=lambda _: True,
)


def _rotor_loss_parameters(body: Body) -> tuple[Parameter, ...]:
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


def _rotor_loss_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    rotor, loss = _number(values["rotor"], body), values["value"]
    if driven_by_motors(equations):
        sums = {
            name: equations.quantities[name] - loss * alone(equations, name, rotor) for name in motor_sums(equations)
        }
        return defined(equations, sums)
    lost, thrust = loss * shares(equations, body)[rotor], acting_thrust(equations)
    # Thrust first: what the torque is made of is the thrust that was meant.
    equations = equations.substitute({thrust.name: thrust - lost})
    return apply_wrench(equations, body, torque=[-lever * lost for lever in levers(body, rotor)])


def _inject(body: Body, values: Numbers) -> Change:
    """A force at the rotor against what it gives, from what all actuators give now."""
    rotor = _number(values["rotor"], body)

    def lose(model: Any, data: Any) -> None:
        place, reaction = (query(model, body)[rotor] for query in (simulated_rotors.places, simulated_rotors.reactions))
        lost = values["value"] * simulated_rotors.thrusts(model, data, body)[rotor]
        truth.add_thrust(data, -lost, place)
        truth.add_torque(data, np.array([0.0, 0.0, -lost * reaction]))

    return Change("", force=lose)


ROTOR_LOSS = _of_rotorcraft(
    name="rotor_loss",
    stage="wrench",
    parameters=_rotor_loss_parameters,
    formula=r"T_i \to (1 - \ell)\,T_i",
    summary="One rotor gives less thrust than the others: a chipped propeller, a tired motor.",
    confused_with="a thrust gain with a centre of mass that is off along a diagonal",
    shown_by="yaw, which a centre of mass leaves alone, with thrust that varies",
    fix="change that propeller, or that motor",
    inject=_inject,
    substitute=_rotor_loss_substitute,
    needs=("thrust", "wx", "wy", "wz"),
    numbers=("arm", "torque_per_thrust"),
    searching=Searching(choices=lambda body: ("rotor", _choices(body))),
)


REACH, OF_MASS, OF_ARM = 0.07, 0.027, 0.046  # m, and kg and m of the robot that has it


def _reach(body: Body) -> float:
    """Height in m at which it has fallen to 1/e."""
    by_mass = math.cbrt(body.numbers.get("mass", OF_MASS) / OF_MASS)
    return REACH * min(by_mass, body.numbers.get("arm", math.inf) / OF_ARM)


def _lift(data: Any, body: Body, values: Numbers) -> None:
    height = max(float(data.qpos[2]), 0.0)
    truth.scale_thrust(data, 1.0 + values["value"] * float(np.exp(-height / _reach(body))))


def _ground_effect_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    return scaled(equations, 1 + values["value"] * exp(-Max(symbol("z"), 0) / _reach(body)))


GROUND_EFFECT = _of_rotorcraft(
    name="ground_effect",
    stage="thrust",
    parameters=of_any_body(Parameter("value", "1", null=0.0, low=0.0, high=2.0, scale=0.2)),
    formula=r"T \to T\,(1 + g\,e^{-z / h})",
    summary="Close to the ground the rotors' own air lifts the robot; h = 0.07 m of a Crazyflie, more of larger ones.",
    confused_with="less mass or more thrust at one height; trim of the thrust that differs from flight to flight",
    shown_by="at least three low flights whose height moves between h and 4 h",
    fix="fly higher than three rotor diameters, or keep the term in the model",
    inject=truth.with_force(_lift),
    substitute=_ground_effect_substitute,
    needs=("thrust", "z"),
    searching=Searching(shown_in=lambda _: (Shown.LOW,)),
)
