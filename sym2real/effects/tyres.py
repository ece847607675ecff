r"""Tyres of a car: they slide, slip, or give their side force late.

``roll_steer``. A simulated car whose axles steer outwards as the chassis leans in turns (Gillespie, ch. 6).

An axle that turns by an angle per lateral acceleration leads the car as tyres do that slip by it. The four wheels keep
one turning centre, as a linkage would have them: else they fight each other, and some of them slide. What several
effects steer adds up in a number of the description, from which the wheels are turned.

``tyre_friction``. Tyres that hold less: the force on the ground is limited to μ·m·g.

Across the motion it limits the turn. Front tyres at their limit turn the car about its rear axle, c = L/2 behind its
centre, against the lateral acceleration of that centre and against wheels that are driven alike::

    (J + m c²) dω/dt = ± μ m g c - m c (|u| + u₀) ω,   u₀ = 2 k w²/(L m)

k: the drive's N s/m a wheel, w: the track. Front tyres that slide sideways with v_s resist less, by
1/(1 + 4 k v_s/(μ m g)). After a step the yaw rate lies between the two solutions: where tyres slide it follows late.

A tyre that slides has one force, against its slip (Coulomb): of μ m g the drive gets the share that its demand
4 k (u_cmd - u) has beside the turn's, m u² tan(δ)/L. The plain robot has μ = 1.

``tyre_slip``. Tyres that must slip for a side force: both axles move at an angle D·a_y outwards of where their wheels
point.

A tyre's side force is its slip angle times its cornering stiffness, so in a turn the rear axle moves outwards of the
heading by m l_f a_y / (L C_r) = D a_y (R. T. Bundorf's cornering compliance; Gillespie, ch. 6): v_rear = -D |u| a_y,
a_y = u ω_z. The front axle does alike; what it does beyond that is ``understeer``. To D a_y tan²δ the turn is then that
of the base, which is asked with the slip taken off the velocity; the slip is added to velocity and place behind it.
Tyres take up their slip within centimetres: it is the steady one of the step's end.

``relaxation_length``. Tyres that must roll for it: the side force, and with it the turn, follows the steering over a
distance σ.

A tyre's side force is at its steady value once the tyre has rolled a few relaxation lengths (Pacejka, Tyre and Vehicle
Dynamics, ch. 1 and 7)::

    (σ/|u|) dF'/dt = F - F'

In a turn the side force is m u² tan(δ)/L, so that at a speed it is the turn that follows: δ' in the place of δ. It is a
lag whose time goes by the speed. δ' is a hidden state that starts at the first command; the equations turn by its mean
over the step, exact for the speed of the step's start, and a gyro shows its end, as of a lag (``steering.py``).

``yaw_inertia``. Tyres must first turn the car: the yaw rate follows the steering with a time that grows with the speed.

Of a car whose axles give way alike, (C_f l_f² + C_r l_r²) (ω_steady - ω)/u = J dω/dt, so that ω is a lag of κ u behind
the steady turn, κ = J/(C_f l_f² + C_r l_r²) (Rajamani, ch. 2). Road cars have 0.006 s²/m. As with the relaxation length
it is the angle that turns the car that follows.

``understeer``. A car that turns less than its steering says, the more so the faster it turns: δ_eff = δ - K a_y, a_y =
u ω_z.

In a steady turn δ = L/R + K a_y, K = D_f - D_r: what the front axle gives way by, per lateral acceleration, beyond the
rear (T. D. Gillespie, Fundamentals of Vehicle Dynamics, ch. 6; R. Rajamani, Vehicle Dynamics and Control, ch. 3).
Tyres and bushings are fast beside a control period, so the turn is the steady one: with k = K u|u| / L the angle that
turns the car solves δ_eff + k tan δ_eff = δ, whose first Newton step from δ is taken. Backwards, slip has the other
sign. Below zero the car oversteers, and diverges where k = -1, its critical speed; the equations stop short of it.

``lateral_slip``. A lateral force at the centre of mass, c ahead of the rear axle: F = -k·m·v_lat, v_lat = v + c·ω_z.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from sympy import Abs, Expr, Integer, Max, Min, Piecewise, atan, exp, sqrt, tan

from sym2real.effects import truth
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.frames import body_velocity, dot
from sym2real.effects.kind import NOT_NEGATIVE, Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.steering import SHARE, YAW_RATE, over_columns, seen
from sym2real.effects.terms import begun_at_rest, defined, with_hidden
from sym2real.effects.wrench import FORWARD, apply_yaw_torque, forward_speed
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import exchange

_of_car = partial(Kind, robot="car")

NUMBERS = "roll_steer"  # of the description: front and rear, rad per m/s²


def roll_steer(body: Body, front: float, rear: float) -> Change:
    """Wheels are turned against the chassis; what that does to the car is left to their contacts with the ground.

    Args:
        body: a car.
        front, rear: of the axles, rad outwards per m/s² of lateral acceleration; inwards when driving backwards.

    Raises:
        ModelError: when the robot's numbers do not suffice.
    """
    wheelbase, track = body.number("wheelbase"), body.number("track")
    places = {
        f"{axle}_{side}": (along, across)
        for axle, along in (("front", wheelbase), ("rear", 0.0))
        for side, across in (("left", track / 2), ("right", -track / 2))
    }

    def turn(model: Any, data: Any) -> None:
        """Set the wheels' angles (rad) against the chassis, less what the steering joints have turned them."""
        outwards_front, outwards_rear = model.numeric(NUMBERS).data
        forward = float(truth.rotation(data)[:, 0] @ truth.velocity(data))
        lateral = abs(forward) * float(truth.rates(data)[2])
        angles = {wheel: float(data.joint(f"{wheel}_steer").qpos[0]) for wheel in places if wheel.startswith("front")}
        left = np.tan(angles["front_left"])
        steer = np.arctan(wheelbase * left / (wheelbase + track / 2 * left))
        aside = np.tan(outwards_rear * lateral)  # the turning centre is that part of the radius ahead of the rear axle
        curvature = (np.tan(steer - outwards_front * lateral) + aside) / wheelbase
        for wheel, (along, across) in places.items():
            wanted = np.arctan2(along * curvature - aside, 1.0 - across * curvature)
            half = (wanted - angles.get(wheel, 0.0)) / 2
            model.body(wheel).quat = [np.cos(half), 0.0, 0.0, np.sin(half)]

    return Change("", edit=lambda spec: _add(spec, front, rear), force=turn)


