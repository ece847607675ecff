"""An actuator follows its command no faster than a fixed rate: |da'/dt| ≤ r."""

import numpy as np

from sym2real.effects.body import Body
from sym2real.effects.domain import NOT_NEGATIVE
from sym2real.effects.kind import UNLIMITED, Kind, Numbers, Parameter
from sym2real.effects.memory import rate_limited
from sym2real.effects.searching import Searching, Shown, alone_on, by_role
from sym2real.effects.truth import following
from sym2real.protocols import Change

# The truth integrates a control period in so many pieces.
PIECES = 200


def _parameters(body: Body) -> tuple[Parameter, ...]:
    unit = f"{body.unit}/s".replace("/s/s", "/s²")
    low, high, scale = (factor * body.scale for factor in (0.1, 1000, 10))
    return (Parameter("value", unit, null=UNLIMITED, low=low, high=high, scale=scale, domain=NOT_NEGATIVE),)


def _inject(body: Body, values: Numbers) -> Change:
    step = values["value"] * body.dt / PIECES

    def follow(position: float, command: float) -> tuple[float, float]:
        """Position after a period of following a command, and its mean over the period, in the command's unit."""
        passed = []
        for _ in range(PIECES):
            before = position
            position += float(np.clip(command - position, -step, step))
            passed.append(0.5 * (before + position))
        return position, float(np.mean(passed))

    return following(body, follow)


RATE_LIMIT = Kind(
    name="rate_limit",
    stage="filter",
    parameters=_parameters,
    formula=r"|\dot a'| \le r",
    summary="The actuator follows its command no faster than a fixed rate.",
    confused_with="a lag, whose speed grows with the step",
    shown_by="small and large steps of the command",
    fix="raise the limit in the firmware (servo speed, acceleration limit), or limit the commands' rate",
    inject=_inject,
    memory=lambda body: rate_limited(),
    columns="action",
    searching=Searching(
        why_not=alone_on("rate command", "thrust", "motors"),
        starts=lambda body, values: tuple(float(np.std(values)) / body.dt * 0.2 * part for part in (1.0, 3.0)),
        from_null=False,
        sizes=lambda body, values: tuple(float(np.std(values)) / body.dt * part for part in (2.0, 1.0, 0.5, 0.2, 0.1)),
        shown_in=by_role({"speed": (Shown.DITHER, Shown.SPEEDS, Shown.SWINGING_SPEED)}, (Shown.DITHER,)),
    ),
)
