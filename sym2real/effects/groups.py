"""Effects that no flight, or hardly one, can tell apart, by physics."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatch


@dataclass(frozen=True)
class Group:
    """Equivalents.

    Args:
        members: keys; ``?`` stands for one letter.
        while_: the condition under which they cannot be told apart.
    """

    members: tuple[str, ...]
    while_: str


GROUPS = (
    Group(("added_mass", "gain:thrust", "offset:thrust"), "thrust stays near one value"),
    Group(("torque_bias", "offset:w?_cmd"), "always"),
    Group(("com_offset", "torque_bias", "offset:w?_cmd"), "thrust hardly varies"),
    Group(("wheelbase", "gain:steer"), "speed is low"),
    Group(("rolling_resistance", "offset:speed"), "speed is controlled by a loop"),
    Group(("wind", "mounting_tilt"), "yaw stays"),
    Group(("wind", "slope"), "always"),
    Group(("yaw_bias", "lever_arm"), "the car drives one circle"),
    Group(("motor_lag", "lag:w?_cmd", "lag"), "the rate commands carry no dither"),
    Group(("delay", "delay:?*"), "only that command is excited"),
    Group(("yaw_drag", "lateral_slip"), "the tyres hold"),
)
# Effects that count as others together.
COUNT_AS = {"payload": ("added_mass", "com_offset"), "rate_damping": ("rate_loop_gain", "gain:w?_cmd")}


def equivalents(key: str) -> tuple[str, ...]:
    """Keys, or patterns of keys, that may stand for ``key``; without itself."""
    found = dict.fromkeys(
        member for group in GROUPS if any(fnmatch(key, own) for own in group.members) for member in group.members
    )
    found |= dict.fromkeys(COUNT_AS.get(key, ()))
    return tuple(member for member in found if member != key)


def same_group(one: str, other: str) -> bool:
    """Whether two keys may stand for each other."""
    return one == other or any(
        any(fnmatch(one, own) for own in group.members) and any(fnmatch(other, own) for own in group.members)
        for group in GROUPS
    )
