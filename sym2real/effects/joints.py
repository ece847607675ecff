"""What brakes, pulls or loads the joints of a robot.

``joint_damping``. A joint is braked in proportion to its rate: τ = -d q̇.

``joint_friction``. Dry (Coulomb) friction of a joint: τ = -c sign(q̇), and what holds it where it stands.

``joint_stiffness``. A spring pulls a joint to where one of its description rests, else to its zero: τ = -k (q - q_0). A
cable or a hose, a flexure, a counterbalance.

``armature``. Inertia that turns or slides with a joint's motor: M_jj → M_jj + a.

``servo_gain``. The servo of a joint is stiffer or softer than its description says: k_p → s k_p of one that holds a
position, k_v → s k_v of one that holds a velocity.

``gravity_tilt``. The base stands askew: gravity is turned by small angles about the world's x and y axes.

``link_mass``. The link behind a joint weighs another multiple of what its description says, its inertia with it.

``load``. A point mass hangs at a site of the robot (a tool, a gripped part).
"""

from functools import partial
from math import inf
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
from sympy import cos, sin

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.kind import (
    NOT_NEGATIVE,
    POSITIVE,
    Domain,
    Kind,
    Numbers,
    Parameter,
    Values,
    of_any_body,
    several,
)
from sym2real.effects.searching import Searching
from sym2real.effects.terms import raised
from sym2real.effects.wrench import ALONE, INERTIA, altered, force_unit, inertia, multiplying, strength
from sym2real.inertias import write_inertia
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.dry_friction import USUAL_DECELERATION, dry_friction
from sym2real.trajectory import Array
from sym2real.vocabulary import GRAVITY_COMPONENTS, quantity_of, rate_column

_of_joint = partial(Kind, robot="robot with joints", columns="joint")

# Decay of a rate in one period: an Euler step swings up beyond 2, a Runge–Kutta step beyond 2.8, of which the
# description may take a half (``robots/runge_kutta.py``).
DECAY_IN_A_PERIOD = 1.4


# What a description of a joint says of the effect itself, of which a robot may have less, down to nothing.
BRAKING, FRICTION, STIFFNESS = "{column}_braking", "{column}_friction", "{column}_stiffness"


def _added(body: Body, described: str, unit: str, high: float, scale: float) -> tuple[Parameter, ...]:
    """What comes to that which a description has."""
    low = -body.numbers.get(described.format(column=body.column), 0.0)
    return (Parameter("value", unit, 0.0, low, high, scale, domain=Domain(low), low_is_likely=True),)


def _joint_damping_parameters(body: Body) -> tuple[Parameter, ...]:
    unit = "N m s" if body.unit == "rad" else "N s/m"
    # One that brakes in 3 s; at most in a tenth of one, or as fast as equations in periods can follow, beside as much
    # again as brakes the joint by its description.
    scale, described = inertia(body) / 3.0, body.numbers.get(BRAKING.format(column=body.column), 0.0)
    fast = DECAY_IN_A_PERIOD * body.numbers.get(ALONE.format(column=body.column), inertia(body)) / body.dt
    return _added(body, BRAKING, unit, max(30 * scale, fast) + described, scale)


def _joint_damping_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    joint, damping = body.column, values["value"]
    return altered(equations, body, "damping", damping, -damping * symbol(rate_column(joint)))


def _joint_damping_brake(spec: Any, body: Body, values: Numbers) -> None:
    """The damping that MuJoCo's joints have."""
    joint = spec.joint(body.column)
    joint.damping[0] += values["value"]  # of a polynomial in the rate


JOINT_DAMPING = _of_joint(
    name="joint_damping",
    stage="wrench",
    parameters=_joint_damping_parameters,
    formula=r"\tau = -d\,\dot q",
    summary="A joint is braked in proportion to its rate.",
    confused_with="dry friction at one speed; an actuator that loses force with speed",
    shown_by="slow and fast motion of the joint, both ways",
    fix="put the damping into the model; a thinner lubricant or a free bearing lowers it",
    inject=truth.editing(_joint_damping_brake),
    substitute=_joint_damping_substitute,
    needs=(rate_column("{column}"),),
    numbers=(INERTIA,),
)


# Shares of a description's own friction, and of the actuators' largest force, from which friction is searched: what is
# held where the robot slides has no slope; of one that sticks most of the time a step from none finds a damping, and
# one from half or one and a third of the truth leads there (tuned, on a stage that sticks).
LESS, MORE = (0.5, 0.1), (0.015, 0.04, 0.1)


def _joint_friction_parameters(body: Body) -> tuple[Parameter, ...]:
    scale = USUAL_DECELERATION * inertia(body)
    # A gear's may be large beside what a light link weighs, and not beside what drives it.
    most = max(30 * scale, strength(body))
    return _added(body, FRICTION, force_unit(body), most, scale)


def _starts(body: Body, _values: Array) -> tuple[float, ...]:
    most, described = strength(body), body.numbers.get(FRICTION.format(column=body.column), 0.0)
    less = tuple((share - 1.0) * described for share in LESS if described > 0)
    return (*(share * most for share in MORE if most > 0), *less)


