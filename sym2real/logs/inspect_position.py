"""Evidence on positions: their unit, by what they must agree with."""

from __future__ import annotations

import numpy as np

from sym2real.logs import signals
from sym2real.logs.attitude_reading import TILTING, level_push
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_attitude import CLEAR
from sym2real.logs.signals import Series
from sym2real.logs.units import GRAVITY, UNITS, factor, unit_by_ratio

FAST = 40.0  # m/s at the 95th percentile: faster than any robot in a laboratory


def inspect_positions(draft: Draft) -> None:
    """Unit of positions; sets ``acceleration``."""
    axes = [axis for axis in "xyz" if draft.has(axis)]
    if not axes:
        return
    pace = {axis: signals.slopes(draft.stamps, draft.values(axis)) for axis in axes}
    push = {axis: signals.slopes(draft.stamps, pace[axis]) for axis in axes}
    unit, evidence, sure = _unit(draft, pace, push)
    for axis in axes:
        draft.settle(axis, unit, evidence, "certain" if sure else "likely")
    if {"x", "y"} <= set(axes):
        scale = factor(unit, "x")
        parts = [push[axis] for axis in axes]
        draft.acceleration = [
            scale * np.stack([part[log] for part in parts], axis=1) for log in range(len(draft.looked_at))
        ]


def _unit(draft: Draft, pace: dict[str, Series], push: dict[str, Series]) -> tuple[str, str, bool]:
    """Unit by name, else against velocities, else against the tilt, else by speed; evidence; whether it is sure."""
    if named := draft.named_unit(*pace):
        return named, "the name says so", True
    fast = float(np.percentile(np.abs(np.concatenate([part for parts in pace.values() for part in parts])), 95))
    share, against = _against_velocity(draft, pace) or _against_tilt(draft, push) or (1.0, "")
    unit = unit_by_ratio(share, ("m", "cm", "mm"))
    if unit == "m" and fast > FAST:
        return "mm", f"moves at {fast:.3g} a second (95 %): too fast for m", False
    return unit, against or f"moves at up to {fast:.3g} {unit}/s (95 %)", bool(against)


def _against_velocity(draft: Draft, pace: dict[str, Series]) -> tuple[float, str] | None:
    shares = []
    for axis, slopes in pace.items():
        if not draft.has(f"v{axis}"):
            continue
        scale = UNITS[draft.named_unit(f"v{axis}") or "m/s"][1]
        velocity = [scale * values for values in draft.values(f"v{axis}")]
        if abs(signals.correlation(slopes, velocity)) > CLEAR:
            shares.append(signals.ratio(slopes, velocity))
    if not shares:
        return None
    share = float(np.median(shares))
    return share, f"moves {share:.3g} times as fast as the logged velocity in m/s"


def _against_tilt(draft: Draft, push: dict[str, Series]) -> tuple[float, str] | None:
    """A body that leans by an angle accelerates by g times it."""
    caused = level_push(draft)
    axes = [(axis, i) for i, axis in enumerate("xy") if axis in push]
    moved = sum(signals.spread([part[:, i] for part in caused]) for _, i in axes) if caused else 0.0
    if moved < GRAVITY * TILTING:
        return None
    share = sum(signals.spread(push[axis]) for axis, _ in axes) / moved
    return share, f"accelerates {share:.3g} times as much as its tilt does in m/s²"