def _add(spec: Any, front: float, rear: float) -> None:
    """Put angles to those of the effects before."""
    known = spec.numeric(NUMBERS)
    if known is None:
        spec.add_numeric(name=NUMBERS, size=2, data=[front, rear])
    else:
        known.data = [known.data[0] + front, known.data[1] + rear]


PLAIN = 1.0
SLOWEST = 1e-3  # m/s; slower cars are not limited


def _tyre_friction_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    friction, steer, command = values["value"], symbol("steer"), symbol("speed")
    drive, forward = 4 * body.numbers.get("wheel_drive", 0.0) / body.mass, forward_speed(body)
    grip = friction * GRAVITY
    changes = {}
    wheelbase, track = body.number("wheelbase"), body.numbers.get("track", 0.0)
    if drive > 0 and "speed" in body.layouts.action:
        ahead, across = (1 - exp(-drive * body.dt)) / body.dt * (command - forward), forward**2 * tan(steer) / wheelbase
        held = grip / Max(grip, sqrt(ahead**2 + across**2))
        changes["speed"] = Piecewise((forward + held * (command - forward), friction < PLAIN), (command, True))
    speed, resisting = Max(Abs(forward), SLOWEST), drive * track**2 / (2 * wheelbase)
    sliding = Max(speed * Abs(tan(steer)) - wheelbase * grip / (speed + resisting), 0)
    resisting = speed + resisting / 2 * (1 + grip / (grip + drive * sliding))
    going, kept = Piecewise((speed, forward >= 0), (-speed, True)), _kept(body, resisting)
    middle, reach = kept * symbol("wz") if kept else 0, (1 - kept) * grip / resisting
    turn = Max(middle - reach, Min(middle + reach, going * tan(steer) / wheelbase))
    limited = atan(turn * wheelbase / going)
    changes["steer"] = Piecewise((limited, friction < PLAIN), (steer, True))
    return equations.substitute(changes)


def _kept(body: Body, resisting: Expr) -> Expr | float:
    """Share of the yaw rate that is left after a step against |u| + u₀; none where nobody told the inertia."""
    if "jz" not in body.numbers or "wz" not in body.layouts.state:
        return 0
    centre = body.number("wheelbase") / 2
    return exp(-body.dt * resisting / (body.number("jz") / (body.mass * centre) + centre))


def _smooth(spec: Any, body: Body, values: Numbers) -> None:
    """Friction of all geoms: MuJoCo takes the larger of the two that touch."""
    for geom in spec.geoms:
        geom.friction = [min(values["value"], geom.friction[0]), *list(geom.friction)[1:]]


TYRE_FRICTION = _of_car(
    name="tyre_friction",
    stage="thrust",
    parameters=of_any_body(Parameter("value", "1", null=PLAIN, low=0.05, high=PLAIN, scale=0.3, domain=NOT_NEGATIVE)),
    formula=r"|F_\mathrm{lateral}| \le \mu\,m\,g",
    summary="The tyres let go in fast turns, and the car runs wide.",
    confused_with="a steering gain below one, where every turn is fast",
    shown_by="turns at a lateral acceleration of 2.7 m/s² or more, beside slow ones",
    fix="clean or change the tyres or the floor, or slow down in turns",
    inject=truth.editing(_smooth),
    substitute=_tyre_friction_substitute,
    needs=("steer", *FORWARD),
    numbers=("mass", "wheelbase"),
    searching=Searching(
        starts=lambda _body, _values: (0.25, 0.4, 0.6),
        from_null=False,
        sizes=lambda _body, _values: (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1),
        shown_in=lambda _: (Shown.HARD,),
    ),
)


