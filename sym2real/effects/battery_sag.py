"""Thrust that fades as the battery empties: T (1 - s·t), or T (1 - s·(V₀ - V)) where the voltage is an input.

V₀ is where the thrust map holds: the number ``full_battery`` of the equations, else that of a full cell.
"""

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.clock import with_time
from sym2real.effects.kind import Kind, Parameter, Values
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.thrust import scaled
from sym2real.effects.voltage import VOLTAGE
from sym2real.layout import motors_of
from sym2real.symbolic import Equations, symbol

FULL_BATTERY = 4.2  # V, one lithium-polymer cell


def _parameters(body: Body) -> tuple[Parameter, ...]:
    if VOLTAGE in body.layouts.inputs:
        return (Parameter("value", "1/V", null=0.0, low=0.0, high=1.0, scale=0.1),)
    return (Parameter("value", "1/s", null=0.0, low=0.0, high=0.1, scale=0.005),)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    if VOLTAGE in body.layouts.inputs:
        full = body.numbers.get("full_battery", FULL_BATTERY)
        return scaled(equations, 1 - values["value"] * (full - symbol(VOLTAGE)))
    equations, time = with_time(equations)
    return scaled(equations, 1 - values["value"] * time)


def _why_not(body: Body) -> str:
    """A battery lets rotors turn more slowly; what a rotor of some speed gives is the air's."""
    known = motors_of(body.layouts.action) and "rotor_thrust" in body.numbers
    return "the rotors' speeds are in the logs, and the battery acts through these" if known else ""


BATTERY_SAG = Kind(
    name="battery_sag",
    stage="thrust",
    parameters=_parameters,
    formula=r"T \to T\,(1 - s\,t) \;\text{or}\; T\,(1 - s\,(V_0 - V))",
    summary="Thrust fades while the battery empties: by s a second, or a volt V below V₀ where logs hold the voltage.",
    confused_with="a thrust gain in short logs",
    shown_by="logs of at least 8 s, better with the battery's voltage in them (V₀ is that of their first 2 s)",
    fix="switch the firmware's battery compensation on, log the voltage, or charge more often",
    inject=truth.pushing(lambda data, body, values: truth.scale_thrust(data, 1.0 - values["value"] * data.time)),
    substitute=_substitute,
    needs=("thrust",),
    robot="quadrotor",
    reads=(VOLTAGE,),
    searching=Searching(why_not=_why_not, shown_in=lambda _: (Shown.TIME,)),
)
