"""The base stands askew: gravity is turned by small angles about the world's x and y axes."""

from typing import Any

from scipy.spatial.transform import Rotation
from sympy import cos, sin

from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.truth import editing
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import GRAVITY_COMPONENTS


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    """Gravity in the axes of a base that is rolled, then pitched."""
    x, y, z = (symbol(name) for name in GRAVITY_COMPONENTS)
    roll, pitch = values["roll"], values["pitch"]
    level = x * cos(pitch) - z * sin(pitch)
    down = x * sin(pitch) + z * cos(pitch)
    turned = (level, y * cos(roll) + down * sin(roll), down * cos(roll) - y * sin(roll))
    return equations.substitute(dict(zip(GRAVITY_COMPONENTS, turned, strict=True)))


def _turn(spec: Any, body: Body, values: Numbers) -> None:
    """Gravity in the axes of a base that is pitched, then rolled in its own."""
    base = Rotation.from_euler("YX", [values["pitch"], values["roll"]])
    spec.option.gravity = base.inv().apply(spec.option.gravity)


GRAVITY_TILT = Kind(
    name="gravity_tilt",
    stage="mass",
    parameters=of_any_body(
        *(Parameter(name, "rad", null=0.0, low=-0.5, high=0.5, scale=0.03) for name in ("roll", "pitch"))
    ),
    formula=r"g \to R_x(\phi) R_y(\theta) g",
    summary="The robot's base stands askew, so that gravity pulls from another side.",
    confused_with="an offset of the actuators in one posture",
    shown_by="several postures",
    fix="level the base, or tell the model how it stands",
    inject=editing(_turn),
    substitute=_substitute,
    needs=GRAVITY_COMPONENTS,
    robot="robot with joints",
)