def _slip(compliance: Expr, forward: Expr, rate: Expr) -> Expr:
    return -compliance * Abs(forward) * forward * rate


def _tyre_slip_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    before = _slip(values["value"], forward_speed(body), symbol("wz"))
    changes = {"vx": symbol("vx") + before * symbol("sin_yaw"), "vy": symbol("vy") - before * symbol("cos_yaw")}
    held = replace(equations.substitute(changes), output=equations.output)  # what is measured is the car's
    after = held.next
    forward = dot((after["vx"], after["vy"]), (after["cos_yaw"], after["sin_yaw"]))
    slip = _slip(values["value"], forward, after["wz"])
    aside = {"x": -slip * after["sin_yaw"], "y": slip * after["cos_yaw"]}
    moved = {name: after[name] + equations.dt * speed for name, speed in aside.items()}
    moved |= {f"v{name}": after[f"v{name}"] + speed for name, speed in aside.items()}
    return replace(held, next={**after, **moved})


TYRE_SLIP = _of_car(
    name="tyre_slip",
    stage="loop",
    # Tyres whose stiffness is 10 to 50 times their load have 0.01 to 0.002.
    parameters=of_any_body(Parameter("value", "rad s²/m", null=0.0, low=0.0, high=0.1, scale=0.005)),
    formula=r"v_\mathrm{rear} = -D\,|u|\,u\,\omega_z",
    summary="Tyres slip to push sideways, so that in turns the car moves outwards of where it points.",
    confused_with="a lever arm at one speed, behind the axle by D u²",
    shown_by="the same circle at several speeds, at lateral accelerations up to 2.5 m/s²",
    fix="fit stiffer tyres or lighten the car, or keep the term in the model",
    inject=lambda body, values: roll_steer(body, front=values["value"], rear=values["value"]),
    substitute=_tyre_slip_substitute,
    needs=("steer", "x", "y", *FORWARD, "wz"),
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)


TURN, INERT_TURN = "tyre_turn", "inert_turn"
STANDING = 0.01  # m/s; a car that stands keeps its turn


def _memory(turn: str) -> str:
    return f"{turn}_memory"


def _late_turn(equations: Equations, turn: str, periods: Expr, values: Values) -> Equations:
    """Turns by the mean over a step of a lag behind the steering, of a time in control periods.

    A gyro shows the lag's end, but for a servo behind it (``steering.py``).
    """
    steer, memory, before = symbol("steer"), symbol(_memory(turn)), equations
    kept, away = exp(-1 / periods), memory - steer
    end, mean = steer + away * kept, steer + away * periods * (1 - kept)
    equations = begun_at_rest(defined(equations, {turn: Integer(0)}), {"steer": symbol(turn)})
    equations = with_hidden(equations, _memory(turn), "rad", end, start=steer)
    equations = defined(equations, {turn: mean})
    if SHARE not in values:
        return equations
    shown = exchange({steer: end + values[SHARE] * (mean - end)})(over_columns(before, before.next[YAW_RATE]))
    return replace(equations, next={**equations.next, YAW_RATE: shown})


def _speed(body: Body) -> Expr:
    return Max(Abs(forward_speed(body)), STANDING)


def _late_wheels(value: float, time: Callable[[float, float], float]) -> Change:
    """Wheels that MuJoCo's actuator filters turn, in a time (s) by value and speed; the contacts do the rest."""
    columns = ("front_left_steer", "front_right_steer")

    def slowed(model: Any, data: Any) -> None:
        speed = abs(float(truth.rotation(data)[:, 0] @ truth.velocity(data)))
        for name in columns:
            truth.set_time(model, name, time(value, max(speed, STANDING)))

    def edit(spec: Any) -> None:
        for name in columns:
            truth.set_lag(spec, spec.actuator(name), time(value, STANDING))

    return Change("", edit=edit, force=slowed)


def _parameters(body: Body) -> tuple[Parameter, ...]:
    """Tyres have about their radius, a sixth of the wheelbase of cars of all sizes."""
    length = body.numbers.get("wheelbase", 1.0)
    value = Parameter("value", "m", null=0.0, low=0.0, high=3 * length, scale=length / 6, domain=NOT_NEGATIVE)
    return value, *seen(body)


def _relaxation_length_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    return _late_turn(equations, TURN, values["value"] / (_speed(body) * equations.dt), values)