def _joint_friction_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    joint, friction = body.column, values["value"]
    force, _ = dry_friction(friction, symbol(rate_column(joint)), equations.dt, inertia(body))
    return altered(equations, body, "friction", friction, force)


def _joint_friction_brake(spec: Any, body: Body, values: Numbers) -> None:
    """MuJoCo's frictionloss, a constraint that can hold a joint still."""
    joint = spec.joint(body.column)
    joint.frictionloss = joint.frictionloss + values["value"]


JOINT_FRICTION = _of_joint(
    name="joint_friction",
    stage="wrench",
    parameters=_joint_friction_parameters,
    formula=r"\tau = -c\,\mathrm{sign}(\dot q)",
    summary="A joint is braked by a constant force against its motion.",
    confused_with="damping at one speed; an offset of the actuator while the joint moves one way",
    shown_by="slow and fast motion of the joint, with reversals",
    fix="free the bearing or the gear, or compensate the friction in the actuator's loop",
    inject=truth.editing(_joint_friction_brake),
    substitute=_joint_friction_substitute,
    needs=(rate_column("{column}"),),
    numbers=(INERTIA,),
    searching=Searching(starts=_starts),
)


SWING_IN_A_PERIOD = 0.5  # rad of an oscillation that equations in periods of control follow


def _joint_stiffness_parameters(body: Body) -> tuple[Parameter, ...]:
    unit = "N m/rad" if body.unit == "rad" else "N/m"
    # One by which the joint swings at 1 rad/s; at most as fast as equations in periods can follow.
    lightest = body.numbers.get(ALONE.format(column=body.column), inertia(body))
    most = max(30 * inertia(body), lightest * (SWING_IN_A_PERIOD / body.dt) ** 2)
    return _added(body, STIFFNESS, unit, most, inertia(body))


def _joint_stiffness_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    """A force is held for a period: that of its middle, or what it comes too late by would count as damping -½ dt k.

    Equations that have a stiffness take more of it.
    """
    middle = symbol(body.column) + equations.dt / 2 * symbol(rate_column(body.column))
    rest = body.numbers.get(f"{body.column}_rest", 0.0)
    return altered(equations, body, "stiffness", values["value"], -values["value"] * (middle - rest))


def _pull(spec: Any, body: Body, values: Numbers) -> None:
    joint = spec.joint(body.column)
    joint.springref = joint.springref if joint.stiffness[0] else 0.0
    joint.stiffness[0] += values["value"]  # of a polynomial in the deflection


JOINT_STIFFNESS = _of_joint(
    name="joint_stiffness",
    stage="wrench",
    parameters=_joint_stiffness_parameters,
    formula=r"\tau = -k\,(q - q_0)",
    summary="A spring pulls a joint to its zero, or to where the joint's own spring rests.",
    confused_with="gravity on a link that hangs, in small motion; a servo's gain",
    shown_by="motion of the joint far to both sides of its zero",
    fix="put the spring into the model; free the cable, or take the counterbalance off",
    inject=truth.editing(_pull),
    substitute=_joint_stiffness_substitute,
    needs=("{column}", rate_column("{column}")),
    numbers=(INERTIA,),
)


OVERSTATED = 0.5  # part of it that a description may likely be too large by


def _armature_parameters(body: Body) -> tuple[Parameter, ...]:
    unit, scale = ("kg m²" if body.unit == "rad" else "kg"), 0.1 * inertia(body)
    # A description may overstate what turns with the joint, at most by all that a force along it moves while no other
    # joint is held: with less, the masses of the whole robot, in the pose it stands in, are not positive definite.
    most = body.numbers.get(ALONE.format(column=body.column), inf)
    low = -OVERSTATED * min(most, inertia(body))
    return (Parameter("value", unit, 0.0, low, 1000 * scale, scale, domain=Domain(-most, open=True)),)


def _more(spec: Any, body: Body, values: Numbers) -> None:
    """The armature that MuJoCo's joints have."""
    spec.joint(body.column).armature += values["value"]


ARMATURE = _of_joint(
    name="armature",
    stage="mass",
    parameters=_armature_parameters,
    formula=r"M_{jj} \to M_{jj} + a",
    summary="The rotor and the gear of a motor add inertia to its joint.",
    confused_with="a weaker actuator, where nothing but the actuator moves the joint; a load",
    shown_by="fast and slow changes of the command, and motion that gravity drives",
    fix="put the rotor's inertia times the squared gear ratio into the model; less than nothing, or beside a gain: "
    "the mass of what the joint moves may be wrong in the description",
    inject=truth.editing(_more),
    substitute=lambda equations, values, body: raised(equations, quantity_of("armature", body.column), values["value"]),
    needs=(quantity_of("armature", "{column}"),),
)


def _heavier(spec: Any, body: Body, values: Numbers) -> None:
    """Mass and inertia of the body that the joint moves, and of those that are fixed to it."""
    model = spec.compile()
    for fixed in truth.link_of(model, body.column)[1]:
        write_inertia(spec.bodies[fixed], model, values["value"])


