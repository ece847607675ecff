"""Forces along a joint that no description of one has.

``joint_drag``. A fluid brakes a joint in proportion to the square of its rate: τ = -d q̇|q̇|.

``joint_bias``. A constant force pulls along a joint: a cable, a preload.

``torque_ripple``. The cogging of a motor's magnets, its commutation, a gear or a screw that is out of round:
τ = a sin(n q) + b cos(n q), n times in a turn.

``stribeck``. Dry friction that is larger at low speed, where the lubricant does not carry yet: as a joint begins
to slide, c + s exp(-(q̇/v)²) goes to c (B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, "A survey of models,
analysis tools and compensation methods for the control of machines with friction", Automatica 30 (1994) 1083–1138).

``servo_limit``. A servo gives no more than so much force, as its current or its supply allows: |τ| ≤ τ_max. So does the
floor under a wheel that slips: what a servo asks for beyond μ N r spins the wheel.
"""

from functools import partial
from typing import Any

import numpy as np
from sympy import Abs, cos, exp, sin

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.kind import NOT_NEGATIVE, POSITIVE, Kind, Numbers, Parameter, Values, several
from sym2real.effects.searching import LATER, Searching
from sym2real.effects.terms import raised
from sym2real.effects.wrench import INERTIA, altered, apply_joint_force, force_unit, inertia, strength
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.dry_friction import USUAL_DECELERATION
from sym2real.vocabulary import UNLIMITED, quantity_of, rate_column

_of_joint = partial(Kind, stage="wrench", robot="robot with joints", columns="joint", numbers=(INERTIA,))

DRIVEN = "the offset of the joint's actuator stands for it"
MOST = 1000.0  # times in a turn, or rad a metre, that are likely


def _drag_parameters(body: Body) -> tuple[Parameter, ...]:
    """One that brakes 1 rad/s or 1 m/s in 3 s; at most in a tenth of a second."""
    unit, scale = ("N m s²" if body.unit == "rad" else "N s²/m²"), inertia(body) / 3.0
    return (Parameter("value", unit, 0.0, 0.0, 30 * scale, scale, domain=NOT_NEGATIVE),)


def _drag_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    """Of equations that know none, a damping that goes by the rate, and is held for a period."""
    if (drag := quantity_of("drag", body.column)) in equations.quantities:
        return raised(equations, drag, values["value"])
    rate = symbol(rate_column(body.column))
    damping = values["value"] * Abs(rate)
    return altered(equations, body, "damping", damping, -damping * rate)


def _drag(spec: Any, body: Body, values: Numbers) -> None:
    """The second coefficient of the damping that MuJoCo's joints have."""
    spec.joint(body.column).damping[1] += values["value"]


JOINT_DRAG = _of_joint(
    name="joint_drag",
    parameters=_drag_parameters,
    formula=r"\tau = -d\,\dot q\,|\dot q|",
    summary="A fluid brakes a joint in proportion to the square of its rate: air, water, oil.",
    confused_with="damping at one speed",
    shown_by="slow and fast motion of the joint, both ways",
    fix="put the drag into the model",
    inject=truth.editing(_drag),
    substitute=_drag_substitute,
    needs=(rate_column("{column}"),),
)


def _forces(body: Body, *names: str) -> tuple[Parameter, ...]:
    """Forces or torques along a joint, of either sign."""
    scale = USUAL_DECELERATION * inertia(body)
    most = max(30 * scale, strength(body))
    return several(names, force_unit(body), null=0.0, low=-most, high=most, scale=scale)


def _pull(data: Any, body: Body, values: Numbers) -> None:
    data.joint(body.column).qfrc_applied[0] += values["value"]


JOINT_BIAS = _of_joint(
    name="joint_bias",
    parameters=lambda body: _forces(body, "value"),
    formula=r"\tau = b",
    summary="A constant force pulls along a joint.",
    confused_with="a base that stands askew, in one posture; an offset of what else moves the joint",
    shown_by="several postures",
    fix="find what pulls (a cable, a spring that is preloaded), or put the force into the model",
    inject=truth.with_force(_pull),
    substitute=lambda equations, values, body: apply_joint_force(equations, body, values["value"]),
    needs=(rate_column("{column}"),),
    searching=Searching(why_not=lambda body: DRIVEN if strength(body) else ""),
)


def _ripple_parameters(body: Body) -> tuple[Parameter, ...]:
    unit = "1" if body.unit == "rad" else "rad/m"
    count = Parameter("count", unit, 1.0, 0.1, MOST, 1.0, domain=POSITIVE, acts_alone=False)
    return (count, *_forces(body, "sine", "cosine"))


