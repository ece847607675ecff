"""What a column may be, judged by its name alone: the words that people, ROS, PX4, cflib and MoCap systems use."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from sym2real.logs.units import UNITS

Role = Literal["state", "command", "reference"]

REFERENCE = frozenset({"ref", "reference", "refs"})
WANTED = frozenset({
    "desired", "des", "target", "setpoint", "sp", "goal", "waypoint", "ctrltarget", "traj", "trajectory", "wanted", "d",
})  # fmt: skip
COMMAND = frozenset({
    "cmd", "cmds", "command", "commanded", "commands", "ctrl", "control", "controller", "action", "actions", "input",
    "sent", "teleop", "drive", "ackermann",
})  # fmt: skip

TIME = frozenset({"t", "time", "timestamp", "timestamps", "stamp", "tick", "elapsed", "clock", "epoch", "times"})
BATTERY = frozenset({"vbat", "vbatt", "battery", "batt", "bat", "voltage"})
NOT_VOLTAGE = frozenset({"current", "percent", "percentage", "level", "temperature", "temp", "charge", "remaining"})
FORCE = frozenset({"f", "force"})
TORQUE = frozenset({"torque", "tau", "tor", "moment"})
STEER = frozenset({"steer", "steering", "delta", "steerangle"})
SERVO = frozenset({"servo"})
THRUST = frozenset({"thrust", "collective", "thr"})
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
POSITION = frozenset({"p", "pos", "position", "location", "translation", "coordinate", "xyz"})
ALTITUDE = frozenset({"altitude", "alt", "height"})
EULER = {
    "roll": "roll", "phi": "roll", "pitch": "pitch", "theta": "pitch", "yaw": "yaw", "psi": "yaw", "heading": "yaw",
}  # fmt: skip
AXES = {"x": "x", "y": "y", "z": "z", "w": "w", "n": "x", "e": "y"}
RATE_AXES = AXES | {"roll": "x", "pitch": "y", "yaw": "z", "phi": "x", "theta": "y", "psi": "z", "heading": "z"}

UNIT_WORDS = {
    "deg": "deg", "degree": "deg", "degrees": "deg", "degs": "deg/s", "dps": "deg/s", "rad": "rad", "radians": "rad",
    "rads": "rad/s", "radps": "rad/s", "mrad": "mrad", "mm": "mm", "cm": "cm", "ms": "ms", "msec": "ms", "us": "us",
    "usec": "us", "ns": "ns", "nsec": "ns", "nsecs": "ns", "nanoseconds": "ns", "sec": "s", "secs": "s", "seconds": "s",
    "mps": "m/s", "mv": "mV", "volt": "V", "volts": "V", "newton": "N", "meters": "m", "metres": "m",
}  # fmt: skip
WRITTEN_UNITS = {"°": "deg", "°/s": "deg/s", "µs": "us", "μs": "us", "m/s2": "m/s^2", "m/s²": "m/s^2", "Nm": "N m"}

_COMPOUND = re.compile(r"(pos|p|vel|v|omega|gyro|gyr|w|accel|acc|a|quat|q|force|f|torque|tau|tor|d)_?([wxyz])")
_REVERSED = re.compile(r"([xyz])_?(pos|vel|dot|acc|gyro)")
_ANGLE_RATE = re.compile(r"(roll|pitch|yaw|phi|theta|psi|heading)(rate|speed|dot|vel)")
_NUMBERED = re.compile(r"([a-z]+)(\d)")


@dataclass(frozen=True)
class Named:
    """What a name says.

    Args:
        quantity: "time", "position", "velocity", "rate", "acceleration", "quaternion", "roll", "pitch", "yaw",
            "motor", "thrust", "throttle", "steer", "speed", "battery", "force", "torque" or "letter" (p, q, r).
        axis: "x", "y", "z", "w", a digit where the name only counts, or "".
        role: measured, sent or wanted.
        unit: unit that the name states, or "".
    """

    quantity: str
    axis: str = ""
    role: Role = "state"
    unit: str = ""


def read_name(name: str) -> Named | None:
    """What a column's name says; None where it says nothing that is known here."""
    words, unit = _words(name)
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
    if quantity in {"position", "velocity", "acceleration"} and role == "command":
        role = "reference"
    if quantity in {"thrust", "throttle", "motor", "steer"}:
        role = "command"
    return Named(quantity, axis, role, _unit_of(quantity, unit))