LINK_MASS = _of_joint(
    name="link_mass",
    stage="mass",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.3, high=3.0, scale=0.1, domain=POSITIVE)),
    formula=r"m_j \to \kappa\,m_j,\quad J_j \to \kappa\,J_j",
    summary="A link weighs more or less than its description says.",
    confused_with="an armature, where gravity does not act on the joint; a gain of its actuator beside one",
    shown_by="several postures, and fast motion",
    fix="weigh the link, and put its mass into the description",
    inject=truth.editing(_heavier),
    substitute=multiplying("link_mass"),
    needs=(quantity_of("link_mass", "{column}"),),
)


def _stiffer(spec: Any, body: Body, values: Numbers) -> None:
    """What a servo's force is of its command, and of what it holds against that."""
    for servo in (actuator for actuator in spec.actuators if actuator.target == body.column):
        gain, bias = servo.gainprm[0], servo.biasprm
        held = [place for place in (1, 2) if bias[place] and np.isclose(bias[place], -gain)]
        for place in held[:1]:  # a position, else a rate
            servo.gainprm[0], bias[place] = gain * values["value"], bias[place] * values["value"]


SERVO_GAIN = _of_joint(
    name="servo_gain",
    stage="mass",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.1, high=2.0, scale=0.1, domain=POSITIVE)),
    formula=r"k_p \to s\,k_p,\quad k_v \to s\,k_v",
    summary="The servo of a joint is stiffer or softer than its description says, in what it holds: place or rate.",
    confused_with="an armature or a load in fast motion alone; a spring beside a gain of the command",
    shown_by="steps of the command, and postures that gravity loads",
    fix="set the servo's gain in the description (kp of a position actuator, kv of a velocity one)",
    inject=truth.editing(_stiffer),
    substitute=multiplying("servo_gain"),
    needs=(quantity_of("servo_gain", "{column}"),),
)


def _gravity_tilt_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    """Gravity in the axes of a base that is pitched, then rolled in its own."""
    x, y, z = (symbol(name) for name in GRAVITY_COMPONENTS)
    roll, pitch = values["roll"], values["pitch"]
    level = x * cos(pitch) - z * sin(pitch)
    down = x * sin(pitch) + z * cos(pitch)
    turned = (level, y * cos(roll) + down * sin(roll), down * cos(roll) - y * sin(roll))
    return equations.substitute(dict(zip(GRAVITY_COMPONENTS, turned, strict=True)))


def _turn(spec: Any, body: Body, values: Numbers) -> None:
    """Gravity in the axes of a base that is pitched, then rolled in its own."""
    base = Rotation.from_euler("YX", [values["pitch"], values["roll"]])
    spec.option.gravity = base.inv().apply(spec.option.gravity)


GRAVITY_TILT = Kind(
    name="gravity_tilt",
    stage="mass",
    parameters=of_any_body(*several(("roll", "pitch"), "rad", null=0.0, low=-0.5, high=0.5, scale=0.03)),
    formula=r"g \to R_x(\phi)^T R_y(\theta)^T g",
    summary="The robot's base stands askew, so that gravity pulls from another side.",
    confused_with="an offset of the actuators in one posture",
    shown_by="several postures",
    fix="level the base, or tell the model how it stands",
    inject=truth.editing(_turn),
    substitute=_gravity_tilt_substitute,
    needs=GRAVITY_COMPONENTS,
    robot="robot with joints",
)


POINT = 1e-9  # m²: squared radius of gyration of what MuJoCo takes for a point


def _load_parameters(body: Body) -> tuple[Parameter, ...]:
    scale = 0.05 * body.numbers.get("mass", 1.0)
    return (Parameter("value", "kg", null=0.0, low=0.0, high=20 * scale, scale=scale, domain=NOT_NEGATIVE),)


def _hang(spec: Any, body: Body, values: Numbers) -> None:
    """A body of that mass, fixed where the site is."""
    site, mass = spec.site(body.column), values["value"]
    between = np.reshape(site.fromto, (2, 3)).mean(0)  # NaN for a site that is given by its place
    place = site.pos if np.isnan(between).any() else between
    hanging = truth.weld(site.parent, place, mass, [POINT * mass] * 3)
    if site.frame is not None:
        hanging.set_frame(site.frame)


LOAD = Kind(
    name="load",
    stage="mass",
    parameters=_load_parameters,
    formula=r"m_\mathrm{site} \to m_\mathrm{site} + m",
    summary="A mass hangs at a point of the robot that the model does not know of.",
    confused_with="weaker actuators in one posture; an armature where gravity does not act on the joints",
    shown_by="several postures, and fast motion",
    fix="put the tool or the part into the description, with its mass where it hangs",
    inject=truth.editing(_hang),
    substitute=lambda equations, values, body: raised(equations, quantity_of("load", body.column), values["value"]),
    needs=(quantity_of("load", "{column}"),),
    robot="robot with joints",
    columns="site",
)
