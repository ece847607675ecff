"""Evidence on the speed of a car's wheels: its unit, or what it counts, by the way that the car moves."""

from __future__ import annotations

import numpy as np

from sym2real.logs import signals
from sym2real.logs.draft import Draft
from sym2real.logs.units import UNITS, unit_by_ratio

SPEEDS = [unit for unit, (meant, _) in UNITS.items() if meant == "m/s"]
NEAR = 1.25  # times; a unit is taken where the ratio is as near to its own
MOVING = 0.05  # m/s, the mean speed below which noise of positions is all of it


def inspect_wheel(draft: Draft) -> None:
    """Unit of a measured speed without direction; one that is none leaves a scale in a comment."""
    if not draft.has("wheel_speed"):
        return
    values, named = draft.values("wheel_speed"), draft.named_unit("wheel_speed")
    ratio = _over_path(draft)
    unit = named if named in SPEEDS else ""
    nearest = unit_by_ratio(ratio or 1.0, SPEEDS)
    off = (ratio or 1.0) * UNITS[nearest][1]
    if not unit and max(off, 1.0 / off) < NEAR:
        unit = nearest
    if ratio is None:
        evidence = "too little motion to tell the unit"
    else:
        evidence = f"{ratio:.4g} times as fast as the path in m/s, correlation {_together(draft):+.2f}"
    if unit:
        draft.settle("wheel_speed", unit, evidence, "likely" if ratio is None else "certain")
        return
    column = draft.column("wheel_speed")
    draft.left_out.add("wheel_speed")
    evidence += f": no unit of a speed ({signals.largest(values):.4g} at most)"
    draft.add(column, "speed of the wheels", "?", evidence, "unknown")
    scale = f"scale = {1.0 / ratio:.6g} }}  # m/s per count, as the path says" if ratio else "scale = 1.0 }"
    draft.comment("columns", f'wheel_speed = {{ column = "{column}", {scale}')


def _over_path(draft: Draft) -> float | None:
    """Mean of the speed over that of the path in m/s; None where nothing moves."""
    if not draft.has("x", "y"):
        return None
    path = float(np.concatenate(_pace(draft)).mean())
    speed = float(np.abs(np.concatenate(draft.values("wheel_speed"))).mean())
    return speed / path if path > MOVING and speed > 0 else None


def _pace(draft: Draft) -> signals.Series:
    east, north = (signals.slopes(draft.stamps, draft.series(axis)) for axis in "xy")
    return [np.hypot(*parts) for parts in zip(east, north, strict=True)]


def _together(draft: Draft) -> float:
    return signals.correlation([np.abs(part) for part in draft.values("wheel_speed")], _pace(draft))