def _ripple_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    """A force is held for a period: that of its middle, or what it comes too late by would count as damping."""
    angle = values["count"] * (symbol(body.column) + equations.dt / 2 * symbol(rate_column(body.column)))
    return apply_joint_force(equations, body, values["sine"] * sin(angle) + values["cosine"] * cos(angle))


def _ripple(data: Any, body: Body, values: Numbers) -> None:
    joint = data.joint(body.column)
    angle = values["count"] * joint.qpos[0]
    joint.qfrc_applied[0] += values["sine"] * np.sin(angle) + values["cosine"] * np.cos(angle)


TORQUE_RIPPLE = _of_joint(
    name="torque_ripple",
    parameters=_ripple_parameters,
    formula=r"\tau = a \sin(n q) + b \cos(n q)",
    summary="A force along a joint rises and falls as it moves, so many times in a turn: cogging, a gear out of round.",
    confused_with="gusts, or whatever else disturbs the joint, where few of its periods are passed",
    shown_by="slow motion of the joint over many of its periods, both ways",
    fix="compensate it by the joint's angle, or look for the gear's tooth or the motor's poles that count so many",
    inject=truth.with_force(_ripple),
    substitute=_ripple_substitute,
    needs=("{column}", rate_column("{column}")),
    searching=Searching(from_null=False, repeats=True),
)


def _stribeck_parameters(body: Body) -> tuple[Parameter, ...]:
    scale = USUAL_DECELERATION * inertia(body)
    size = Parameter("value", force_unit(body), 0.0, 0.0, max(30 * scale, strength(body)), scale)
    speed = Parameter("speed", f"{body.unit}/s", 0.1, 1e-3, 10.0, 0.1, domain=POSITIVE, acts_alone=False)
    return (size, speed)


def _stribeck_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    """The friction of the rate at the period's start."""
    more = values["value"] * exp(-((symbol(rate_column(body.column)) / values["speed"]) ** 2))
    return raised(equations, quantity_of("friction", body.column), more)


def _stick(body: Body, values: Numbers) -> Change:
    """The bound of MuJoCo's friction loss, set anew at every step."""
    described = f"{body.column}_friction"

    def edit(spec: Any) -> None:
        spec.add_numeric(name=described, size=1, data=[spec.joint(body.column).frictionloss])

    def set_bound(model: Any, data: Any) -> None:
        more = values["value"] * np.exp(-((data.joint(body.column).qvel[0] / values["speed"]) ** 2))
        model.dof_frictionloss[model.joint(body.column).dofadr] = model.numeric(described).data[0] + more

    return Change("", edit=edit, force=set_bound)


STRIBECK = _of_joint(
    name="stribeck",
    parameters=_stribeck_parameters,
    formula=r"\tau = -s\,e^{-(\dot q/v)^2}\,\mathrm{sign}(\dot q)",
    summary="Dry friction is larger where a joint starts to slide than where it slides.",
    confused_with="dry friction, where the joint moves at one speed; a lag of its motor's command",
    shown_by="slow motion of the joint with reversals, beside fast",
    fix="compensate it in the actuator's loop, dither the command, or another lubricant",
    inject=_stick,
    substitute=_stribeck_substitute,
    needs=(quantity_of("friction", "{column}"), rate_column("{column}")),
    searching=Searching(why_not=lambda _: LATER),
)

# Parts of what a servo asks for at its largest command, from which a search starts.
PARTS_OF_STRENGTH = (0.05, 0.1, 0.2, 0.4, 0.8)


def _limit_parameters(body: Body) -> tuple[Parameter, ...]:
    most = strength(body)
    return (Parameter("value", force_unit(body), UNLIMITED, 0.0, most, most / 10, domain=POSITIVE),)


def _weaken(spec: Any, body: Body, values: Numbers) -> None:
    joint = spec.joint(body.column)
    joint.actfrclimited, joint.actfrcrange = True, [-values["value"], values["value"]]


SERVO_LIMIT = _of_joint(
    name="servo_limit",
    stage="mass",
    parameters=_limit_parameters,
    formula=r"|\tau| \le \tau_\mathrm{max}",
    summary="The servo of a joint, or the floor under its wheel, gives no more than so much force.",
    confused_with="a rate limit or a lag of its command, where few of its commands ask for more",
    shown_by="steps of the command, small and large",
    fix="raise the servo's limit of current, or put it into the description (forcerange); more grip under a wheel",
    inject=truth.editing(_weaken),
    substitute=lambda equations, values, body: equations.substitute(
        {quantity_of("servo_limit", body.column): values["value"]}
    ),
    needs=(quantity_of("servo_limit", "{column}"),),
    searching=Searching(
        why_not=lambda _: LATER,
        from_null=False,
        starts=lambda body, _values: tuple(part * strength(body) for part in PARTS_OF_STRENGTH),
    ),
)
