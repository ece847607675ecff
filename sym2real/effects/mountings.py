"""Sensors that sit askew or elsewhere than the model takes them to be.

``mounting_tilt``. A sensor board that is mounted at an angle: attitude, rates and rate commands are those of the tilted
board.

The board's axes are the body's turned by roll φ about x, then by pitch θ about the new y. With δ that rotation::

    q_measured = q ⊗ δ        ω_measured = δ⁻¹ ω        ω_cmd = δ ω_cmd, sent

``marker_tilt``. The attitude alone is that of tilted axes, as of markers that were not put on straight, beside a gyro
that was: q_measured = q ⊗ δ.

``yaw_bias``. Measured yaw is off by a constant: ψ_measured = ψ + b. Of an attitude q_measured = R_z(b) ⊗ q, so that
a force on the robot seems to act elsewhere.

``mounting_yaw``. The measured attitude's axes are turned about the body's z against those of gyro and commands:
q_measured = q ⊗ R_z(b), as of markers that were not put on straight.

``lever_arm``. The measured point is not the centre of mass, or the middle of a car's rear axle: p_measured = p + R r,
v_measured = v + R (ω × r).
"""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation
from sympy import Expr, Integer, cos, sin

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.frames import HEADING, QUATERNION, to_world, velocity
from sym2real.effects.kind import Inject, Kind, Numbers, Parameter, Values, of_any_body, several
from sym2real.effects.manoeuvres import single_circle
from sym2real.effects.searching import LATER, Searching, Shown
from sym2real.effects.terms import reported, reporting
from sym2real.protocols import Change
from sym2real.rotation import product
from sym2real.symbolic import Equations, symbol
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import ATTITUDE_COMMAND, POSITION, RATE, RATE_COMMAND, VELOCITY

RATES, COMMANDS = RATE.columns, RATE_COMMAND.columns
# Boards are screwed down flat and markers aligned by eye: beyond 6° somebody would have seen it, and what looks like
# more is a force.
MOST = 0.1
ATTITUDE_COMMANDS = ATTITUDE_COMMAND.columns
ARM = ("rx", "ry", "rz")
MOST_ASIDE = 0.3  # m: markers stand on the robot
Turn = Callable[[Sequence[Expr], int], tuple[Expr, ...]]  # a quaternion, and 1 or -1 for the way back


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
    return product(quaternion, (cos(roll / 2) * cos(pitch / 2), sign * x, sign * y, sign * z))


def _attitude_turned(equations: Equations, body: Body, turn: Turn) -> Equations:
    """Equations of an attitude that is measured, and commanded, turned by ``turn(quaternion, 1)``."""
    changes, outputs = dict[str, Expr](), dict[str, Expr]()
    for names in (QUATERNION, ATTITUDE_COMMANDS):
        if names[0] in body.names and names[0] not in body.layouts.state:  # measured on the way in
            changes |= dict(zip(names, turn([symbol(name) for name in names], -1), strict=True))
    if QUATERNION[0] in equations.next:
        outputs = dict(zip(QUATERNION, turn([reported(equations, name) for name in QUATERNION], 1), strict=True))
    return reporting(equations.substitute(changes), outputs)


def _marker_tilt_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    roll, pitch = values["roll"], values["pitch"]
    return _attitude_turned(equations, body, lambda quaternion, sign: turned(quaternion, roll, pitch, sign))


def _mounting_tilt_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    roll, pitch, equations = values["roll"], values["pitch"], _marker_tilt_substitute(equations, values, body)
    changes, outputs = dict[str, Expr](), dict[str, Expr]()
    if COMMANDS[0] in body.names:
        rows = _matrix(roll, pitch)
        changes |= {
            name: sum(a * symbol(sent) for a, sent in zip(row, COMMANDS, strict=True))
            for name, row in zip(COMMANDS, rows, strict=True)
        }
    if RATES[0] in equations.next:
        for name, column in zip(RATES, zip(*_matrix(roll, pitch), strict=True), strict=True):
            outputs[name] = sum(a * reported(equations, rate) for a, rate in zip(column, RATES, strict=True))
    return reporting(equations.substitute(changes), outputs)


def _measured(quaternion: Array, turn: Callable[[Rotation], Rotation]) -> Array:
    """What a turned sensor reports in place of an attitude ``# (4,)``, with the sign that the attitude has."""
    measured: Array = turn(Rotation.from_quat(quaternion, scalar_first=True)).as_quat(scalar_first=True)
    return measured if measured @ quaternion >= 0 else -measured


