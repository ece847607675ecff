"""What brakes a robot on wheels, and wheels of other sizes or places.

``rolling_resistance``. A constant deceleration against the motion: F = -r·m·sign(u) along the heading.

``turning_friction``. What brakes a turn of a robot on wheels by a constant torque: τ_z = -c sign(ω_z), beside what its
file describes.

Wide wheels drill on the floor as the robot turns. One that touches along a line of length b, evenly loaded, does so
with μ N b/4, by the mean distance from its middle; in a simulator that lets it touch at both ends it is μ N b/2. So
what is missing may be less than nothing.

``wheel_radius``. Wheels larger or smaller than nominal, one or all: r → k·r, so that they turn 1/k times as much per
metre.

``track_width``. Wheels further apart, or closer, than nominal: b → k·b, so that a difference of their rates turns less,
or more.

``wheel_grip``. Wheels that spin or lock: the floor holds each by no more than μ times its load N at rest, so that along
its motion no more than μ N r of its torque moves the robot (Coulomb). That it then slides aside as well is left out.

``carried_mass``. A load on the chassis, or another mass than nominal: m → m + Δm, with the first moment m c_x ahead of
the axle and the inertia J about the axle's middle, each on its own.

``slope``. A floor that is not level: a constant force m·g in the plane.

``wheelbase``. Another distance between the axles: L → k·L, so that tan(steer) turns the car 1/k times as much.

``yaw_drag``. A torque against turning: τ_z = -c·J·ω_z, J the yaw inertia about the rear axle.
"""

import math
from functools import partial
from typing import Any

import numpy as np
from sympy import Abs, atan, sign, tan

from sym2real.effects import truth
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.kind import ANYTHING, POSITIVE, Domain, Kind, Numbers, Parameter, Values, of_any_body, several
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.terms import multiplied, raised
from sym2real.effects.wrench import FORWARD, apply_force_ahead, apply_wrench, apply_yaw_torque, forward_speed
from sym2real.errors import ModelError
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.dry_friction import USUAL_DECELERATION
from sym2real.vocabulary import (
    DRILLING,
    MASS_AHEAD,
    MASS_MOMENT,
    MASS_TURNING,
    TURNING_INERTIA,
    UNLIMITED,
    rate_per_speed,
    wheel_grip,
    wheel_lever,
    wheel_load,
)

_of_wheels = partial(Kind, robot="car")


def _rolling_resistance_brake(data: Any, body: Body, values: Numbers) -> None:
    ahead = truth.rotation(data)[:, 0]
    truth.add_force(data, -values["value"] * body.mass * np.sign(ahead @ truth.velocity(data)) * ahead)


def _no_loop(body: Body) -> str:
    """What such a deceleration does depends on the speed loop."""
    note = "the model is at its speed at once, so that an offset of it stands for this: --time-constant tells its loop"
    return note if body.at_its_speed else ""


ROLLING_RESISTANCE = _of_wheels(
    name="rolling_resistance",
    stage="wrench",
    parameters=of_any_body(Parameter("value", "m/s²", null=0.0, low=0.0, high=5.0, scale=0.5)),
    formula=r"F = -r\,m\,\mathrm{sign}(u)",
    summary="Bearings, gears or a soft floor brake the car by a constant force.",
    confused_with="an offset of the speed command, always; a speed gain at one speed",
    shown_by="four speeds, forwards and backwards",
    fix="free the drive train, or raise the speed loop's integral part",
    inject=truth.with_force(_rolling_resistance_brake),
    of_joints="joint_friction",
    substitute=lambda equations, values, body: apply_force_ahead(
        equations, body, -values["value"] * body.mass * sign(forward_speed(body))
    ),
    needs=FORWARD,
    numbers=("mass",),
    searching=Searching(why_not=_no_loop, shown_in=lambda _: (Shown.SPEEDS,)),
)


