"""A sensor board that is mounted at an angle: attitude, rates and rate commands are those of the tilted board.

The board's axes are the body's turned by roll φ about x, then by pitch θ about the new y. With δ that rotation::

    q_measured = q ⊗ δ        ω_measured = δ⁻¹ ω        ω_cmd = δ ω_cmd, sent
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation
from sympy import Expr, cos, sin

from sym2real.effects.alike import ONE_LEAN, Member
from sym2real.effects.body import Body
from sym2real.effects.frames import QUATERNION
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.measured import reported, reporting
from sym2real.effects.searching import Searching, Shown
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.quaternions import multiply
from sym2real.trajectory import Array

RATES, COMMANDS = ("wx", "wy", "wz"), ("wx_cmd", "wy_cmd", "wz_cmd")
# Boards are screwed down flat and markers aligned by eye: beyond 6° somebody would have seen it, and what looks like
# more is a force.
MOST = 0.1
ATTITUDE_COMMANDS = ("qw_cmd", "qx_cmd", "qy_cmd", "qz_cmd")


def _matrix(roll: Expr, pitch: Expr) -> list[list[Expr]]:
    """δ as a matrix: rows are body axes."""
    return [
        [cos(pitch), 0 * pitch, sin(pitch)],
        [sin(roll) * sin(pitch), cos(roll), -sin(roll) * cos(pitch)],
        [-cos(roll) * sin(pitch), sin(roll), cos(roll) * cos(pitch)],
    ]


def turned(quaternion: Sequence[Expr], roll: Expr, pitch: Expr, sign: int) -> tuple[Expr, ...]:
    """q ⊗ δ, or q ⊗ δ⁻¹ for a sign of -1."""
    x, y, z = sin(roll / 2) * cos(pitch / 2), cos(roll / 2) * sin(pitch / 2), sin(roll / 2) * sin(pitch / 2)
    return multiply(quaternion, (cos(roll / 2) * cos(pitch / 2), sign * x, sign * y, sign * z))


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    roll, pitch = values["roll"], values["pitch"]
    changes: dict[str, Expr] = {}
    for names in (QUATERNION, ATTITUDE_COMMANDS):
        if names[0] in body.names and names[0] not in body.layouts.state:  # measured on the way in
            changes |= dict(zip(names, turned([symbol(name) for name in names], roll, pitch, -1), strict=True))
    if COMMANDS[0] in body.names:
        rows = _matrix(roll, pitch)
        changes |= {
            name: sum(a * symbol(sent) for a, sent in zip(row, COMMANDS, strict=True))
            for name, row in zip(COMMANDS, rows, strict=True)
        }
    return reporting(equations.substitute(changes), _outputs(equations, roll, pitch))


def _outputs(equations: Equations, roll: Expr, pitch: Expr) -> dict[str, Expr]:
    outputs: dict[str, Expr] = {}
    if QUATERNION[0] in equations.next:
        quaternion = [reported(equations, name) for name in QUATERNION]
        outputs |= dict(zip(QUATERNION, turned(quaternion, roll, pitch, 1), strict=True))
    if RATES[0] in equations.next:
        for name, column in zip(RATES, zip(*_matrix(roll, pitch), strict=True), strict=True):
            outputs[name] = sum(a * reported(equations, rate) for a, rate in zip(column, RATES, strict=True))
    return outputs


def _inject(body: Body, values: Numbers) -> Change:
    board = Rotation.from_euler("XY", [values["roll"], values["pitch"]])
    layout = body.layouts.state
    attitude, rates = layout.indices(QUATERNION), layout.indices(RATES)

    def command(action: Array) -> Array:
        result, commands = action.copy(), body.layouts.action.indices(COMMANDS)
        result[commands] = board.apply(action[commands])
        return result

    def report(state: Array) -> Array:
        result = state.copy()
        turned = np.roll((Rotation.from_quat(np.roll(state[attitude], -1)) * board).as_quat(), 1)
        result[attitude] = turned if turned @ state[attitude] >= 0 else -turned
        result[rates] = board.inv().apply(state[rates])
        return result

    looped = COMMANDS[0] in body.layouts.action  # motors of their own are not told in the board's axes
    return Change("", command=(lambda: command) if looped else None, measure=lambda: report)


MOUNTING_TILT = Kind(
    name="mounting_tilt",
    stage="measurement",
    parameters=of_any_body(
        *(Parameter(name, "rad", null=0.0, low=-MOST, high=MOST, scale=0.03) for name in ("roll", "pitch"))
    ),
    formula=r"q_m = q \otimes \delta, \quad \omega_m = \delta^{-1}\omega",
    summary="The sensor board is mounted at an angle to the thrust line.",
    confused_with="wind, while yaw stays",
    shown_by="yaw that turns at 0.5 to 0.8 rad/s",
    fix="level the board, set the trim of roll and pitch, or redo the rigid body's zero in the motion capture",
    inject=_inject,
    of_joints="gravity_tilt",
    substitute=_substitute,
    needs=QUATERNION,
    robot="quadrotor",
    alike=(Member(ONE_LEAN, 1),),
    searching=Searching(shown_in=lambda _: (Shown.YAW,)),
)
