r"""A load at an arm of a rotorcraft.

``payload``. Mass as ``added_mass``, and the centre of mass at r = m_p·arm/(m₀ + m_p). On a rate loop also the inertia
of the reduced mass m₀ m_p/(m₀ + m_p) at that arm: what makes level turns harder alike, by s, as ``rate_loop_gain`` 1/s,
to which torques then count 1/s as well, the rest as ``inertia_axes``.
"""

import math
from typing import Any

from sympy import Expr, Integer

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.inertia import INERTIA_AXES
from sym2real.effects.kind import NOT_NEGATIVE, Kind, Numbers, Parameter, Values
from sym2real.effects.loops import NUMBERS, RATE_LOOP_GAIN
from sym2real.effects.searching import Searching
from sym2real.effects.thrusts import ADDED_MASS, COM_OFFSET, WITHIN
from sym2real.effects.wrench import AXES
from sym2real.vocabulary import RATE_COMMAND

STOOD_FOR = (
    "added_mass, com_offset and, at a long arm, inertia_axes stand for it, as long as nothing is left beside them; "
    "`sym2real add MODEL payload --fit LOG` fits them as one load"
)
RADIUS = 0.003  # m, of the ball that the truth hangs on the robot


def _payload_parameters(body: Body) -> tuple[Parameter, ...]:
    mass = body.numbers.get("mass", 1.0)
    arms = [Parameter(name, "m", null=0.0, low=-0.2, high=0.2, scale=0.02, domain=WITHIN) for name in ("rx", "ry")]
    return (
        Parameter("mass", "kg", null=0.0, low=0.0, high=2.0 * mass, scale=0.1 * mass, domain=NOT_NEGATIVE),
        *arms,
        Parameter("rz", "m", null=0.0, low=-0.2, high=0.2, scale=0.02, fitted=False, domain=WITHIN),
    )


def _parts(values: Values, body: Body) -> tuple[tuple[Kind, Values], ...]:
    share = values["mass"] / (body.mass + values["mass"])
    harder, turning = _harder_to_turn(share * body.mass, values, body)
    centre = {name: share * values[name] / harder for name in ("rx", "ry", "rz")}
    return ((ADDED_MASS, {"value": values["mass"]}), (COM_OFFSET, centre), *turning)


def _harder_to_turn(mass: Expr, values: Values, body: Body) -> tuple[Expr, tuple[tuple[Kind, Values], ...]]:
    """What a mass (kg) at the load's place multiplies level inertia by, and the effects of its inertia on a loop."""
    if not ({*NUMBERS} <= {*body.numbers} and {*RATE_COMMAND.columns} <= {*body.names}):
        return Integer(1), ()
    x, y, z = (values[name] for name in ("rx", "ry", "rz"))
    jx, jy, jz = (body.number(f"j{axis}") for axis in AXES)
    roll, pitch, yaw = mass * (y**2 + z**2) / jx, mass * (x**2 + z**2) / jy, mass * (x**2 + y**2) / jz
    harder = 1 + (roll + pitch) / 2
    axes = {"roll": (roll - pitch) / (2 * harder), "coupling": -mass * x * y / (math.sqrt(jx * jy) * harder)}
    loop = {"value": 1 / harder, "yaw": harder / (1 + yaw)}
    return harder, ((RATE_LOOP_GAIN, loop), (INERTIA_AXES, axes))


def _hang(spec: Any, body: Body, values: Numbers) -> None:
    """A ball welded to the robot: MuJoCo finds mass, centre and inertia itself."""
    if mass := values["mass"]:
        place = [values[name] for name in ("rx", "ry", "rz")]
        truth.weld(truth.free_body(spec), place, mass, [0.4 * mass * RADIUS**2] * 3)


PAYLOAD = Kind(
    name="payload",
    stage="mass",
    robot="quadrotor",
    parameters=_payload_parameters,
    formula=r"T, F \to \frac{m_0}{m_0 + m_p}\,(T, F), \quad \tau = -\frac{m_p\,r}{m_0 + m_p} \times T e_3, \quad "
    r"J \to J_0 + \frac{m_0\,m_p}{m_0 + m_p}\,(r^2 - r r^T)",
    summary="A load hangs on the robot, away from its centre of mass.",
    confused_with="added mass, where it hangs near the centre; its arm with a centre of mass that is off",
    shown_by="thrust that varies, for the arm; weighing, for the mass",
    fix="take the load into the model's mass and centre of mass, or carry it under the centre",
    inject=truth.editing(_hang),
    of_joints="load",
    parts=_parts,
    needs=("thrust", "wx", "wy"),
    numbers=("mass",),
    counts_as=("added_mass", "com_offset"),
    searching=Searching(why_not=lambda _: STOOD_FOR),
)