def _parameters(body: Body) -> tuple[Parameter, ...]:
    described, scale = body.numbers.get(DRILLING, 0.0), USUAL_DECELERATION * body.numbers.get(TURNING_INERTIA, 1.0)
    return (Parameter("value", "N m", null=0.0, low=-described, high=max(30 * scale, described), scale=scale),)


def _turning_friction_brake(data: Any, _body: Body, values: Numbers) -> None:
    truth.add_torque(data, np.array([0.0, 0.0, -values["value"] * np.sign(truth.rates(data)[2])]))


TURNING_FRICTION = _of_wheels(
    name="turning_friction",
    stage="wrench",
    parameters=_parameters,
    formula=r"\tau_z = -c\,\mathrm{sign}(\omega_z)",
    summary="Wheels that drill or scrub on the floor brake a turn by a constant torque.",
    confused_with="a gain of both wheels while the robot turns one way at one rate",
    shown_by="turns both ways, fast and slow",
    fix="put the torque into the model; narrower or rounder wheels drill less",
    inject=truth.with_force(_turning_friction_brake),
    substitute=lambda equations, values, _body: raised(equations, DRILLING, values["value"]),
    needs=(DRILLING,),
    numbers=(TURNING_INERTIA,),
    searching=Searching(shown_in=lambda _: (Shown.BOTH_WAYS,)),
)


# mujoco.mjtGeom, capsules and cylinders: their first size is the radius, the next one half the length.
LONG = (3, 5)


def wheels_of(body: Body) -> tuple[str, ...]:
    """The bound wheel, or all of them."""
    return (body.column,) if body.column else body.joints


def _resize(spec: Any, body: Body, values: Numbers) -> None:
    """Of what turns with a wheel the size across its axle, and the axle's height: the robot stands as before."""
    for wheel in wheels_of(body):
        turning = spec.joint(wheel).parent
        x, y, z = turning.pos
        turning.pos = [x, y, z + (values["value"] - 1.0) * max(geom.size[0] for geom in turning.geoms)]
        for geom in turning.geoms:
            radius, *others = values["value"] * geom.size
            geom.size = [radius, *(geom.size[1:] if int(geom.type) in LONG else others)]


WHEEL_RADIUS = _of_wheels(
    name="wheel_radius",
    stage="loop",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.5, high=2.0, scale=0.05, domain=POSITIVE)),
    formula=r"r \to k\,r",
    summary="A wheel, or all of them, rolls on a larger or smaller radius than nominal.",
    confused_with="a gain of the wheels' commands beside a damping, which together are the same",
    shown_by="straight drives at several speeds; a wheel alone also by the way a straight drive bends",
    fix="measure the way of some turns of the wheels, under load, and set the radius in the model",
    inject=truth.editing(_resize),
    substitute=lambda equations, values, body: multiplied(
        equations, map(rate_per_speed, wheels_of(body)), 1 / values["value"]
    ),
    needs=(DRILLING,),
    columns="joint",
    of_all=lambda _: True,
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)


def _widen(spec: Any, body: Body, values: Numbers) -> None:
    """Wheels further from the robot's middle, on whatever bodies they are mounted."""
    plain = spec.copy().compile()
    for joint in body.joints:
        wheel, number = spec.joint(joint).parent, int(plain.jnt_bodyid[plain.joint(joint).id])
        (_, y, _), axes = truth.placed(plain, int(plain.body_parentid[number]), plain.body_pos[number], truth.UNTURNED)
        wheel.pos = wheel.pos + (values["value"] - 1.0) * y * axes[1]


TRACK_WIDTH = _of_wheels(
    name="track_width",
    stage="loop",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.5, high=2.0, scale=0.05, domain=POSITIVE)),
    formula=r"b \to k\,b",
    summary="The wheels of an axle touch the floor further apart, or closer, than nominal.",
    confused_with="the radius of all wheels while the robot turns on the spot",
    shown_by="turns on the spot beside straight drives",
    fix="turn on the spot some times round, and set the width that makes the odometry agree in the model",
    inject=truth.editing(_widen),
    substitute=lambda equations, values, body: multiplied(equations, map(wheel_lever, body.joints), values["value"]),
    needs=(DRILLING,),
    searching=Searching(shown_in=lambda _: (Shown.BOTH_WAYS,)),
)


