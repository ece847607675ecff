"""Evidence that y is up in a log, as motion capture may have it, right-handed: z is what we call minus y."""

import numpy as np

from sym2real.logs import derive
from sym2real.logs.attitude_reading import read_attitude
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_motion import FAST, LENGTHS
from sym2real.logs.parts import Attitude
from sym2real.logs.reading import by_name, by_size
from sym2real.logs.units import GRAVITY, factor
from sym2real.trajectory import Array
from sym2real.vocabulary import RATE, VELOCITY

# Set by looking at measured logs: of the acceleration that a tilt causes, positions show 0.48 or more, wind or none.
TILTS = 0.25
AXES = (1, np.eye(3)[1]), (2, np.eye(3)[2])
LIES = 0.9  # of an axis, the mean of its part along the vertical, below which it is none that stands


def inspect_upright(draft: Draft) -> None:
    """Where y is up, take it for z, and z, reversed, for y: of positions and of the attitude.

    The body then stands along y, in which it moves least, and as it turns it would lie down if z were up; but no tilt
    accelerates it. Where velocities or rates are measured as well, nobody knows their axes: that is told, no more.
    """
    parts = draft.assignment.quaternions.get("attitude", {})
    if not {*"wxyz"} <= parts.keys() or not draft.has("x", "y", "z"):
        return
    attitude = read_attitude(draft, Attitude(tuple(parts[key] for key in "wxyz")))
    along_y, along_z = (
        float(derive.to_world(attitude, np.tile(axis, (len(attitude), 1)))[:, i].mean()) for i, axis in AXES
    )
    moved = [draft.rows.spread(draft.values(axis)) for axis in "xyz"]
    if not along_z < LIES < along_y or moved[1] > min(moved) or abs(_accelerates(draft, attitude)) > TILTS:
        return
    columns = draft.assignment.columns
    evidence = f"the body stands along y ({along_y:+.2f}); along z ({along_z:+.2f}) its tilt would accelerate it"
    if any(draft.has(name) for name in (*VELOCITY.columns, *RATE.columns)):
        draft.add("", "y may be up", "", f"{evidence}: as read here, velocities and rates lie in other axes", "guess")
        return
    turned = (columns["z"], parts["z"])
    columns["y"], columns["z"] = columns["z"], columns["y"]
    parts["y"], parts["z"] = parts["z"], parts["y"]
    draft.reverse(*turned)
    draft.add("", f"y is up: {' and '.join(turned)} reversed", "", evidence, "likely")


def _accelerates(draft: Draft, attitude: Array) -> float:
    """The part of what a tilt would accelerate that positions show."""
    pace = draft.rows.slopes(draft.values("x", "y"))
    unit, *_ = by_name(draft, ("x", "y")) or by_size(LENGTHS, float(np.percentile(np.abs(pace), 95)), FAST)
    measured, tilt = factor(unit, "x") * draft.rows.slopes(pace), GRAVITY * derive.up(attitude)[:, :2]
    shown, caused = (draft.rows.moving(values) for values in (measured, tilt))
    return float((shown * caused).sum() / (caused**2).sum())
