"""The robot holds another attitude than commanded: its level, or its trim, is off by roll φ and then pitch θ.

With δ that rotation, about the body's x and then the new y::

    q_cmd → q_cmd ⊗ δ

The attitude that is measured is the robot's own, other than under a tilted sensor board (``mounting_tilt``).
"""

from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.mountings import MOST, turned
from sym2real.errors import ModelError
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import ATTITUDE, ATTITUDE_COMMAND


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    commanded = [symbol(column) for column in ATTITUDE_COMMAND.columns]
    held = turned(commanded, values["roll"], values["pitch"], 1)
    return equations.substitute(dict(zip(ATTITUDE_COMMAND.columns, held, strict=True)))


def _inject(body: Body, values: Numbers) -> Change:
    raise ModelError("attitude_trim: no simulated robot here is commanded an attitude")


ATTITUDE_TRIM = Kind(
    name="attitude_trim",
    stage="command",
    parameters=of_any_body(
        *(Parameter(name, "rad", null=0.0, low=-MOST, high=MOST, scale=0.03) for name in ("roll", "pitch"))
    ),
    formula=r"q_{cmd} \to q_{cmd} \otimes \delta",
    summary="The robot holds an attitude that is off by a constant angle from the commanded one.",
    confused_with="a tilted sensor board, where the attitude is not measured by another sensor than the loop's",
    shown_by="any flight whose attitude is measured",
    fix="set the trim of roll and pitch by minus these angles, or calibrate the level of the on-board estimator anew",
    inject=_inject,
    substitute=_substitute,
    needs=(*ATTITUDE_COMMAND.columns, *ATTITUDE.columns),
    robot="quadrotor",
)