def _loosen(spec: Any, body: Body, values: Numbers) -> None:
    """Of what turns with the wheels; their own friction counts, whatever the floor's."""
    for joint in body.joints:
        for geom in spec.joint(joint).parent.geoms:
            geom.friction[0], geom.priority = values["value"], 1


WHEEL_GRIP = _of_wheels(
    name="wheel_grip",
    stage="loop",
    parameters=of_any_body(Parameter("value", "1", null=UNLIMITED, low=0.0, high=3.0, scale=0.1, domain=POSITIVE)),
    formula=r"|\tau| \le \mu\,N\,r",
    summary="Wheels spin or lock: the floor holds each by no more than a friction coefficient times its load.",
    confused_with="a rate limit or a lag of the wheels' commands, where few of these ask for more",
    shown_by="steps of the wheels' commands, small and large",
    fix="softer or wider tyres, more weight on the wheels, or commands that change more slowly",
    inject=truth.editing(_loosen),
    substitute=lambda equations, values, body: equations.substitute(
        {
            wheel_grip(wheel): values["value"] * body.number(wheel_load(wheel)) / Abs(symbol(rate_per_speed(wheel)))
            for wheel in body.joints
        }
    ),
    needs=(DRILLING,),
    searching=Searching(from_null=False, starts=lambda _body, _values: (0.05, 0.1, 0.2, 0.4, 0.8)),
)


def _carried_mass_parameters(body: Body) -> tuple[Parameter, ...]:
    mass, turning = body.numbers.get("mass", 1.0), body.numbers.get(TURNING_INERTIA, 1.0)
    reach = math.sqrt(turning / mass)
    sizes = (("mass", "kg", mass), ("moment", "kg m", mass * reach), ("inertia", "kg m²", turning))
    domains = {"mass": Domain(-mass, open=True), "inertia": Domain(-turning, open=True)}
    return tuple(
        Parameter(name, unit, 0.0, -0.5 * size, 2.0 * size, 0.1 * size, domain=domains.get(name, ANYTHING))
        for name, unit, size in sizes
    )


def _carry(spec: Any, body: Body, values: Numbers) -> None:
    """A body welded to the chassis, at the height of its origin."""
    mass = values["mass"]
    ahead = values["moment"] / mass if mass > 0 else math.nan
    own = values["inertia"] - mass * ahead**2
    if not own >= 0:
        actual = f"{mass:.4g} kg, {values['moment']:.4g} kg m and {values['inertia']:.4g} kg m²"
        raise ModelError(f"expected a mass, and an inertia of at least moment²/mass, to simulate, found {actual}")
    truth.weld(truth.free_body(spec), [ahead, 0.0, 0.0], mass, [0.5 * own, 0.5 * own, own])


CARRIED_MASS = _of_wheels(
    name="carried_mass",
    stage="mass",
    parameters=_carried_mass_parameters,
    formula=r"m \to m + \Delta m,\; m c_x \to m c_x + \Delta(m c_x),\; J \to J + \Delta J",
    summary="The robot carries a load, or is heavier than the nominal one.",
    confused_with="an armature of all wheels, or a lag of their commands",
    shown_by="steps of the speed, straight ahead and on the spot",
    fix="weigh the robot, and take the load into the description, with its mass where it lies",
    inject=truth.editing(_carry),
    of_joints="load",
    substitute=lambda equations, values, body: raised(
        raised(raised(equations, MASS_AHEAD, values["mass"]), MASS_MOMENT, values["moment"]),
        MASS_TURNING,
        values["inertia"],
    ),
    needs=(MASS_AHEAD, MASS_MOMENT, MASS_TURNING),
    numbers=("mass", TURNING_INERTIA),
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)


