"""Attitudes, headings and velocities in another frame than the package's, turned back."""

from __future__ import annotations

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.agreement import VELOCITIES, thrust_agreement, velocity_agreement
from sym2real.diagnosis.data.heading import against_the_path
from sym2real.diagnosis.faults.fault import Fault, Settled
from sym2real.diagnosis.faults.mistakes.transformation import FromWorld, OtherAxes, of_all, present
from sym2real.diagnosis.settings import SETTINGS


def attitude_frame(data: Dataset) -> Settled:
    """Quaternions that turn from world to body."""
    agreement = thrust_agreement(list(data))
    if agreement.verdict not in ("other frame", "reversed") or (agreement.in_other_frame or 0.0) <= SETTINGS.agreeing:
        return (), data
    evidence = (
        f"the direction of thrust that the attitude gives and the measured acceleration correlate by "
        f"{agreement.correlation:.2f}, with the attitude turned the other way by {agreement.in_other_frame:.2f}"
    )
    return [Fault("", evidence, FromWorld.fix)], of_all(FromWorld(), data)


def heading_direction(data: Dataset) -> Settled:
    """Headings that turn against the path."""
    turning = against_the_path(data)
    if turning is None:
        return (), data
    evidence = (
        f"a heading that turns against the path: with its sign reversed it turns with it ({turning.together:.2f} of 1, "
        f"as it stands {turning.as_it_stands:.2f})"
    )
    zero = f" and give it a zero of {turning.apart:.2f} rad (in its unit)" if turning.apart else ""
    fix = f"change the sign of yaw: flip its column in the log's specification{zero}"
    return [Fault("", evidence, fix)], Dataset(turning.undone(log) for log in data)


def velocity_frame(data: Dataset) -> Settled:
    """Velocities along body axes."""
    found = {
        name: agreement
        for name, agreement in velocity_agreement(list(data)).items()
        if agreement.verdict == "other frame"
    }
    if not found:
        return (), data
    (name, agreement), *_ = found.items()
    evidence = (
        f"the logged {name} and the position's derivative correlate by {agreement.correlation:.2f}, turned from body "
        f"to world axes by {agreement.in_other_frame:.2f}"
    )
    in_body = OtherAxes(present(data, VELOCITIES), "body")
    return [Fault("", evidence, in_body.fix)], of_all(in_body, data)
