"""A constant torque about body axes."""

import numpy as np

from sym2real.effects.alike import ONE_TORQUE, ONE_TORQUE_AT_ONE_THRUST, Member
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.kind import Kind, Parameter
from sym2real.effects.truth import add_torque, pushing
from sym2real.effects.wrench import push

NAMES = ("tx", "ty", "tz")


def _parameters(body: Body) -> tuple[Parameter, ...]:
    # Sized as the weight at a tenth of a millimetre.
    scale = 1e-4 * GRAVITY * body.numbers.get("mass", 1.0)
    return tuple(Parameter(name, "N m", null=0.0, low=-100 * scale, high=100 * scale, scale=scale) for name in NAMES)


TORQUE_BIAS = Kind(
    name="torque_bias",
    stage="wrench",
    parameters=_parameters,
    formula=r"\tau = \mathrm{const}",
    summary="A constant torque turns the body.",
    confused_with="an offset of the rate commands, always; a centre of mass that is off where thrust hardly varies",
    shown_by="thrust that varies, against a centre of mass",
    fix="replace the weak motor or the bent propeller, or trim the mixer",
    inject=pushing(lambda data, body, values: add_torque(data, np.array([values[name] for name in NAMES]))),
    substitute=lambda equations, values, body: push(equations, body, torque=[values[name] for name in NAMES]),
    needs=("wx", "wy", "wz"),
    robot="quadrotor",
    alike=(Member(ONE_TORQUE, 0), Member(ONE_TORQUE_AT_ONE_THRUST, 1)),
    by_torque=lambda _: True,
)
