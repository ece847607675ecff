"""What sits a little differently in every run: how a board is screwed on, how motion capture sees its markers."""

from collections.abc import Iterable, Mapping
from math import hypot

from sym2real.effects.body import GRAVITY
from sym2real.effects.bound import Effect
from sym2real.effects.manoeuvres import steady_yaw
from sym2real.trajectory import Trajectory

# A tilt, or side force per weight, that is common between one day and the next (rad): 3.4°.
TRIM = 0.06


def is_trim(effect: Effect, values: Mapping[str, float], logs: Iterable[Trajectory]) -> bool:
    """Whether an effect of this size may be gone in the next run: a tilt of few degrees, or a force that looks so.

    Args:
        effect: which one.
        values: by parameter name.
        logs: what it was found in.
    """
    if effect.kind == "mounting_tilt":
        return hypot(values.get("roll", 0.0), values.get("pitch", 0.0)) <= TRIM
    if effect.kind == "wind" and not effect.body.planar and "mass" in effect.body.numbers:
        side = hypot(values.get("fx", 0.0), values.get("fy", 0.0))
        return side <= TRIM * effect.body.mass * GRAVITY and steady_yaw([*logs])
    return False
