"""What a column may be, judged by its name alone: the words that people, ROS, PX4, cflib and MoCap systems use."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from sym2real.logs.name_words import TABLES, WORDS, words_and_unit

Role = Literal["state", "command", "reference"]

EULER = {word: angle for angle, words in TABLES["angles"].items() for word in words}
# Rotors in the order of the standard columns, by the words for where they sit.
CORNERS = {word: number for number, words in TABLES["corners"].items() for word in words}
OF_ROLES = WORDS["command"] | WORDS["wanted"] | WORDS["reference"]
AXES = {"x": "x", "y": "y", "z": "z", "w": "w", "n": "x", "e": "y"}
EULER_AXES = {"roll": "x", "pitch": "y", "yaw": "z"}
RATE_AXES = AXES | {word: EULER_AXES[angle] for word, angle in EULER.items()}
# What a delta is a change of: without these it is how a car steers.
CHANGED = {"x", "y", "z", "n", "e", "xy", "vxy", "vz", "q", "alt", "t", *EULER}
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
            "motor", "thrust", "throttle", "steer", "speed", "wheel speed", "battery", "force", "torque" or
            "pull" (an acceleration of no axis).
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
    # Of an angle, and no angle; about a measurement, and none: whether it is valid, how often it was reset, its change.
    changed = "delta" in words and not CHANGED.isdisjoint(words)
    if changed or (WORDS["circular"] | WORDS["about"]).intersection(words):
        return None
    role: Role = "state"
    if (WORDS["command"] | WORDS["wanted"]).intersection(words):
        role = "command"
    if WORDS["reference"].intersection(words):
        role = "reference"
    left = [word for word in words if word not in OF_ROLES]
    # A stamp is a small t.
    match = ("thrust", "", False) if left == ["t"] and role == "command" and "T" in name else _quantity(left)
    if match is None:
        return None
    quantity, axis, counted = match
    if unit.endswith("/s"):
        quantity, axis = OF_A_SECOND.get(quantity, quantity), EULER_AXES.get(quantity, axis)
    if quantity in {"position", "velocity", "acceleration"} and role == "command":
        role = "reference"
    if quantity in {"thrust", "throttle", "motor", "steer"}:
        role = "command"
    counted = counted and quantity != "quaternion" and axis in {"x", "y", "z"}
    return Named(quantity, axis, role, MEANT.get(quantity, {}).get(unit, unit), counted)


def is_time(name: str) -> bool:
    """Whether a column's name says that it holds stamps."""
    named = read_name(name)
    return named is not None and named.quantity == "time"


def _quantity(words: Sequence[str]) -> tuple[str, str, bool] | None:
    """Quantity, axis, and whether that is a number, by the words of a name without those of its role."""

    def has(*meanings: str) -> bool:
        return any(WORDS[meaning].intersection(words) for meaning in meanings)

    def last(known: Mapping[str, str], *left_out: str) -> str:
        return ([known[word] for word in words if word in known and word not in left_out] or [""])[-1]

    digit = ([word for word in words if word.isdigit() and len(word) == 1] or [""])[-1]
    letter, angle = last(AXES), last(EULER)
    axis = letter or digit
    along = axis if axis in {"x", "y", "z"} else COUNTED.get(axis, "")
    force_axis = "" if letter == "w" else letter
    sides = "".join(side[0] for side in ("front", "rear", "back", "left", "right") if side in words)
    corner = next((CORNERS[word] for word in (*words, sides) if word in CORNERS), "")
    # In "vel_w_x" the w is the world.
    of_rates = WORDS["rate"] - {"w"} if has("velocity", "position") else WORDS["rate"]
    turning = bool(of_rates.intersection(words)) or (bool(angle) and has("velocity"))
    about = last(RATE_AXES, "w") or along
    # In this order: "local_position/pose/orientation.x" is an attitude, "attitude_rate.x" a rate.
    rules = (
        ("battery", has("battery") and not has("not voltage"), ""),
        ("steer", has("steer") and not has("rate", "velocity"), ""),
        ("steer", has("servo") and not digit, ""),
        # Of the wheel, or the front ones; each of a pair has a joint.
        ("steer", has("wheel") and (has("angle") or "road" in words) and not digit and sides in {"", "f"}, ""),
        ("thrust", has("thrust") and axis in {"", "z", "2"}, ""),
        ("throttle", has("throttle"), ""),
        ("motor", has("motor") and (corner or digit), corner or digit),
        ("motor", corner and has("rate", "force"), corner),
        # By a letter: what is counted are joints, or rotors.
        ("force", has("force") and force_axis, force_axis),
        ("torque", has("torque") and force_axis, force_axis),
        ("wheel speed", has("wheel") and (has("tachometer") or has("velocity", "turns")) and not axis, ""),
        # A car logs its only rate without an axis.
        ("rate", turning and not has("derivative", "acceleration") and (about or has("rate alone")), about or "z"),
        ("acceleration", has("acceleration") and along, along),
        ("pull", has("acceleration") and not axis, ""),
        ("quaternion", has("quaternion") and axis and not angle, axis),
        ("velocity", has("velocity") and not angle and not has("steer") and along, along),
        ("speed", has("velocity") and not angle and not has("steer") and not axis, ""),
        (angle, angle, ""),
        ("position", has("altitude"), "z"),
        ("position", along and (has("position") or letter), along),
        ("time", has("time") and not axis, ""),
    )
    return next(((quantity, where, bool(digit) and axis == digit) for quantity, holds, where in rules if holds), None)
