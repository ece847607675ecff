r"""The robot holds another attitude than commanded.

``attitude_trim``. Its level, or its trim, is off by roll φ and then pitch θ. With δ that rotation, about the body's x
and then the new y::

    q_cmd → q_cmd ⊗ δ

The attitude that is measured is the robot's own, other than under a tilted sensor board (``mounting_tilt``).

``attitude_gain``. It leans by a multiple of the commanded lean. A command is a heading and then a lean about a
horizontal axis (its twist about z and the swing that is left), q_cmd = q_z ⊗ (w, x, y, 0)::

    x → k_roll x        y → k_pitch y        w → √(1 - x² - y²)
"""

from functools import partial

from sympy import sqrt

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.kind import POSITIVE, Kind, Values, of_any_body, several
from sym2real.effects.mountings import MOST, turned
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import ATTITUDE, ATTITUDE_COMMAND

_of_command = partial(Kind, stage="command", robot="quadrotor", needs=(*ATTITUDE_COMMAND.columns, *ATTITUDE.columns))


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    commanded = [symbol(column) for column in ATTITUDE_COMMAND.columns]
    held = turned(commanded, values["roll"], values["pitch"], 1)
    return equations.substitute(dict(zip(ATTITUDE_COMMAND.columns, held, strict=True)))


ATTITUDE_TRIM = _of_command(
    name="attitude_trim",
    parameters=of_any_body(*several(("roll", "pitch"), "rad", null=0.0, low=-MOST, high=MOST, scale=0.03)),
    formula=r"q_{cmd} \to q_{cmd} \otimes \delta",
    summary="The robot holds an attitude that is off by a constant angle from the commanded one.",
    confused_with="a tilted sensor board, where the attitude is not measured by another sensor than the loop's",
    shown_by="any flight whose attitude is measured",
    fix="set the trim of roll and pitch by minus these angles, or calibrate the level of the on-board estimator anew",
    inject=truth.of_attitude_commands("attitude_trim"),
    substitute=_substitute,
)


def _lean_more(equations: Equations, values: Values, body: Body) -> Equations:
    w, x, y, z = (symbol(column) for column in ATTITUDE_COMMAND.columns)
    length = sqrt(w**2 + z**2)
    roll, pitch = values["roll"] * (w * x + z * y) / length, values["pitch"] * (w * y - z * x) / length
    upright = sqrt(1 - roll**2 - pitch**2)
    held = (w * upright, w * roll - z * pitch, w * pitch + z * roll, z * upright)
    return equations.substitute(
        {name: part / length for name, part in zip(ATTITUDE_COMMAND.columns, held, strict=True)}
    )


ATTITUDE_GAIN = _of_command(
    name="attitude_gain",
    parameters=of_any_body(*several(("roll", "pitch"), "1", null=1.0, low=0.2, high=2.0, scale=0.1, domain=POSITIVE)),
    formula=r"(x, y) \to (k_\mathrm{roll} x, k_\mathrm{pitch} y)",
    summary="The robot leans by a multiple of the commanded roll or pitch.",
    confused_with="a lag, where commands change faster than the attitude follows",
    shown_by="leans that are held for several time constants of the attitude loop, to both sides",
    fix="correct the scale of the attitude commands by this factor (full stick, degrees per unit)",
    inject=truth.of_attitude_commands("attitude_gain"),
    substitute=_lean_more,
)
