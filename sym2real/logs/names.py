"""What a column may be, judged by its name alone: the words that people, ROS, PX4, cflib and MoCap systems use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sym2real.logs.name_words import BATTERY, FORCE, THRUST, TORQUE, words_and_unit

Role = Literal["state", "command", "reference"]

REFERENCE = frozenset({"ref", "reference", "refs"})
WANTED = frozenset({
    "desired", "des", "target", "setpoint", "sp", "goal", "waypoint", "ctrltarget", "traj", "trajectory", "wanted", "d",
    "set",
})  # fmt: skip
COMMAND = frozenset({
    "cmd", "cmds", "command", "commanded", "commands", "ctrl", "control", "controller", "action", "actions", "input",
    "sent", "teleop", "drive", "ackermann", "u",
})  # fmt: skip

TIME = frozenset({"t", "time", "timestamp", "timestamps", "stamp", "tick", "elapsed", "clock", "epoch", "times"})
NOT_VOLTAGE = frozenset({"current", "percent", "percentage", "level", "temperature", "temp", "charge", "remaining"})
STEER = frozenset({"steer", "steering", "delta", "steerangle"})
SERVO = frozenset({"servo"})
THROTTLE = frozenset({"throttle"})
MOTOR = frozenset({
    "motor", "motors", "m", "rotor", "rotors", "prop", "props", "propeller", "pwm", "esc", "actuator", "actuators",
    "output", "outputs", "rpm",
})  # fmt: skip
RATE = frozenset(
    {"w", "omega", "gyro", "gyr", "gyroscope", "ang", "rate", "rates", "angvel", "angular", "bodyrate", "bodyrates"}
)
ACCELERATION = frozenset({"a", "acc", "accel", "acceleration", "accelerometer", "accelerations"})
QUATERNION = frozenset({"q", "quat", "quaternion", "orientation", "rotation", "attitude", "att"})
VELOCITY = frozenset({"v", "vel", "velocity", "velocities", "twist", "linvel", "dot", "speed"})
WHEEL, TURNS = frozenset({"wheel", "wheels", "tacho", "tachometer"}), frozenset({"rpm", "erpm"})
POSITION = frozenset({"p", "pos", "position", "location", "translation", "coordinate", "xyz"})
# Rotors in the order of the standard columns, named by where they sit.
CORNERS = {"fr": "1", "rr": "2", "br": "2", "rl": "3", "bl": "3", "fl": "4"}
ALTITUDE = frozenset({"altitude", "alt", "height"})
EULER = {
    "roll": "roll", "phi": "roll", "pitch": "pitch", "theta": "pitch", "yaw": "yaw", "psi": "yaw", "heading": "yaw",
}  # fmt: skip
AXES = {"x": "x", "y": "y", "z": "z", "w": "w", "n": "x", "e": "y"}
EULER_AXES = {"roll": "x", "pitch": "y", "yaw": "z"}
RATE_AXES = AXES | {word: EULER_AXES[angle] for word, angle in EULER.items()}
# What a quantity is whose unit is one of change.
OF_A_SECOND = {"position": "velocity", "roll": "rate", "pitch": "rate", "yaw": "rate"}


@dataclass(frozen=True)
class Named:
    """What a name says.

    Args:
        quantity: "time", "position", "velocity", "rate", "acceleration", "quaternion", "roll", "pitch", "yaw",
            "motor", "thrust", "throttle", "steer", "speed", "wheel speed", "battery", "force", "torque" or "letter"
            (p, q, r).
        axis: "x", "y", "z", "w", a digit where the name only counts, or "".
        role: measured, sent or wanted.
        unit: unit that the name states, or "".
        counted: whether the axis is a number in the name.
    """

    quantity: str
    axis: str = ""
    role: Role = "state"
    unit: str = ""
    counted: bool = False


def read_name(name: str) -> Named | None:
    """What a column's name says; None where it says nothing that is known here."""
    words, unit = words_and_unit(name)
    role: Role = "state"
    if COMMAND.intersection(words) or WANTED.intersection(words):
        role = "command"
    if REFERENCE.intersection(words):
        role = "reference"
    rest = _Words(tuple(word for word in words if word not in COMMAND | WANTED | REFERENCE))
    found = next((found for rule in RULES if (found := rule(rest))), None)
    if found is None:
        return None
    quantity, axis = found
    if unit.endswith("/s"):
        quantity, axis = OF_A_SECOND.get(quantity, quantity), EULER_AXES.get(quantity, axis)
    if quantity in {"position", "velocity", "acceleration"} and role == "command":
        role = "reference"
    if quantity in {"thrust", "throttle", "motor", "steer"}:
        role = "command"
    counted = bool(rest.digit and axis) and rest.axis == rest.digit and quantity != "quaternion"
    return Named(quantity, axis, role, _unit_of(quantity, unit), counted and axis in {"x", "y", "z"})


Found = tuple[str, str] | None


