"""What a column may be, judged by its name alone: the words that people, ROS, PX4, cflib and MoCap systems use."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
TACHOMETER, TURNS = frozenset({"tacho", "tachometer"}), frozenset({"rpm", "erpm"})
WHEEL = TACHOMETER | {"wheel", "wheels"}
ALONE, DERIVATIVE = frozenset({"omega", "angular", "gyro"}), frozenset({"derivative"})
POSITION = frozenset({"p", "pos", "position", "location", "translation", "coordinate", "xyz"})
# Rotors in the order of the standard columns, named by where they sit.
CORNERS = {"fr": "1", "rr": "2", "br": "2", "rl": "3", "bl": "3", "fl": "4"}
ALTITUDE = frozenset({"altitude", "alt", "height"})
EULER = {
    "roll": "roll", "phi": "roll", "pitch": "pitch", "theta": "pitch", "yaw": "yaw", "psi": "yaw", "heading": "yaw",
    "compass": "yaw", "azimuth": "yaw", "bearing": "yaw",
}  # fmt: skip
AXES = {"x": "x", "y": "y", "z": "z", "w": "w", "n": "x", "e": "y"}
EULER_AXES = {"roll": "x", "pitch": "y", "yaw": "z"}
RATE_AXES = AXES | {word: EULER_AXES[angle] for word, angle in EULER.items()}
COUNTED = {"0": "x", "1": "y", "2": "z"}
# What a unit means of some quantities: ``_ms`` is milliseconds on a stamp; a servo's pulse is no angle.
SPEEDS = {"ms": "m/s", "mm": "mm/s", "cm": "cm/s"}
MEANT: Mapping[str, Mapping[str, str]] = {
    **dict.fromkeys(("velocity", "speed", "wheel speed"), SPEEDS),
    "steer": {"us": ""},
    "rate": {"deg": "deg/s", "rad": "rad/s", "mrad": "mrad/s"},
}
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
    found = _quantity([word for word in words if word not in COMMAND | WANTED | REFERENCE])
    if found is None:
        return None
    quantity, axis, counted = found
    if unit.endswith("/s"):
        quantity, axis = OF_A_SECOND.get(quantity, quantity), EULER_AXES.get(quantity, axis)
    if quantity in {"position", "velocity", "acceleration"} and role == "command":
        role = "reference"
    if quantity in {"thrust", "throttle", "motor", "steer"}:
        role = "command"
    counted = counted and quantity != "quaternion" and axis in {"x", "y", "z"}
    return Named(quantity, axis, role, MEANT.get(quantity, {}).get(unit, unit), counted)


def _quantity(words: Sequence[str]) -> tuple[str, str, bool] | None:
    """Quantity, axis, and whether that is a number, by the words of a name without those of its role."""

    def has(*vocabulary: frozenset[str]) -> bool:
        return any(part.intersection(words) for part in vocabulary)

    def last(known: Mapping[str, str], *left_out: str) -> str:
        return ([known[word] for word in words if word in known and word not in left_out] or [""])[-1]

    digit = ([word for word in words if word.isdigit() and len(word) == 1] or [""])[-1]
    letter, angle = last(AXES), last(EULER)
    axis = letter or digit
    along = axis if axis in {"x", "y", "z"} else COUNTED.get(axis, "")
    pushed = "" if letter == "w" else letter
    sides = "".join(side[0] for side in ("front", "rear", "back", "left", "right") if side in words)
    corner = next((CORNERS[word] for word in (*words, sides) if word in CORNERS), "")
    # In "vel_w_x" the w is the world.
    turning = has(RATE - {"w"} if has(VELOCITY, POSITION) else RATE) or (bool(angle) and has(VELOCITY))
    about = last(RATE_AXES, "w") or along
    left = [word for word in words if word not in RATE - {"w"}]
    # In this order: "local_position/pose/orientation.x" is an attitude, "attitude_rate.x" a rate.
    rules = (
        ("battery", has(BATTERY) and not has(NOT_VOLTAGE), ""),
        ("steer", (has(STEER) and not has(RATE, VELOCITY)) or (has(SERVO) and not digit), ""),
        ("thrust", has(THRUST) and axis in {"", "z", "2"}, ""),
        ("throttle", has(THROTTLE), ""),
        ("motor", has(MOTOR) and (corner or digit), corner or digit),
        ("motor", corner and has(RATE, FORCE), corner),
        # By a letter: what is counted are joints, or rotors.
        ("force", has(FORCE) and pushed, pushed),
        ("torque", has(TORQUE) and pushed, pushed),
        ("wheel speed", has(WHEEL) and (has(TACHOMETER) or has(VELOCITY, TURNS)) and not axis, ""),
        # Aeronautics' p, q, r, alone or behind a word for rates, which mean axes only where all three are there.
        ("letter", left in (["p"], ["q"], ["r"]), "".join(left)),
        # A car logs its only rate without an axis.
        ("rate", turning and not has(DERIVATIVE, ACCELERATION) and (about or has(ALONE)), about or "z"),
        ("acceleration", has(ACCELERATION) and along, along),
        ("quaternion", has(QUATERNION) and axis and not angle, axis),
        ("velocity", has(VELOCITY) and not angle and not has(STEER) and along, along),
        ("speed", has(VELOCITY) and not angle and not has(STEER) and not axis, ""),
        (angle, angle, ""),
        ("position", has(ALTITUDE), "z"),
        ("position", along and (has(POSITION) or letter), along),
        ("time", has(TIME) and not axis, ""),
    )
    return next(((quantity, where, bool(digit) and axis == digit) for quantity, holds, where in rules if holds), None)
