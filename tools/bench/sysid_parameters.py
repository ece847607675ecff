"""What ``mujoco.sysid`` may change of the plain robots, by name, and which effect of the catalogue each of these is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from sym2real.robots.crazyflie import INERTIA, MASS, RATE_GAINS

STEER = ("front_left_steer", "front_right_steer")
SPIN = ("front_left_spin", "front_right_spin", "rear_left_spin", "rear_right_spin")
STIFFNESS, WHEEL_GAIN = 5.0, 0.02  # N m/rad and N m s/rad of the car's servos
CHASSIS = 2.9  # kg
# m: MuJoCo puts a centre of mass that is nearer to the frame's origin into it, where no derivative is.
OFF_CENTRE = 1e-4


@dataclass(frozen=True)
class Free:
    """One number of a description.

    Args:
        nominal, low, high: in the unit of the description, or as a factor.
        write: puts a value into an ``MjSpec``.
        key, parameter: effect that a change of it is, and its parameter; "" where none is.
        of_effect: the effect's value from the number's.
        off: how far from the nominal value a fit begins, where small steps from that change nothing.
    """

    nominal: float
    low: float
    high: float
    write: Callable[[Any, float], None]
    key: str = ""
    parameter: str = "value"
    of_effect: Callable[[float], float] = lambda value: value
    off: float = 0.0

    def change(self, value: float) -> float:
        """How far a value is from the nominal one, relative to that; relative to half of its range for zero."""
        return abs(value - self.nominal) / (abs(self.nominal) or 0.5 * (self.high - self.low))


def _mass(spec: Any, value: float) -> None:
    """As a value of its own, as all here: ``mujoco.sysid`` writes into one spec again and again."""
    spec.worldbody.first_body().mass = value


def _centre(axis: int) -> Callable[[Any, float], None]:
    def write(spec: Any, value: float) -> None:
        place = np.array(spec.worldbody.first_body().ipos)
        place[axis] = value
        spec.worldbody.first_body().ipos = place

    return write


def _inertia(spec: Any, value: float) -> None:
    """One factor: moments by themselves leave what a rigid body can have."""
    spec.worldbody.first_body().inertia = value * np.array(INERTIA)


def _actuators(names: tuple[str, ...], gain: float, *, bias: int | None = None) -> Callable[[Any, float], None]:
    """A factor on the gain of actuators, and on their feedback where that follows the command's unit."""

    def write(spec: Any, value: float) -> None:
        for actuator in (one for one in spec.actuators if one.name in names):
            actuator.gainprm = [value * gain, *([0.0] * 9)]
            if bias is not None:
                feedback = np.array(actuator.biasprm)
                feedback[bias] = -value * gain
                actuator.biasprm = feedback

    return write


def _loop(axis: int) -> Callable[[Any, float], None]:
    return _actuators((f"w{'xyz'[axis]}",), INERTIA[axis] * RATE_GAINS[axis], bias=2)


def _offset(spec: Any, value: float) -> None:
    for actuator in (one for one in spec.actuators if one.name in STEER):
        feedback = np.array(actuator.biasprm)
        feedback[0] = STIFFNESS * value
        actuator.biasprm = feedback


def _friction(spec: Any, value: float) -> None:
    for geom in spec.geoms:
        geom.friction = [value, *list(geom.friction)[1:]]


def _chassis(spec: Any, value: float) -> None:
    next(geom for geom in spec.geoms if geom.name == "chassis").mass = value


FREE: dict[str, dict[str, Free]] = {
    "crazyflie": {
        "mass": Free(MASS, 0.02, 0.04, _mass, "added_mass", of_effect=lambda value: value - MASS),
        "centre x": Free(0.0, -0.01, 0.01, _centre(0), "com_offset", "rx", off=OFF_CENTRE),
        "centre y": Free(0.0, -0.01, 0.01, _centre(1), "com_offset", "ry", off=OFF_CENTRE),
        "inertia": Free(1.0, 0.5, 2.0, _inertia),
        "thrust gain": Free(1.0, 0.5, 1.5, _actuators(("thrust",), 1.0), "gain:thrust"),
        **{f"loop gain {name}": Free(1.0, 0.5, 2.0, _loop(axis)) for axis, name in enumerate("xyz")},
    },
    "mushr": {
        "chassis": Free(CHASSIS, 1.5, 6.0, _chassis),
        "friction": Free(1.0, 0.1, 2.0, _friction, "tyre_friction"),
        "steering gain": Free(1.0, 0.5, 1.5, _actuators(STEER, STIFFNESS), "gain:steer"),
        "steering offset": Free(0.0, -0.3, 0.3, _offset, "offset:steer"),
        "speed gain": Free(1.0, 0.5, 1.5, _actuators(SPIN, WHEEL_GAIN), "gain:speed"),
    },
}
