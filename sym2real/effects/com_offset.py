"""The centre of mass beside the thrust line: τ = -r × T e₃ = T (-r_y, r_x, 0)."""

from sym2real.effects.alike import ONE_TORQUE_AT_ONE_THRUST, Member
from sym2real.effects.body import Body
from sym2real.effects.domain import Domain
from sym2real.effects.kind import Kind, Parameter, Values
from sym2real.effects.thrust import acting_thrust
from sym2real.effects.truth import editing, set_inertial
from sym2real.effects.wrench import push
from sym2real.symbolic import Equations

# m: no robot of these is so large, and its centre of mass is inside of it.
WITHIN = Domain(-1.0, 1.0)


def _parameters(body: Body) -> tuple[Parameter, ...]:
    along = (Parameter(name, "m", null=0.0, low=-0.03, high=0.03, scale=0.002, domain=WITHIN) for name in ("rx", "ry"))
    # Thrust passes through a centre of mass that is only higher or lower.
    return (*along, Parameter("rz", "m", null=0.0, low=-0.03, high=0.03, scale=0.002, fitted=False, domain=WITHIN))


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    thrust = acting_thrust(equations)
    return push(equations, body, torque=(-values["ry"] * thrust, values["rx"] * thrust))


COM_OFFSET = Kind(
    name="com_offset",
    stage="wrench",
    parameters=_parameters,
    formula=r"\tau = -r \times T e_3",
    summary="The centre of mass lies beside the thrust line, so that thrust turns the body.",
    confused_with="a constant torque or an offset of the rate commands, where thrust hardly varies",
    shown_by="thrust that varies: climbs and descents, fast turns",
    fix="move the battery or the load by minus this offset, or trim the mixer",
    inject=editing(lambda spec, body, values: set_inertial(spec, offset=(values["rx"], values["ry"], values["rz"]))),
    substitute=_substitute,
    needs=("thrust", "wx", "wy"),
    robot="quadrotor",
    alike=(Member(ONE_TORQUE_AT_ONE_THRUST, 0),),
    by_torque=lambda _: True,
)
