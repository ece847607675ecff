"""Commands within a band do nothing: play in a linkage, or rest around zero (commands of speed)."""

import numpy as np

from sym2real.effects.body import Body
from sym2real.effects.domain import NOT_NEGATIVE
from sym2real.effects.kind import Kind, Numbers, Parameter
from sym2real.effects.memory import play, zero_band
from sym2real.effects.searching import Searching, Shown, alone_on, by_role
from sym2real.effects.truth import following
from sym2real.protocols import Change


def _widest(body: Body) -> float:
    return 5 * body.scale


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return (
        Parameter("value", body.unit, null=0.0, low=0.0, high=_widest(body), scale=body.scale, domain=NOT_NEGATIVE),
    )


def _inject(body: Body, values: Numbers) -> Change:
    half = 0.5 * values["value"]

    def play(position: float, command: float) -> tuple[float, float]:
        position = float(np.clip(position, command - half, command + half))
        return position, position

    def quiet(position: float, command: float) -> tuple[float, float]:
        return position, 0.0 if abs(command) <= half else command

    return following(body, quiet if body.unit == "m/s" else play)


DEAD_BAND = Kind(
    name="dead_band",
    stage="filter",
    parameters=_parameters,
    formula=r"a' = \mathrm{clip}(a', a - w/2, a + w/2) \;\text{or}\; a' = a\,[|a| > w/2]",
    summary="Commands within a band do nothing: play in a linkage (speed commands: rest around zero).",
    confused_with="a lag of the servo",
    shown_by="slow reversals of the command",
    fix="take the play out of the linkage, or raise the motor driver's lowest duty",
    inject=_inject,
    memory=lambda body: zero_band() if body.unit == "m/s" else play(),
    columns="action",
    searching=Searching(
        why_not=alone_on("rate command", "thrust", "motors"),
        starts=lambda body, values: tuple(min(part * float(np.std(values)), _widest(body)) for part in (0.25, 0.5)),
        from_null=False,
        sizes=lambda _, values: tuple(float(np.std(values)) * part for part in (0.05, 0.1, 0.2, 0.5, 1.0, 2.0)),
        shown_in=by_role({"speed": (Shown.SPEEDS,)}, ()),
    ),
)
