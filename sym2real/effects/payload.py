"""A load at an arm: mass as ``added_mass``, and the centre of mass at r = m_p·arm/(m₀ + m_p)."""

from typing import Any

from sym2real.effects.added_mass import ADDED_MASS
from sym2real.effects.body import Body
from sym2real.effects.com_offset import COM_OFFSET, WITHIN
from sym2real.effects.domain import NOT_NEGATIVE
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.searching import Searching
from sym2real.effects.truth import editing, free_body

RADIUS = 0.003  # m, of the ball that the truth hangs on the robot


def _parameters(body: Body) -> tuple[Parameter, ...]:
    mass = body.numbers.get("mass", 1.0)
    arms = [Parameter(name, "m", null=0.0, low=-0.2, high=0.2, scale=0.02, domain=WITHIN) for name in ("rx", "ry")]
    return (
        Parameter("mass", "kg", null=0.0, low=0.0, high=2.0 * mass, scale=0.1 * mass, domain=NOT_NEGATIVE),
        *arms,
        Parameter("rz", "m", null=0.0, low=-0.2, high=0.2, scale=0.02, fitted=False, domain=WITHIN),
    )


def _parts(values: Values, body: Body) -> tuple[tuple[Kind, Values], ...]:
    share = values["mass"] / (body.mass + values["mass"])
    centre = {name: share * values[name] for name in ("rx", "ry", "rz")}
    return ((ADDED_MASS, {"value": values["mass"]}), (COM_OFFSET, centre))


def _hang(spec: Any, body: Body, values: Numbers) -> None:
    """A ball welded to the robot: MuJoCo finds mass, centre and inertia itself."""
    if not values["mass"]:
        return
    load = free_body(spec).add_body(pos=[values[name] for name in ("rx", "ry", "rz")])
    load.explicitinertial, load.ipos = True, [0.0, 0.0, 0.0]
    load.mass = values["mass"]
    load.inertia = [0.4 * values["mass"] * RADIUS**2] * 3


PAYLOAD = Kind(
    name="payload",
    stage="mass",
    parameters=_parameters,
    formula=r"T, F \to \frac{m_0}{m_0 + m_p}\,(T, F), \quad \tau = -\frac{m_p\,r}{m_0 + m_p} \times T e_3",
    summary="A load hangs on the robot, away from its centre of mass.",
    confused_with="added mass, where it hangs near the centre; its arm with a centre of mass that is off",
    shown_by="thrust that varies, for the arm; weighing, for the mass",
    fix="take the load into the model's mass and centre of mass, or carry it under the centre",
    inject=editing(_hang),
    of_joints="load",
    parts=_parts,
    needs=("thrust", "wx", "wy"),
    numbers=("mass",),
    robot="quadrotor",
    counts_as=("added_mass", "com_offset"),
    searching=Searching(why_not=lambda _: "added_mass and com_offset stand for it together"),
)