def _tilted(values: Numbers) -> Rotation:
    return Rotation.from_euler("XY", [values["roll"], values["pitch"]])


def _inject(body: Body, values: Numbers) -> Change:
    board = _tilted(values)
    layout = body.layouts.state
    attitude, rates = layout.indices(QUATERNION), layout.indices(RATES)

    def command(action: Array) -> Array:
        result, commands = action.copy(), body.layouts.action.indices(COMMANDS)
        result[commands] = board.apply(action[commands])
        return result

    def report(state: Array) -> Array:
        result = state.copy()
        result[attitude] = _measured(state[attitude], lambda rotation: rotation * board)
        result[rates] = board.inv().apply(state[rates])
        return result

    looped = COMMANDS[0] in body.layouts.action  # motors of their own are not commanded in the board's axes
    return Change("", command=(lambda: command) if looped else None, measure=lambda: report)


_tilt = partial(
    Kind,
    stage="measurement",
    parameters=of_any_body(*several(("roll", "pitch"), "rad", null=0.0, low=-MOST, high=MOST, scale=0.03)),
    robot="quadrotor",
)
MOUNTING_TILT = _tilt(
    name="mounting_tilt",
    formula=r"q_m = q \otimes \delta, \quad \omega_m = \delta^{-1}\omega",
    summary="The sensor board is mounted at an angle to the thrust line.",
    confused_with="wind, while yaw stays",
    shown_by="yaw that turns at 0.5 to 0.8 rad/s",
    fix="level the board, set the trim of roll and pitch, or redo the rigid body's zero in the motion capture",
    inject=_inject,
    of_joints="gravity_tilt",
    substitute=_mounting_tilt_substitute,
    needs=QUATERNION,
    searching=Searching(shown_in=lambda _: (Shown.YAW,)),
)


def _about_z(angle: Expr, sign: int) -> tuple[Expr, ...]:
    return cos(angle / 2), Integer(0), Integer(0), sign * sin(angle / 2)


def _mounting_yaw_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    angle = values["value"]
    return _attitude_turned(equations, body, lambda quaternion, sign: product(quaternion, _about_z(angle, sign)))


def _attitude_report(
    turn: Callable[[Rotation, Rotation], Rotation],
    by: Callable[[Numbers], Rotation] = lambda values: Rotation.from_euler("Z", values["value"]),
) -> Inject:
    """The truth of an attitude that is measured turned: attitude and turn → what is measured."""

    def report(state: Array, body: Body, values: Numbers) -> Array:
        places, by_that = body.layouts.state.indices(QUATERNION), by(values)
        state[places] = _measured(state[places], lambda attitude: turn(attitude, by_that))
        return state

    return truth.measuring(report)


MARKER_TILT = _tilt(
    name="marker_tilt",
    formula=r"q_m = q \otimes \delta",
    summary="The measured attitude's axes are tilted against the thrust line and against those of gyro and commands.",
    confused_with="mounting_tilt in slow turns; wind, while yaw stays",
    shown_by="fast turns about every axis",
    fix="redo the rigid body's zero in the motion capture with the robot level",
    inject=_attitude_report(lambda attitude, tilt: attitude * tilt, _tilted),
    substitute=_marker_tilt_substitute,
    needs=(*QUATERNION, *RATES),
    # Slow turns do not tell it from a board that is tilted, which flies alike.
    searching=Searching(why_not=lambda _: LATER, shown_in=lambda _: (Shown.YAW,)),
)
_of_an_angle = partial(
    Kind,
    stage="measurement",
    parameters=of_any_body(Parameter("value", "rad", null=0.0, low=-math.pi, high=math.pi, scale=0.05)),
)
MOUNTING_YAW = _of_an_angle(
    name="mounting_yaw",
    formula=r"q_m = q \otimes R_z(b)",
    summary="The measured attitude's axes are turned about the body's z axis against those of gyro and commands.",
    confused_with="nothing, where rates about x and y are measured",
    shown_by="turns about x and y",
    fix="turn the rigid body's axes in the motion capture by minus this angle",
    inject=_attitude_report(lambda attitude, turn: attitude * turn),
    substitute=_mounting_yaw_substitute,
    needs=(*QUATERNION, *RATES),
    robot="quadrotor",
)


def _yaw_bias_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    if not body.planar:
        angle = values["value"]
        return _attitude_turned(equations, body, lambda quaternion, sign: product(_about_z(angle, sign), quaternion))
    sine, cosine = (reported(equations, name) for name in HEADING)
    turn_s, turn_c = sin(values["value"]), cos(values["value"])
    turned = {"sin_yaw": sine * turn_c + cosine * turn_s, "cos_yaw": cosine * turn_c - sine * turn_s}
    return reporting(equations, turned)


