"""Columns that a log lacks and that its others say: angles that count on, velocities, rates."""

from dataclasses import replace

import numpy as np

from sym2real.layout import Layouts
from sym2real.logs import derive
from sym2real.logs.dropouts import UNWRAPPED
from sym2real.logs.specification import LogSpec
from sym2real.logs.standard import QUATERNION, Columns, Standard, side_by_side
from sym2real.trajectory import Array
from sym2real.vocabulary import RATE


def add_derived(log: Standard, spec: LogSpec, layouts: Layouts | None, dt: float | None) -> Standard:
    """Angles of joints that count on beyond a turn, and velocities from a wheel's speed; velocities, and rates of
    attitude and joints, where the specification asks; for a model of this step in s, if there is one."""
    around = derive.rows_around(log.time, dt)
    angles, rolling = _counted_on(log, layouts), _rolling(log, around)
    log = replace(log, columns={**log.columns, **angles})
    columns, notes = {**log.columns, **rolling}, list(log.notes)
    notes += [f"{joint} {UNWRAPPED}" for joint in angles]
    if rolling:
        notes.append("velocities are wheel_speed along the heading and slopes of positions across it")
    if "velocity" in spec.derive:
        for axis in "xyz":
            if axis in columns and f"v{axis}" not in columns:
                columns[f"v{axis}"] = derive.closest_slope(log.time, columns[axis], around)
        notes.append(f"velocities are slopes of positions (parabola through {around} rows, or fewer)")
    if "rate" in spec.derive:
        of_joints = _joint_rates(log, layouts, around)
        columns = rates(log.time, log.columns, around) | of_joints | columns
        of = f"{', '.join(of_joints)} are slopes" if of_joints else "angular rates are slopes of the attitude"
        notes.append(f"{of} (parabola through {around} rows{', or fewer' if of_joints else ''})")
    return Standard(log.time, columns, log.others, tuple(notes))


def _counted_on(log: Standard, layouts: Layouts | None) -> Columns:
    """Angles of joints whose encoder begins anew after a turn, without its jumps."""
    units = {} if layouts is None else {joint: layouts.state.units[joint] for joint in layouts.state.joints}
    there = [joint for joint, unit in units.items() if unit == "rad" and joint in log.columns]
    unwrapped = {joint: derive.unwrapped(log.columns[joint]) for joint in there}
    return {joint: angle for joint, angle in unwrapped.items() if (angle != log.columns[joint]).any()}


def _rolling(log: Standard, around: int) -> Columns:
    moved = side_by_side(log.columns, ("x", "y", "sin_yaw", "cos_yaw", "wheel_speed"))
    if moved is None or {"vx", "vy"} & log.columns.keys():
        return {}
    yaw = np.arctan2(moved[:, 2], moved[:, 3])
    velocity = derive.rolling(log.time, moved[:, :2], yaw, moved[:, 4], around)
    return dict(zip(("vx", "vy"), velocity.T, strict=True))


def rates(time: Array, columns: Columns, around: int) -> Columns:
    """Slopes of the attitude in body axes, or of a heading, through so many rows; none without these."""
    if (quaternion := side_by_side(columns, QUATERNION)) is not None:
        return dict(zip(RATE.columns, derive.body_rate(time, quaternion, around).T, strict=True))
    if "sin_yaw" in columns:
        heading = derive.counted_heading(columns["sin_yaw"], columns["cos_yaw"])
        return {"wz": derive.slope(time, heading, around)}
    return {}


def _joint_rates(log: Standard, layouts: Layouts | None, around: int) -> Columns:
    if layouts is None:
        return {}
    rates = layouts.state.rates
    there = [joint for joint in layouts.state.joints if joint in log.columns and rates[joint] not in log.columns]
    return {rates[joint]: derive.closest_slope(log.time, log.columns[joint], around) for joint in there}
