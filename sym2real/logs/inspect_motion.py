"""Evidence on velocities and rates: units, axes, signs."""

from __future__ import annotations

import numpy as np

from sym2real.logs import derive, signals
from sym2real.logs.attitude_reading import TURNING, gyro_agreement, tilt_agreement
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_attitude import CLEAR, WEAK
from sym2real.logs.parts import Attitude
from sym2real.logs.signals import Series
from sym2real.logs.units import unit_by_ratio

RATE_UNITS = ("rad/s", "deg/s", "mrad/s")
FASTEST = 40.0  # rad/s; a gyro of a small robot ends at 2000 deg/s = 35 rad/s
MOVING = 0.01  # m/s
BETTER = 2.0  # how many times more one explanation must leave over for the other to be taken


def inspect_velocities(draft: Draft) -> None:
    """Unit, axes (world or body) and signs of velocities, from the slopes of positions."""
    names = [name for name in ("vx", "vy", "vz") if draft.has(name)]
    pairs = [name for name in names if draft.has(name[1])]
    if not names:
        if draft.has("x", "y", "wheel_speed") and draft.heading:
            statement = "the log has none: the wheels' speed along the heading, slopes of positions across it"
            draft.add("", "velocity", "m/s", statement, "certain")
        elif draft.has("x", "y"):
            draft.derived.append("velocity")
            draft.add("", "velocity", "m/s", "the log has none: slopes of positions", "certain")
        return
    true = {name: signals.slopes(draft.stamps, draft.series(name[1])) for name in pairs}
    moving = [name for name in pairs if signals.spread(true[name]) > MOVING]
    body = in_body(draft, true) if {"vx", "vy"} <= set(moving) else {}
    if body:
        _decide_velocity_frame(draft, moving, true, body)
    against = body if draft.velocity_frame == "body" else true
    for name in names:
        unit, evidence = _velocity_unit(draft, name, against[name] if name in moving else None)
        draft.settle(name, unit, evidence, "certain" if name in moving else "likely")
        found = signals.correlation(draft.values(name), against[name]) if name in moving else 0.0
        if found < -CLEAR:
            draft.suspect(draft.column(name), f"correlation {found:+.2f} with the slope of {name[1]}")


def _velocity_unit(draft: Draft, name: str, true: Series | None) -> tuple[str, str]:
    if named := draft.named_unit(name):
        return named, "the name says so"
    if true is None:
        return "m/s", "too little motion to tell the unit"
    share = signals.ratio(draft.values(name), true)
    unit = unit_by_ratio(share, ("m/s", "cm/s", "mm/s"))
    found = signals.correlation(draft.values(name), true)
    return unit, f"{share:.3g} times the slope of the position in m, correlation {found:+.2f}"


def in_body(draft: Draft, true: dict[str, Series]) -> dict[str, Series]:
    """Slopes of positions in body axes, where the attitude or the heading is known."""
    logs = range(len(draft.looked_at))
    zero = [np.zeros(len(time)) for time in draft.stamps]
    world = [np.stack([true.get(name, zero)[log] for name in ("vx", "vy", "vz")], axis=1) for log in logs]
    if draft.world:
        inverse = [part * np.array([1.0, -1.0, -1.0, -1.0]) for part in draft.world]
    elif draft.heading:
        half = [-0.5 * yaw for yaw in draft.heading]
        inverse = [np.stack([np.cos(a), 0 * a, 0 * a, np.sin(a)], axis=1) for a in half]
    else:
        return {}
    turned = [derive.to_world(inverse[log], world[log]) for log in logs]
    return {name: [part[:, i] for part in turned] for i, name in enumerate(("vx", "vy", "vz"))}


def _explained(draft: Draft, names: list[str], by: dict[str, Series]) -> float:
    """Share of the variance of measured velocities that slopes of positions explain, unit and signs aside."""
    measured = [signals.centred(signals.smooth(draft.values(name))) for name in names]
    expected = [signals.centred(signals.smooth(by[name])) for name in names]
    products = sum(abs(float(a @ b)) for a, b in zip(measured, expected, strict=True))
    sizes = np.linalg.norm(np.concatenate(measured)) * np.linalg.norm(np.concatenate(expected))
    return float((products / sizes) ** 2) if sizes > 0 else 0.0