@dataclass(frozen=True)
class _Words:
    """The words of a name without those of its role, and the axis among them."""

    words: tuple[str, ...]

    def has(self, *vocabulary: frozenset[str]) -> bool:
        return any(vocabulary_part.intersection(self.words) for vocabulary_part in vocabulary)

    @property
    def digit(self) -> str:
        digits = [word for word in self.words if word.isdigit() and len(word) == 1]
        return digits[-1] if digits else ""

    @property
    def axis(self) -> str:
        """A letter x, y, z, w, else a digit, else nothing."""
        letters = [AXES[word] for word in self.words if word in AXES]
        return letters[-1] if letters else self.digit

    @property
    def counted(self) -> str:
        """x, y or z, where 0, 1, 2 count as such; else nothing."""
        axis = "xyz"[int(self.axis)] if self.axis in {"0", "1", "2"} else self.axis
        return axis if axis in {"x", "y", "z"} else ""

    @property
    def corner(self) -> str:
        """Number of the rotor that sits there; else nothing."""
        sides = [side[0] for side in ("front", "rear", "back", "left", "right") if side in self.words]
        return next((CORNERS[word] for word in (*self.words, "".join(sides)) if word in CORNERS), "")

    @property
    def angle(self) -> str:
        angles = [EULER[word] for word in self.words if word in EULER]
        return angles[-1] if angles else ""


def _electric(name: _Words) -> Found:
    return ("battery", "") if name.has(BATTERY) and not name.has(NOT_VOLTAGE) else None


def _command(name: _Words) -> Found:
    if name.has(STEER) and not name.has(RATE, VELOCITY):
        return "steer", ""
    if name.has(SERVO) and not name.digit:
        return "steer", ""
    if name.has(THRUST) and name.axis in {"", "z", "2"}:
        return "thrust", ""
    if name.has(THROTTLE):
        return "throttle", ""
    if name.has(MOTOR) or (name.corner and name.has(RATE, FORCE)):
        return ("motor", place) if (place := name.corner or name.digit) else None
    return None


def _wrench(name: _Words) -> Found:
    """By a letter: what is counted are joints, or rotors."""
    axis = "" if name.axis.isdigit() or name.axis == "w" else name.axis
    if name.has(FORCE) and axis:
        return "force", axis
    return ("torque", axis) if name.has(TORQUE) and axis else None


def _rate(name: _Words) -> Found:
    # In "vel_w_x" the w is the world.
    turning = name.has(RATE - {"w"} if name.has(VELOCITY, POSITION) else RATE) or (
        bool(name.angle) and name.has(VELOCITY)
    )
    if not turning or name.has(frozenset({"derivative"}), ACCELERATION):
        return None
    axes = [RATE_AXES[word] for word in name.words if word in RATE_AXES and word != "w"]
    axis = axes[-1] if axes else name.counted
    # A car logs its only rate without an axis.
    return ("rate", axis or "z") if axis or name.has(frozenset({"omega", "angular", "gyro"})) else None


def _acceleration(name: _Words) -> Found:
    return ("acceleration", name.counted) if name.has(ACCELERATION) and name.counted else None


def _quaternion(name: _Words) -> Found:
    return ("quaternion", name.axis) if name.has(QUATERNION) and name.axis and not name.angle else None


def _wheel(name: _Words) -> Found:
    counted = name.has(frozenset({"tacho", "tachometer"})) or name.has(VELOCITY, TURNS)
    return ("wheel speed", "") if name.has(WHEEL) and counted and not name.axis else None


def _velocity(name: _Words) -> Found:
    if not name.has(VELOCITY) or name.angle or name.has(STEER):
        return None
    return ("velocity", name.counted) if name.counted else ("speed", "") if not name.axis else None


def _angle(name: _Words) -> Found:
    return (name.angle, "") if name.angle else None


def _position(name: _Words) -> Found:
    if name.has(ALTITUDE):
        return "position", "z"
    return ("position", name.counted) if name.counted and (name.has(POSITION) or not name.axis.isdigit()) else None


def _letter(name: _Words) -> Found:
    """Aeronautics' p, q, r, alone or behind a word for rates, which mean axes only where all three are there."""
    left = tuple(word for word in name.words if word not in RATE - {"w"})
    return ("letter", left[0]) if left in {("p",), ("q",), ("r",)} else None


def _time(name: _Words) -> Found:
    return ("time", "") if name.has(TIME) and not name.axis else None


# In this order: "local_position/pose/orientation.x" is an attitude, "attitude_rate.x" a rate.
RULES = (
    _electric, _command, _wrench, _wheel, _letter, _rate, _acceleration, _quaternion, _velocity, _angle, _position,
    _time,
)  # fmt: skip


def _unit_of(quantity: str, unit: str) -> str:
    """The unit a suffix means for this quantity: ``_ms`` is milliseconds on a stamp, m/s on a velocity."""
    if quantity in {"velocity", "speed", "wheel speed"}:
        return {"ms": "m/s", "mm": "mm/s", "cm": "cm/s"}.get(unit, unit)
    if quantity == "steer":
        # A servo's pulse is no angle: its size says so.
        return "" if unit == "us" else unit
    if quantity == "rate":
        return {"deg": "deg/s", "rad": "rad/s", "mrad": "mrad/s"}.get(unit, unit)
    return unit
