"""The on-board rate loop is stiffer or softer than nominal: ω̇ = k K (ω_cmd - ω) + τ/J.

The torque that is put in makes the rate at the end of a step that of the changed loop, exactly.
"""

from typing import Any

from sym2real.effects.body import Body
from sym2real.effects.domain import POSITIVE
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.manoeuvres import EXCITED
from sym2real.effects.rate_loop import NUMBERS, other_torque, rate_loops
from sym2real.effects.truth import editing
from sym2real.effects.wrench import push
from sym2real.symbolic import Equations

LOOPS = ("wx", "wy", "wz")


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    loops = rate_loops(body, equations.dt)
    torque = [loop.with_gain(values["value"], 1.0, other_torque(equations, loop.axis)) for loop in loops]
    return push(equations, body, torque=torque)


def _stiffen(spec: Any, body: Body, values: Numbers) -> None:
    for actuator in spec.actuators:
        if actuator.name in LOOPS:
            actuator.gainprm = [values["value"] * number for number in actuator.gainprm]
            actuator.biasprm = [values["value"] * number for number in actuator.biasprm]


RATE_LOOP_GAIN = Kind(
    name="rate_loop_gain",
    stage="loop",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.1, high=5.0, scale=0.2, domain=POSITIVE)),
    formula=r"\tau = k\,J K\,(\omega_\mathrm{cmd} - \omega)",
    summary="The on-board rate loop is stiffer or softer than the nominal one.",
    confused_with="an inertia that is off, always; motor lag or delay in hover",
    shown_by=EXCITED,
    fix="set the rate loop's gain in the firmware, or in the model (`nominal quadrotor --rate-gains`)",
    inject=editing(_stiffen),
    substitute=_substitute,
    needs=("wx_cmd", "wy_cmd", "wz_cmd", "wx", "wy", "wz"),
    numbers=NUMBERS,
    robot="quadrotor",
    nuisance=(0.8, 1.25),
)