def _heading_report(state: Array, body: Body, values: Numbers) -> Array:
    places = body.layouts.state.indices(HEADING)
    yaw = np.arctan2(*state[places]) + values["value"]
    state[places] = np.sin(yaw), np.cos(yaw)
    return state


def _yaw_bias_inject(body: Body, values: Numbers) -> Change:
    attitude = _attitude_report(lambda attitude, turn: turn * attitude)
    return (truth.measuring(_heading_report) if body.planar else attitude)(body, values)


YAW_BIAS = _of_an_angle(
    name="yaw_bias",
    formula=r"\psi_m = \psi + b",
    summary="The measured heading is off by a constant angle.",
    confused_with="a lever arm of the markers on one circle",
    shown_by="straight driving beside turns both ways; flights that tilt along several directions",
    fix="turn the rigid body's axes in the motion capture, or the estimator's north, by minus this angle",
    inject=_yaw_bias_inject,
    substitute=_yaw_bias_substitute,
    needs=("{heading}",),
    searching=Searching(shown_in=lambda _: (Shown.BOTH_WAYS,)),
)


def _parameters(body: Body) -> tuple[Parameter, ...]:
    """What is measured is a point of the robot: of a car a wheelbase ahead or behind, half of one aside."""
    if not body.planar:
        return several(ARM, "m", null=0.0, low=-MOST_ASIDE, high=MOST_ASIDE, scale=0.03)
    longest = body.numbers.get("wheelbase", 1.0)
    bounds = {"rx": longest, "ry": longest / 2}
    return tuple(Parameter(name, "m", null=0.0, low=-most, high=most, scale=0.05) for name, most in bounds.items())


def _lever_arm_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    state, size = body.layouts.state, len(velocity(body))
    arm = [values.get(name, Integer(0)) for name in ARM]
    rates = [symbol(name) if name in state else Integer(0) for name in RATES]
    turning = [rates[i - 2] * arm[i - 1] - rates[i - 1] * arm[i - 2] for i in range(3)]
    steps = (*to_world(body, arm[:size]), *to_world(body, turning[:size]))
    moved = zip((*POSITION.columns[:size], *VELOCITY.columns[:size]), steps, strict=True)
    return reporting(equations, {name: reported(equations, name) + step for name, step in moved})


def _lever_arm_report(state: Array, body: Body, values: Numbers) -> Array:
    """State of that point of the body: position (m) by the turned arm, velocity (m/s) by the rate across it."""
    layout, size = body.layouts.state, len(velocity(body))
    arm, rates = np.array([values.get(name, 0.0) for name in ARM]), np.zeros(3)
    if body.planar:
        turn = Rotation.from_euler("Z", np.arctan2(*state[layout.indices(HEADING)]))
        rates[2] = state[layout.index("wz")]
    else:
        turn, rates = Rotation.from_quat(np.roll(state[layout.indices(QUATERNION)], -1)), state[layout.indices(RATES)]
    state[layout.indices(POSITION.columns[:size])] += turn.apply(arm)[:size]
    state[layout.indices(VELOCITY.columns[:size])] += turn.apply(np.cross(rates, arm))[:size]
    return state


def _fixed(_body: Body, _values: Array, logs: Iterable[Trajectory]) -> tuple[str, ...]:
    """On one circle an arm aside is the speed's: its gain, its limit."""
    return ("ry",) if single_circle([*logs]) else ()


LEVER_ARM = Kind(
    name="lever_arm",
    stage="measurement",
    parameters=_parameters,
    formula=r"p_m = p + R\,r, \quad v_m = v + R\,(\omega \times r)",
    summary="What is measured is a point away from the centre of mass, or from the middle of a car's rear axle.",
    confused_with="a yaw bias on one circle",
    shown_by="straight driving beside turns both ways; flights that turn",
    fix="move the rigid body's origin in the motion capture by minus this arm",
    inject=truth.measuring(_lever_arm_report),
    substitute=_lever_arm_substitute,
    needs=("x", "y", "{heading}", "wz"),
    # In flight it takes up what a late or filtered velocity does.
    searching=Searching(
        why_not=lambda body: "" if body.planar else LATER,
        fixed=_fixed,
        shown_in=lambda body: (Shown.BOTH_WAYS if body.planar else Shown.YAW,),
    ),
)