def _words(name: str) -> tuple[list[str], str]:
    text = re.sub(r"\[(\d+)\]", r".\1", name)
    unit = ""
    if bracket := re.search(r"[\[(]([^\])]+)[\])]", text):
        written = bracket.group(1).strip()
        unit = WRITTEN_UNITS.get(written, written if written in UNITS else UNIT_WORDS.get(written.lower(), ""))
        text = text.replace(bracket.group(0), "")
    # cflib's compressed estimate carries a Z that is no axis.
    text = re.sub(r"(?i)state_?estimatez?\b", "", text)
    text = re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", text)
    words: list[str] = []
    for word in (part for part in re.split(r"[^a-z0-9]+", text.lower()) if part):
        words += _split(word)
    if not unit and len(words) > 1 and words[-1] in UNIT_WORDS:
        unit = UNIT_WORDS[words.pop()]
    if "rpm" in words:
        unit = unit or "rpm"
    return words, unit


def _split(word: str) -> list[str]:
    if match := _COMPOUND.fullmatch(word):
        stem, axis = match.groups()
        return ["dot" if stem == "d" else stem, axis]
    if match := _REVERSED.fullmatch(word):
        return [match.group(2), match.group(1)]
    if match := _ANGLE_RATE.fullmatch(word):
        return [match.group(1), "rate"]
    if match := _NUMBERED.fullmatch(word):
        return [match.group(1), match.group(2)]
    return [word]


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
    return ("motor", name.digit) if name.has(MOTOR) and name.digit else None


def _wrench(name: _Words) -> Found:
    if name.has(FORCE) and name.counted:
        return "force", name.counted
    return ("torque", name.counted) if name.has(TORQUE) and name.counted else None


def _rate(name: _Words) -> Found:
    turning = name.has(RATE) or (bool(name.angle) and name.has(VELOCITY))
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


def _velocity(name: _Words) -> Found:
    if not name.has(VELOCITY) or name.angle:
        return None
    return ("velocity", name.counted) if name.counted else ("speed", "") if not name.axis else None


def _angle(name: _Words) -> Found:
    return (name.angle, "") if name.angle else None


def _position(name: _Words) -> Found:
    if name.has(ALTITUDE):
        return "position", "z"
    return ("position", name.counted) if name.counted and (name.has(POSITION) or not name.axis.isdigit()) else None


def _letter(name: _Words) -> Found:
    """Aeronautics' p, q, r, which mean rates only where all three are there."""
    return ("letter", name.words[0]) if name.words in {("p",), ("q",), ("r",)} else None


def _time(name: _Words) -> Found:
    return ("time", "") if name.has(TIME) and not name.axis else None


# In this order: "local_position/pose/orientation.x" is an attitude, "attitude_rate.x" a rate.
RULES = (_electric, _command, _wrench, _rate, _acceleration, _quaternion, _velocity, _angle, _position, _letter, _time)


def _unit_of(quantity: str, unit: str) -> str:
    """The unit a suffix means for this quantity: ``_ms`` is milliseconds on a stamp, m/s on a velocity."""
    if quantity in {"velocity", "speed"}:
        return {"ms": "m/s", "mm": "mm/s", "cm": "cm/s"}.get(unit, unit)
    if quantity == "steer":
        # A servo's pulse is no angle: its size says so.
        return "" if unit == "us" else unit
    if quantity == "rate":
        return {"deg": "deg/s", "rad": "rad/s", "mrad": "mrad/s"}.get(unit, unit)
    return unit
