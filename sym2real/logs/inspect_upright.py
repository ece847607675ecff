"""Evidence that y is up in a log, as motion capture and game engines have it."""

import numpy as np

from sym2real.logs.attitude_reading import TILTING, read_attitude, up
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_motion import FAST, LENGTHS
from sym2real.logs.parts import Attitude
from sym2real.logs.reading import by_name, by_size
from sym2real.logs.units import GRAVITY, factor
from sym2real.trajectory import Array

TILTS = 0.25  # of the acceleration that a tilt causes, as positions show it; 0.5 and more where wind acts too


def inspect_upright(draft: Draft) -> None:
    """Where y is up, take it for z, and z, reversed, for y: of positions and of the attitude."""
    parts = draft.assignment.quaternions.get("attitude", {})
    if not {*"wxyz"} <= parts.keys() or not draft.has("x", "y", "z"):
        return
    attitude = read_attitude(draft, Attitude(tuple(parts[key] for key in "wxyz")))
    along_y, along_z = (float(np.mean(1.0 - 2.0 * (attitude[:, 1] ** 2 + attitude[:, i] ** 2))) for i in (3, 2))
    tilt = GRAVITY * up(attitude)[:, :2]
    if along_y < along_z or draft.rows.spread(tilt) < GRAVITY * TILTING or abs(_accelerates(draft, tilt)) > TILTS:
        return
    columns = draft.assignment.columns
    turned = (columns["z"], parts["z"])
    columns["y"], columns["z"] = columns["z"], columns["y"]
    parts["y"], parts["z"] = parts["z"], parts["y"]
    draft.reverse(*turned)
    evidence = f"the body stands along y ({along_y:+.2f}); along z ({along_z:+.2f}) its tilt would accelerate it"
    draft.add("", f"y is up: {' and '.join(turned)} reversed", "", evidence, "likely")


def _accelerates(draft: Draft, tilt: Array) -> float:
    """The part of what a tilt would accelerate, m/s² ``# (rows, 2)``, that positions show."""
    pace = draft.rows.slopes(draft.values("x", "y"))
    unit, *_ = by_name(draft, ("x", "y")) or by_size(LENGTHS, float(np.percentile(np.abs(pace), 95)), FAST)
    found, caused = (draft.rows.moving(values) for values in (factor(unit, "x") * draft.rows.slopes(pace), tilt))
    return float((found * caused).sum() / (caused**2).sum())
