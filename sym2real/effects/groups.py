"""Effects that no flight, or hardly one, can tell apart, by physics."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from fnmatch import fnmatch

from sym2real.effects.manoeuvres import (
    always,
    calm_rates,
    one_circle,
    one_direction,
    one_speed,
    steady_thrust,
    steady_yaw,
    tyres_hold,
)
from sym2real.trajectory import Trajectory


@dataclass(frozen=True)
class Group:
    """Equivalents.

    Args:
        members: keys; ``?`` stands for one letter.
        while_: the condition under which they cannot be told apart.
        holds: whether logs show that condition; None where only a fit can say.
        one_of: where it holds only one of them can be found: the other would fit what neither of them models.
    """

    members: tuple[str, ...]
    while_: str
    holds: Callable[[Iterable[Trajectory]], bool] | None = None
    one_of: bool = False


GROUPS = (
    Group(("added_mass", "gain:thrust"), "always", always),
    Group(("added_mass", "gain:thrust", "offset:thrust"), "thrust stays near one value", steady_thrust),
    Group(("torque_bias", "offset:w?_cmd"), "always", always),
    Group(("com_offset", "torque_bias", "offset:w?_cmd"), "thrust hardly varies"),
    Group(("wheelbase", "gain:steer"), "speed is low"),
    Group(("rolling_resistance", "offset:speed"), "a loop controls the speed, in one direction", one_direction),
    Group(("wind", "mounting_tilt"), "yaw stays", steady_yaw, one_of=True),
    Group(("wind", "slope"), "always", always),
    Group(("yaw_bias", "lever_arm"), "the car drives one circle", one_circle),
    Group(("motor_lag", "lag:w?_cmd", "lag"), "the rate commands carry no dither", calm_rates),
    Group(("delay", "delay:?*"), "only that command is excited"),
    Group(("yaw_drag", "lateral_slip"), "the tyres hold", tyres_hold),
)
# Equal on such logs only: elsewhere a fit tells them apart, so that they do not count as each other. The first is
# named: the law that holds at the speeds of small robots (rotors in inflow, G. Hoffmann et al., AIAA 2007-6461), and
# the mass, because near one thrust every thrust map is a gain; a steering gain and a lever arm, because at one speed
# tyres turn the car by one part less and move it by one arm: circles at several speeds tell them apart.
NAMED = (
    Group(("linear_drag", "quadratic_drag"), "speed stays near one value", one_speed, one_of=True),
    Group(
        ("added_mass", "gain:thrust", "offset:thrust", "thrust_curve"),
        "thrust stays near one value",
        steady_thrust,
        one_of=True,
    ),
    Group(("gain:steer", "understeer"), "speed stays near one value", one_speed, one_of=True),
    Group(("lever_arm", "tyre_slip"), "speed stays near one value", one_speed, one_of=True),
)
# Effects that count as others together.
COUNT_AS = {"payload": ("added_mass", "com_offset"), "rate_damping": ("rate_loop_gain", "gain:w?_cmd")}


def equivalents(key: str) -> tuple[str, ...]:
    """Keys, or patterns of keys, that may stand for ``key``; without itself."""
    return (*others_of(key, GROUPS), *COUNT_AS.get(key, ()))


def holding(logs: Iterable[Trajectory]) -> tuple[Group, ...]:
    """Groups whose members these logs cannot tell apart, whatever a fit to them says.

    Where physics cannot separate two effects, a fit that does so leans on what neither of them models.
    """
    logs = list(logs)
    return tuple(one for one in (*GROUPS, *NAMED) if one.holds is not None and one.holds(logs))


def others_of(key: str, groups: Iterable[Group]) -> tuple[str, ...]:
    """The other members, or patterns of them, of those of the groups that a key is in."""
    found = dict.fromkeys(
        member for group in groups if any(fnmatch(key, own) for own in group.members) for member in group.members
    )
    return tuple(member for member in found if member != key)


def unnamed(keys: Collection[str], logs: Iterable[Trajectory]) -> dict[str, tuple[str, str]]:
    """Keys that another one, which is among these, stands for in these logs, with that one and the condition."""
    logs = list(logs)
    found = (group for group in NAMED if group.members[0] in keys and group.holds is not None and group.holds(logs))
    return {member: (group.members[0], group.while_) for group in found for member in group.members[1:]}


def same_group(one: str, other: str) -> bool:
    """Whether two keys may stand for each other."""
    return one == other or any(
        any(fnmatch(one, own) for own in group.members) and any(fnmatch(other, own) for own in group.members)
        for group in GROUPS
    )
