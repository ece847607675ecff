"""Evidence on positions, velocities and rates: units, axes, signs, by the slopes of one that another is."""

import numpy as np

from sym2real.logs import derive
from sym2real.logs.attitude_reading import TILTING, gyro_agreement, read_attitude, tilt_agreement, usual_reading
from sym2real.logs.draft import Draft
from sym2real.logs.parts import Attitude
from sym2real.logs.reading import CLEAR, WEAK, Reading, by_name, by_others, by_ratio, by_size, largest, settle
from sym2real.logs.standard import INVERSE
from sym2real.logs.units import GRAVITY, UNITS, factor, unit_by_ratio
from sym2real.trajectory import Array
from sym2real.vocabulary import POSITION, RATE, VELOCITY

LENGTHS, RATES = ("m", "mm", "cm"), ("rad/s", "deg/s", "mrad/s")
SPEEDS = tuple(unit for unit, (meant, _) in UNITS.items() if meant == "m/s")
FAST = 40.0  # m/s at the 95th percentile: faster than any robot in a laboratory
FASTEST = 40.0  # rad/s; a gyro of a small robot ends at 2000 deg/s = 35 rad/s
MOVING = 0.01  # m/s
DRIVING = 0.05  # m/s, the mean speed below which noise of positions is all of it
BETTER = 2.0  # how many times more one explanation must leave over for the other to be taken
NEAR = 1.25  # times; a wheel's unit is taken where the ratio is as near to its own


def inspect_positions(draft: Draft) -> None:
    """Unit of positions; sets ``acceleration``."""
    axes = [axis for axis in POSITION.columns if draft.has(axis)]
    if not axes:
        return
    pace = {axis: draft.rows.slopes(draft.values(axis)) for axis in axes}
    acceleration = np.stack([draft.rows.slopes(pace[axis]) for axis in axes], axis=1)
    shares, units = _by_velocity(draft, pace), dict[str, str]()
    alike = len({unit_by_ratio(share, LENGTHS) for share in shares.values()}) < 2
    for group in [axes] if alike else [[axis] for axis in axes]:
        own = [shares[axis] for axis in group if axis in shares]
        by_rate = by_ratio(LENGTHS, float(np.median(own)), "the logged velocity in m/s says") if own else None
        fast = float(np.percentile(np.abs([pace[axis] for axis in group]), 95))
        by_motion = by_rate or _by_tilt(draft, acceleration)
        unit, evidence, confidence = by_name(draft, group) or by_size(LENGTHS, fast, FAST, by_motion)
        evidence += " a second, as it moves" if evidence.startswith("up to") else ""
        for axis in group:
            draft.settle(axis, unit, evidence, confidence)
            units[axis] = unit
    if {"x", "y"} <= set(axes):
        draft.acceleration = acceleration * [factor(units[axis], axis) for axis in axes]


def _by_velocity(draft: Draft, pace: dict[str, Array]) -> dict[str, float]:
    """How many times as much as its logged velocity in m/s says each position moves, where both go together."""
    logged = {axis: f"v{axis}" for axis in pace if draft.has(f"v{axis}")}
    velocity = {axis: UNITS[draft.named_unit(v) or "m/s"][1] * draft.values(v) for axis, v in logged.items()}
    alike = [axis for axis in velocity if abs(draft.rows.correlation(pace[axis], velocity[axis])) > CLEAR]
    return {axis: draft.rows.ratio(pace[axis], velocity[axis]) for axis in alike}


def _by_tilt(draft: Draft, acceleration: Array) -> Reading | None:
    """A body that leans by an angle accelerates by g times it."""
    parts = draft.assignment.quaternions.get("attitude")
    if draft.assignment.is_car or not parts or not draft.has("x", "y"):
        return None
    caused = GRAVITY * derive.up(read_attitude(draft, usual_reading(draft, parts)))[:, :2]
    if draft.rows.spread(caused) < GRAVITY * TILTING:
        return None
    return by_ratio(LENGTHS, draft.rows.ratio(acceleration[:, :2], caused), "its tilt accelerates it in m/s²")


def inspect_wheel(draft: Draft) -> None:
    """Unit of a measured speed without direction; one that is none leaves a scale in a comment."""
    if not draft.has("wheel_speed"):
        return
    size, unit = np.abs(draft.values("wheel_speed")), draft.named_unit("wheel_speed")
    pace = pace_of_path(draft)
    ratio = float(size.mean() / pace.mean()) if pace.mean() > DRIVING and size.any() else None
    nearest = unit_by_ratio(ratio or 1.0, SPEEDS)
    off = (ratio or 1.0) * UNITS[nearest][1]
    unit = unit if unit in SPEEDS else nearest if max(off, 1.0 / off) < NEAR else ""
    evidence = "too little motion to tell the unit"
    if ratio is not None:
        together = draft.rows.correlation(size, pace)
        evidence = f"{ratio:.4g} times as fast as the path in m/s, correlation {together:+.2f}"
    if unit:
        draft.settle("wheel_speed", unit, evidence, "likely" if ratio is None else "certain")
        return
    evidence += f": no unit of a speed ({size.max():.4g} at most)"
    worth = f"scale = {1.0 / ratio:.6g} }}  # m/s per count, as the path says" if ratio else "scale = 1.0 }"
    draft.leave_open("wheel_speed", "speed of the wheels", evidence, worth)


