"""More mass than the nominal robot's: thrust and forces times m₀/(m₀ + Δm). Gravity is an acceleration and stays.

Masses add up: on equations that have a mass already, m₀ is that of the robot which carries it.
"""

from sym2real.effects.alike import ONE_LIFT, ONE_MAP, ONE_STRENGTH, ONE_THRUST, Member
from sym2real.effects.body import Body
from sym2real.effects.domain import Domain
from sym2real.effects.gain import LEAST, MOST
from sym2real.effects.kind import Kind, Parameter, Values
from sym2real.effects.thrust import acting_thrust
from sym2real.effects.truth import editing, set_inertial
from sym2real.symbolic import Equations, symbol


def _parameters(body: Body) -> tuple[Parameter, ...]:
    mass = body.numbers.get("mass", 1.0)
    left = Domain(-mass, open=True)  # some of it must be
    low, high = (mass * (1.0 / gain - 1.0) for gain in (MOST, LEAST))  # as far as the thrust gains that it stands for
    return (Parameter("value", "kg", null=0.0, low=low, high=high, scale=0.1 * mass, domain=left),)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    before = body.mass + _carried(equations)
    factor = before / (before + values["value"])
    pushes = [name for name in ("fx", "fy", "fz") if name in equations.layouts.inputs]
    names = [acting_thrust(equations).name, *pushes]
    return equations.substitute({name: symbol(name) * factor for name in names})


def _carried(equations: Equations) -> float:
    """Mass in kg that equations have beyond the nominal one."""
    names = {"added_mass": "value", "payload": "mass"}
    return sum(values.get(names[key], 0.0) for key, values in equations.effects if key in names)


ADDED_MASS = Kind(
    name="added_mass",
    stage="mass",
    parameters=_parameters,
    formula=r"T, F \to \frac{m_0}{m_0 + \Delta m}\,(T, F)",
    summary="The robot is heavier than the nominal one, at its centre.",
    confused_with="a thrust gain below one, unless motors turn the body; near one thrust a thrust offset",
    shown_by="no flight tells it from a thrust gain, unless motors turn the body: weigh the robot",
    fix="weigh the robot and set its mass; if the mass is right, correct the thrust map by this factor instead",
    inject=editing(lambda spec, body, values: set_inertial(spec, extra_mass=values["value"])),
    of_joints="load",
    substitute=_substitute,
    needs=("thrust",),
    numbers=("mass",),
    robot="quadrotor",
    weighed="scales do: weigh the robot",
    alike=(Member(ONE_STRENGTH, 0), Member(ONE_THRUST, 0), Member(ONE_MAP, 0), Member(ONE_LIFT, 0)),
)
