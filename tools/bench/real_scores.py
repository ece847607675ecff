"""What diagnoses of the measured logs are worth: one figure per bar of the issue."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from figures import Figure

from sym2real import rotation
from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, Finding
from sym2real.robots.robot import GRAVITY
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Trajectory

# Delays of the car count whether they are shifts or first-order.
DELAYS = ("delay", "lag")
TRIM_GROUP = {"mounting_tilt", "wind"}


@dataclass(frozen=True, eq=False)
class Answer:
    """A diagnosis of logs: their title, the base's, what was found, in what, in which equations."""

    title: str
    base: str
    found: Diagnosis
    data: Dataset
    equations: Equations

    def finding(self, *keys: str) -> Finding | None:
        """The most important finding that is one of these effects."""
        return next((one for one in self.found.findings if one.effect in keys), None)

    def value(self, key: str, parameter: str = "value") -> float:
        """A parameter of a finding; nan where it was not found."""
        one = self.finding(key)
        return one.parameters[parameter].value if one and parameter in one.parameters else float("nan")

    def place(self, *keys: str) -> int:
        """Place among the findings of the first of these effects, from 1 on; 0 where there is none."""
        return next((n for n, one in enumerate(self.found.findings, 1) if one.effect in keys), 0)

    def error(self, stage: int, horizon: float, channel: str) -> float:
        """Held-out error of a step of the ladder (-1 for the last)."""
        return self.found.ladder[stage].horizons[horizon][channel].value

    def figure(self, name: str, value: float, unit: str, bar: str = "") -> Figure:
        """A figure of this diagnosis."""
        return Figure(f"{self.title}, {self.base}: {name}", float(value), unit, bar)

    def claim(self, name: str, holds: bool) -> Figure:
        """A figure that is 1 where something is as it should be."""
        return self.figure(name, holds, "1", ">= 1")


def penny_figures(answers: Sequence[Answer]) -> list[Figure]:
    """Sign, mass, lag, trim and the fall of the error, for every base."""
    figures = []
    for one in answers:
        mass, gain = one.equations.numbers["mass"], one.value("gain:thrust")
        added = one.value("added_mass")
        first = one.found.findings[0] if one.found.findings else None
        group = set(first.group) if first else set()
        trim = one.finding(*TRIM_GROUP)
        figures += [
            one.claim("sign of wy flagged", "sensor_sign:wy" in {fault.effect for fault in one.found.faults}),
            one.figure("thrust over mass", gain if np.isnan(added) else mass / (mass + added), "1", "0.64 to 0.69"),
            one.claim("mass or thrust gain first, as one group", {"added_mass", "gain:thrust"} <= group),
            one.claim("lag named", one.place("motor_lag", "delay", "lag") > 0),
            one.claim("trim named, tilt and wind as one group", trim is not None and set(trim.group) >= TRIM_GROUP),
            one.figure(
                "fall of the 0.8 s position error",
                1 - one.error(-1, 0.8, "position") / one.error(0, 0.8, "position"),
                "1",
                ">= 0.9",
            ),
        ]
    return figures


def car_figures(answers: Sequence[Answer]) -> list[Figure]:
    """The bars for either base, the one that predicts better first, and the gap between them."""
    best, *others = sorted(answers, key=lambda one: one.error(-1, 1.0, "position"))
    figures = [row for one in (best, *others) for row in _car_rows(one)]
    for one in others:
        for channel, unit in (("position", "m"), ("yaw", "rad")):
            gap = one.error(-1, 1.0, channel) - best.error(-1, 1.0, channel)
            figures.append(one.figure(f"1 s {channel} error beyond the other base's", gap, unit))
    return figures