def inspect_velocities(draft: Draft) -> None:
    """Unit, axes (world or body) and signs of velocities, from the slopes of positions."""
    names = [name for name in VELOCITY.columns if draft.has(name)]
    if not names and draft.has("x", "y"):
        statement = "the log has none: slopes of positions"
        if draft.has("wheel_speed") and draft.heading is not None:
            statement = "the log has none: the wheels' speed along the heading, slopes of positions across it"
        else:
            draft.derived.append("velocity")
        draft.add("", "velocity", "m/s", statement, "certain")
    if not names:
        return
    world = slopes_of_positions(draft)
    moving = [name for name in names if name in world and draft.rows.spread(world[name]) > MOVING]
    body = in_body(draft, world) if {"vx", "vy"} <= set(moving) else {}
    if body:
        _decide_velocity_frame(draft, moving, world, body)
    true = body if draft.velocity_frame == "body" else world
    expected, what = {name: true[name] for name in moving}, "the slope of the position"
    guess = by_name(draft, names) or by_others(draft, SPEEDS[:3], expected, f"{what} in m")
    guess = guess or ("m/s", "too little motion to tell", "likely")
    settle(
        draft, names, guess, {name: draft.rows.correlation(draft.values(name), expected[name]) for name in moving}, what
    )


def slopes_of_positions(draft: Draft) -> dict[str, Array]:
    """World velocities in m/s ``# (rows,)`` by positions."""
    return {f"v{axis}": draft.rows.slopes(draft.series(axis)) for axis in POSITION.columns if draft.has(axis)}


def pace_of_path(draft: Draft) -> Array:
    """How fast the path goes, m/s ``# (rows,)``; zeros where nothing tells."""
    slopes = slopes_of_positions(draft)
    return np.hypot(slopes["vx"], slopes["vy"]) if draft.has("x", "y") else np.zeros(len(draft.rows.stamps))


def in_body(draft: Draft, world: dict[str, Array]) -> dict[str, Array]:
    """World velocities in body axes, where the attitude or the heading is known."""
    if draft.world is not None:
        inverse = draft.world * INVERSE
    elif draft.heading is not None:
        inverse = derive.about_vertical(-draft.heading)
    else:
        return {}
    velocity = np.stack([world.get(name, np.zeros(len(inverse))) for name in VELOCITY.columns], axis=1)
    return dict(zip(VELOCITY.columns, derive.to_world(inverse, velocity).T, strict=True))


def _explained(draft: Draft, names: list[str], by: dict[str, Array]) -> float:
    """Share of the variance of measured velocities that slopes of positions explain, unit and signs aside."""
    measured = draft.rows.moving(draft.values(*names))
    expected = draft.rows.moving(np.stack([by[name] for name in names], axis=1))
    products = np.abs(np.sum(measured * expected, axis=0)).sum()
    sizes = np.linalg.norm(measured) * np.linalg.norm(expected)
    return float((products / sizes) ** 2) if sizes > 0 else 0.0


def _decide_velocity_frame(draft: Draft, names: list[str], world: dict[str, Array], body: dict[str, Array]) -> None:
    in_world, in_body = _explained(draft, names, world), _explained(draft, names, body)
    left = (1.0 - in_world + 1e-9) / (1.0 - in_body + 1e-9)
    if left > BETTER:
        draft.velocity_frame = "body"
    clear = max(left, 1.0 / left) > BETTER
    evidence = (
        f"slopes of positions explain {100 * in_world:.1f} % of it in world axes, {100 * in_body:.1f} % in body axes"
    )
    draft.add("", f"velocity in {draft.velocity_frame} axes", "", evidence, "certain" if clear else "guess")


def inspect_rates(draft: Draft) -> None:
    """Unit and sign of body rates, from the slope of the attitude or of the heading."""
    names = [name for name in RATE.columns if draft.has(name)]
    suspected = _suspect_angles(draft)
    what = f"the slope of the attitude{suspected}" if draft.turning else ""
    correlations = gyro_agreement(draft)
    if names:
        heard = {name: draft.turning[name] for name in names if abs(correlations.get(name, 0.0)) > WEAK}
        reading = by_name(draft, names) or by_others(draft, RATES, heard, "the attitude in rad/s")
        settle(draft, names, reading or by_size(RATES, largest(draft, names), FASTEST), correlations, what)
    elif draft.turning:
        draft.derived.append("rate")
        draft.add("", "body rate", "rad/s", f"the log has none: {what}", "certain")


def _suspect_angles(draft: Draft) -> str:
    """Files angles of the other sign and takes their slopes the right way round from there on, which it says."""
    euler = draft.attitudes.get("attitude", Attitude()).euler
    vertical, tilt, turned = 1.0 if draft.frames == "z_up" else -1.0, tilt_agreement(draft), list[str]()
    for place, (angle, column) in enumerate(zip(("roll", "pitch"), euler, strict=False)):
        agreement = vertical * tilt.get(angle, 0.0)
        if agreement < -CLEAR and draft.body_rates is not None:
            draft.suspect(column, f"correlation {agreement:+.3f} of the acceleration with what this angle should cause")
            draft.body_rates[:, place] *= -1.0
            turned.append(repr(column))
    return f" with {' and '.join(turned)} reversed" if turned else ""