RELAXATION_LENGTH = _of_car(
    name="relaxation_length",
    stage="loop",
    parameters=_parameters,
    formula=r"\frac{\sigma}{|u|}\,\dot F' = F - F'",
    summary="Tyres must roll a distance before they push sideways, so that turns begin late, the later the slower.",
    confused_with="a lag of the steering at one speed",
    shown_by="steps of the steering at several speeds",
    fix="pump up or stiffen the tyres, or let the controller plan with the term",
    inject=lambda body, values: _late_wheels(values["value"], lambda length, speed: length / speed),
    substitute=_relaxation_length_substitute,
    needs=("steer", *FORWARD),
    hidden=(_memory(TURN),),
    lagging=True,
    searching=Searching(varying=("steer",), shown_in=lambda _: (Shown.SPEEDS,)),
)


YAW_INERTIA = _of_car(
    name="yaw_inertia",
    stage="loop",
    parameters=lambda body: (
        Parameter("value", "s²/m", null=0.0, low=0.0, high=0.1, scale=0.005, domain=NOT_NEGATIVE),
        *seen(body),
    ),
    formula=r"\kappa\,|u|\,\dot \omega_z = \omega_\mathrm{steady} - \omega_z",
    summary="The tyres must turn the car's inertia first, so that turns begin late, the later the faster it drives.",
    confused_with="a lag of the steering at one speed",
    shown_by="steps of the steering at several speeds",
    fix="stiffen the tyres or move mass to the middle, or let the controller plan with the term",
    inject=lambda body, values: _late_wheels(values["value"], lambda inertia, speed: inertia * speed),
    substitute=lambda equations, values, body: _late_turn(
        equations, INERT_TURN, values["value"] * _speed(body) / equations.dt, values
    ),
    needs=("steer", *FORWARD),
    hidden=(_memory(INERT_TURN),),
    lagging=True,
    searching=Searching(varying=("steer",), shown_in=lambda _: (Shown.SPEEDS,)),
)


LEAST = 0.2  # of 1 + k / cos² δ, which is zero where the car diverges


def _understeer_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    steer, forward = symbol("steer"), forward_speed(body)
    growth, slope = values["value"] * forward * Abs(forward) / body.number("wheelbase"), tan(steer)
    return equations.substitute({"steer": steer - growth * slope / Max(1 + growth * (1 + slope**2), LEAST)})


UNDERSTEER = _of_car(
    name="understeer",
    stage="thrust",
    # Road cars have 0.002 to 0.01 (1 to 6 degrees per g).
    parameters=of_any_body(Parameter("value", "rad s²/m", null=0.0, low=-0.02, high=0.1, scale=0.005)),
    formula=r"\delta \to \delta - K\,u\,\omega_z",
    summary="The front axle gives way more than the rear, so fast turns are wider than the steering says.",
    confused_with="a steering gain at one speed; tyres at their limit where every turn is fast",
    shown_by="the same circle at several speeds, at lateral accelerations up to 2.5 m/s²",
    fix="stiffen the steering and the front tyres, or move weight back; below zero: the rear, and forward",
    inject=lambda body, values: roll_steer(body, front=values["value"], rear=0.0),
    substitute=_understeer_substitute,
    needs=("steer", *FORWARD),
    numbers=("wheelbase",),
    searching=Searching(varying=("steer",), shown_in=lambda _: (Shown.SPEEDS,)),
)


def _lateral_slip_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    centre = body.number("centre")
    sideways = body_velocity(body)[1] + centre * symbol("wz")
    return apply_yaw_torque(equations, body, -values["value"] * body.mass * centre * sideways)


def _brake(data: Any, body: Body, values: Numbers) -> None:
    turned = truth.rotation(data)
    along = turned.T @ truth.velocity(data) + np.cross(truth.rates(data), [body.number("centre"), 0.0, 0.0])
    truth.add_force(data, -values["value"] * body.mass * along[1] * turned[:, 1])


LATERAL_SLIP = _of_car(
    name="lateral_slip",
    stage="wrench",
    parameters=of_any_body(Parameter("value", "1/s", null=0.0, low=0.0, high=50.0, scale=5.0)),
    formula=r"F_\mathrm{lateral} = -c\,m\,v_\mathrm{lateral}",
    summary="Something drags against sideways motion of the centre of mass; while the tyres hold, turns cost speed.",
    confused_with="yaw drag while the tyres hold",
    shown_by="turns both ways at several speeds, beside straight driving",
    fix="find what drags (cables, a loose wheel), or keep the term in the model",
    inject=truth.with_force(_brake),
    substitute=_lateral_slip_substitute,
    needs=("steer", "wz", *FORWARD),
    numbers=("mass", "wheelbase", "centre"),
    searching=Searching(shown_in=lambda _: (Shown.HARD,)),
)