def _car_rows(one: Answer) -> list[Figure]:
    """Limit, offset, delays, mounting and errors."""
    limit, gain = one.place("limit:speed"), one.place("gain:speed")
    mounting = one.finding("lever_arm", "yaw_bias")
    return [
        one.figure("speed limit", one.value("limit:speed", "upper"), "m/s", "0.84 to 0.89"),
        one.claim("speed limit before any speed gain", limit > 0 and (gain == 0 or limit < gain)),
        one.figure("steering offset", one.value("offset:steer"), "rad", "0.08 to 0.13"),
        *(one.figure(f"delay of {name}", _delay(one, name), "s", "0.15 to 0.25") for name in ("speed", "steer")),
        one.claim(
            "yaw bias and lever arm as one group",
            mounting is not None and {"yaw_bias", "lever_arm"} <= set(mounting.group),
        ),
        one.figure("1 s position error", one.error(-1, 1.0, "position"), "m", "<= 0.13"),
        one.figure("1 s position error before", one.error(0, 1.0, "position"), "m"),
        one.figure("1 s yaw error", one.error(-1, 1.0, "yaw"), "rad", "<= 0.15"),
        one.figure("1 s yaw error before", one.error(0, 1.0, "yaw"), "rad"),
    ]


def _delay(one: Answer, command: str) -> float:
    """Delay and, where there is none, lag of a command with that of all commands, s."""
    for kind in DELAYS:
        values = [one.value(key) for key in (kind, f"{kind}:{command}")]
        if not np.isnan(values).all():
            return float(np.nansum(values))
    return float("nan")


def wind_figures(answers: Sequence[Answer]) -> list[Figure]:
    """Force and drag where there is wind; the thrust curve, and no more than trim, where there is none."""
    figures = []
    for one in answers:
        residual = mean_residual(one.data[0])
        side = one.finding(*TRIM_GROUP)
        if "nowind" in one.title:
            figures += [
                one.claim("thrust curve first", one.place("thrust_curve") == 1),
                one.figure("side force", _side_force(side), "m/s²", "<= 0.6"),
                one.claim("side force as one group", side is None or set(side.group) >= TRIM_GROUP),
            ]
            continue
        allowed = max(0.1 * abs(residual[0]), 0.3)
        figures += [
            one.claim("constant force along -x first", one.place("wind") == 1 and one.value("wind", "fx") < 0),
            one.figure(
                f"force less the mean residual of {residual[0]:.2f}",
                abs(one.value("wind", "fx") - residual[0]),
                "m/s²",
                f"<= {allowed:.2f}",
            ),
            one.claim("drag second", one.place("linear_drag", "quadratic_drag") == 2),
        ]
    return figures


def _side_force(side: Finding | None) -> float:
    """Acceleration that a wind on 1 kg, or a tilt in hover, stands for, m/s²."""
    if side is None:
        return 0.0
    values = side.values
    if side.effect == "wind":
        return float(np.hypot(values["fx"], values["fy"]))
    return GRAVITY * float(np.hypot(values["roll"], values["pitch"]))


def mean_residual(log: Trajectory) -> Array:
    """Mean of a - R e₃ T + g over a flight with thrust per unit of mass ``# (3,)``, m/s²."""
    quaternion = np.stack([log.column(name) for name in ("qw", "qx", "qy", "qz")], axis=1)
    axis = rotation.rotate(torch.as_tensor(quaternion), torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64)).numpy()
    velocity = np.stack([log.column(name) for name in ("vx", "vy", "vz")], axis=1)
    residual = np.gradient(velocity, log.time, axis=0) - axis * log.column("thrust")[:, None]
    return residual.mean(axis=0) + np.array([0.0, 0.0, GRAVITY])


def battery_figures(answers: Sequence[Answer]) -> list[Figure]:
    """Drag over mass along both axes, and sag with the voltage."""
    figures = []
    for one in answers:
        mass, sag = one.equations.numbers["mass"], one.finding("battery_sag")
        figures += [
            one.figure(f"linear drag over mass, {name[1]}", one.value("linear_drag", name) / mass, "1/s", "0.3 to 0.5")
            for name in ("cx", "cy")
        ]
        figures.append(one.claim("battery sag named", sag is not None))
        figures.append(one.figure("battery sag", one.value("battery_sag"), "1/V"))
    return figures
