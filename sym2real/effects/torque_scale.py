"""Motors that turn the body by more or less than the model says: τ = (k_x τ_x, k_y τ_y, k_z τ_z).

What turns the body is torque over inertia, so that k_i is at once the factor on the lever (arm, reaction torque per
thrust) and the inverse of that on the inertia: no flight parts the two. Of published numbers of small robots the lever
about yaw is the least sure one, by an order of magnitude.
"""

from typing import Any

from sym2real.effects.body import Body
from sym2real.effects.domain import POSITIVE
from sym2real.effects.kind import Kind, Numbers, Parameter, of_any_body
from sym2real.effects.simulated_rotors import require_rotors, stands
from sym2real.effects.truth import editing
from sym2real.symbolic import symbol
from sym2real.vocabulary import MOTOR_COLUMNS, MOTOR_TORQUES

NAMES = ("kx", "ky", "kz")


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
    parameters=of_any_body(
        *(Parameter(name, "1", null=1.0, low=1e-3, high=1e3, scale=0.3, domain=POSITIVE) for name in NAMES)
    ),
    formula=r"\tau_i \to k_i\,\tau_i",
    summary="The motors turn the body by more or less than the model says: a lever or an inertia is another one.",
    confused_with="gains of all motors, which change the thrust as well; an inertia that is off is the same thing",
    shown_by="turns about all axes, to both sides: dither of the motors, each on its own",
    fix="set arm, reaction torque per thrust or inertia by this factor; a bifilar pendulum measures the inertia",
    inject=editing(_lengthen),
    substitute=lambda equations, values, body: equations.substitute(
        {torque: values[name] * symbol(torque) for name, torque in zip(NAMES, MOTOR_TORQUES, strict=True)}
    ),
    needs=("thrust", *MOTOR_TORQUES, "wx", "wy", "wz"),
    robot="quadrotor",
)