def _tilt(spec: Any, body: Body, values: Numbers) -> None:
    """Gravity tilted, or tilted further, its size unchanged."""
    tilted = np.add(spec.option.gravity[:2], [values["gx"], values["gy"]])
    spec.option.gravity = [*tilted, -np.sqrt(GRAVITY**2 - tilted @ tilted)]


SLOPE = _of_wheels(
    name="slope",
    stage="wrench",
    parameters=of_any_body(*several(("gx", "gy"), "m/s²", null=0.0, low=-3.0, high=3.0, scale=0.3)),
    formula=r"F = m\,g_{xy}",
    summary="The floor is not level.",
    confused_with="wind, always",
    shown_by="driving in all directions",
    fix="level the floor, or keep the term in the model",
    inject=truth.editing(_tilt),
    of_joints="gravity_tilt",
    substitute=lambda equations, values, body: apply_wrench(
        equations, body, force=(body.mass * values["gx"], body.mass * values["gy"])
    ),
    needs=("vx", "vy"),
    numbers=("mass",),
    searching=Searching(stood_for_by=lambda _: "wind"),
)


FRONT = 0.1  # m: wheels further ahead than this are the front axle


def _wheelbase_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    return equations.substitute({"steer": atan(tan(symbol("steer")) / values["value"])})


def _stretch(spec: Any, body: Body, values: Numbers) -> None:
    for wheel in spec.worldbody.first_body().bodies:
        if wheel.pos[0] > FRONT:
            wheel.pos = [values["value"] * wheel.pos[0], *list(wheel.pos)[1:]]


WHEELBASE = _of_wheels(
    name="wheelbase",
    stage="thrust",
    # Beyond what a ruler may be wrong by it is the steering's gain that is. Tuned: on real drives, of a car whose
    # steering has play, a learned base took 1.46.
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.7, high=1.4, scale=0.1, domain=POSITIVE)),
    formula=r"L \to k\,L",
    summary="The axles are further apart, or closer, than nominal.",
    confused_with="a steering gain, as long as steering angles are small",
    shown_by="small and large steering angles; better: a ruler",
    fix="measure the wheelbase and set it in the model",
    inject=truth.editing(_stretch),
    substitute=_wheelbase_substitute,
    needs=("steer",),
    searching=Searching(varying=("steer",), shown_in=lambda _: (Shown.BOTH_WAYS,)),
)


def _inertia(body: Body) -> float:
    return body.number("jz") + body.mass * body.number("centre") ** 2


def _yaw_drag_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    return apply_yaw_torque(equations, body, -values["value"] * _inertia(body) * symbol("wz"))


def _yaw_drag_brake(data: Any, body: Body, values: Numbers) -> None:
    truth.add_torque(data, np.array([0.0, 0.0, -values["value"] * _inertia(body) * truth.rates(data)[2]]))


YAW_DRAG = _of_wheels(
    name="yaw_drag",
    stage="wrench",
    parameters=of_any_body(Parameter("value", "1/s", null=0.0, low=0.0, high=50.0, scale=4.0)),
    formula=r"\tau_z = -c\,J\,\omega_z",
    summary="The car resists turning (scrubbing tyres); while the tyres hold, turns cost speed.",
    confused_with="lateral slip while the tyres hold; a steering gain or offset on one circle",
    shown_by="turns both ways at several speeds, beside straight driving",
    fix="free the differential or the steering's geometry, or keep the term in the model",
    inject=truth.with_force(_yaw_drag_brake),
    substitute=_yaw_drag_substitute,
    needs=("steer", "wz", *FORWARD),
    numbers=("mass", "wheelbase", "jz", "centre"),
    searching=Searching(shown_in=lambda _: (Shown.HARD,)),
)