def _decide_velocity_frame(draft: Draft, names: list[str], true: dict[str, Series], body: dict[str, Series]) -> None:
    in_world, in_body = _explained(draft, names, true), _explained(draft, names, body)
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
    names = [name for name in ("wx", "wy", "wz") if draft.has(name)]
    turning = _turning(draft)
    if not names:
        _suspect_signs(draft, tilt_agreement(draft), {})
        if turning:
            draft.derived.append("rate")
            draft.add("", "body rate", "rad/s", "the log has none: slopes of the attitude", "certain")
        return
    agreement = gyro_agreement(draft) if draft.world else _yaw_agreement(draft, turning)
    unit, evidence = _rate_unit(draft, names, agreement, turning)
    for name in names:
        found = agreement.get(name)
        text = f"correlation {found:+.2f} with the slope of the attitude" if found is not None else "too little turning"
        draft.settle(name, unit, f"{evidence}; {text}", "certain" if found and abs(found) > CLEAR else "guess")
    _suspect_signs(draft, tilt_agreement(draft), agreement)


def _turning(draft: Draft) -> dict[str, Series]:
    if draft.world:
        return {name: [part[:, i] for part in draft.body_rates] for i, name in enumerate(("wx", "wy", "wz"))}
    if draft.heading:
        return {"wz": signals.slopes(draft.stamps, [np.unwrap(part) for part in draft.heading])}
    return {}


def _yaw_agreement(draft: Draft, turning: dict[str, Series]) -> dict[str, float]:
    if "wz" not in turning or not draft.has("wz") or signals.spread(turning["wz"]) < TURNING:
        return {}
    return {"wz": signals.correlation(draft.values("wz"), turning["wz"])}


def _rate_unit(
    draft: Draft, names: list[str], agreement: dict[str, float], turning: dict[str, Series]
) -> tuple[str, str]:
    if named := draft.named_unit(*names):
        return named, "the name says so"
    clear = [name for name in names if abs(agreement.get(name, 0.0)) > WEAK]
    if clear:
        share = float(np.median([signals.ratio(draft.values(n), turning[n]) for n in clear]))
        return unit_by_ratio(share, RATE_UNITS), f"moves {share:.3g} times as much as the attitude in rad/s"
    size = max(signals.largest(draft.values(name)) for name in names)
    return ("deg/s" if size > FASTEST else "rad/s"), f"up to {size:.3g}"


def _suspect_signs(draft: Draft, tilt: dict[str, float], gyro: dict[str, float]) -> None:
    """Angles against accelerations, then rates against the slopes of angles that are taken the right way round."""
    attitude = draft.attitudes.get("attitude", Attitude())
    vertical = 1.0 if draft.frames == "z_up" else -1.0
    reversed_by = {}
    for rate, angle, i in (("wx", "roll", 0), ("wy", "pitch", 1), ("wz", "yaw", 2)):
        pushed = vertical * tilt.get(angle, 0.0)
        if attitude.euler and pushed < -CLEAR:
            reversed_by[rate] = -1.0
            evidence = f"correlation {pushed:+.3f} of the acceleration with what this angle should cause"
            draft.suspect(attitude.euler[i], evidence)
        found = gyro.get(rate, 0.0) * reversed_by.get(rate, 1.0)
        if found < -CLEAR:
            evidence = f"correlation {found:+.3f} with the slope of the attitude"
            agrees = f", which agrees with the acceleration ({pushed:+.2f})" if pushed > CLEAR else ""
            turned = f" after {attitude.euler[i]!r} is reversed" if rate in reversed_by else agrees
            draft.suspect(draft.column(rate), evidence + turned)
    for rate in reversed_by:
        for part in draft.body_rates:
            part[:, "xyz".index(rate[1])] *= -1.0
