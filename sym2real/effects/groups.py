"""Effects that no flight, or hardly one, can tell apart, by physics."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch

from sym2real.effects import manoeuvres
from sym2real.effects.kinds import EFFECTS
from sym2real.trajectory import Trajectory


@dataclass(frozen=True)
class Group:
    """Equivalents.

    Args:
        while_: the condition under which they cannot be told apart.
        members: keys; ``?`` stands for one letter. The first is the one that is named.
        shown: whether logs show that condition; None where only a fit can say.
        exclusive: where it holds only one of them can be found: the other would fit what neither of them models.
    """

    while_: str
    members: tuple[str, ...]
    shown: manoeuvres.Condition | None = None
    exclusive: bool = False

    def holds(self, logs: Sequence[Trajectory]) -> bool:
        """Whether logs show that its members cannot be told apart."""
        return self.shown is not None and self.shown(logs)


# They count as each other also where nobody looks at the condition.
GROUPS = (
    Group("no motor's torque is predicted", ("added_mass", "gain:thrust"), manoeuvres.no_motor_torques),
    Group(
        "thrust stays near one value", ("added_mass", "gain:thrust", "offset:thrust"), manoeuvres.steady_thrust_alone
    ),
    Group("always", ("torque_bias", "offset:w?_cmd"), manoeuvres.always),
    Group("thrust hardly varies", ("com_offset", "torque_bias", "offset:w?_cmd")),
    Group("steering angles are small", ("gain:steer", "wheelbase"), manoeuvres.small_steering, exclusive=True),
    Group(
        "a loop controls the speed, in one direction",
        ("rolling_resistance", "offset:speed", "offset:acceleration"),
        manoeuvres.single_direction,
    ),
    Group("yaw stays", ("wind", "mounting_tilt"), manoeuvres.steady_yaw, exclusive=True),
    Group("always", ("wind", "slope"), manoeuvres.always),
    Group("the car drives one circle", ("yaw_bias", "lever_arm"), manoeuvres.single_circle),
    Group("the rate commands carry no dither", ("motor_lag", "lag:w?_cmd", "lag"), manoeuvres.calm_rates),
    Group("only that command is excited", ("delay", "delay:?*")),
    Group("the tyres hold", ("yaw_drag", "lateral_slip"), manoeuvres.tyres_hold),
)
# Those that are equal on such logs only, and that a fit tells apart elsewhere, where the first is named. The law that
# holds at the speeds of small robots is (rotors in inflow, G. Hoffmann et al., AIAA 2007-6461), and the mass, because
# near one thrust an offset is a gain, and at one thrust so is a curve; a steering gain, a lever arm and a
# lag of the steering, because at one speed tyres turn the car by one part less, move it by one arm, and are late by one
# time; and a steering gain, because on one circle every steering map is one.
SAME_SPEED, SAME_THRUST = "speed stays near one value", "thrust stays near one value"
NAMED = (
    Group(SAME_SPEED, ("linear_drag", "quadratic_drag"), manoeuvres.steady_speed, exclusive=True),
    Group(SAME_THRUST, ("added_mass", "gain:thrust", "offset:thrust"), manoeuvres.steady_thrust_alone, exclusive=True),
    Group("thrust has one value", ("added_mass", "thrust_curve"), manoeuvres.constant_thrust_alone, exclusive=True),
    # Where motors turn the body as well, their torques tell what scales them from what does not.
    Group(SAME_THRUST, ("added_mass", "offset:thrust"), manoeuvres.steady_thrust, exclusive=True),
    Group("thrust has one value", ("gain:thrust", "thrust_curve"), manoeuvres.constant_thrust, exclusive=True),
    Group(SAME_SPEED, ("gain:steer", "understeer"), manoeuvres.steady_speed, exclusive=True),
    Group(SAME_SPEED, ("lever_arm", "tyre_slip"), manoeuvres.steady_speed, exclusive=True),
    Group(SAME_SPEED, ("lag:steer", "relaxation_length", "yaw_inertia"), manoeuvres.steady_speed, exclusive=True),
    Group("the car drives one circle", ("gain:steer", "steering_curve"), manoeuvres.single_circle, exclusive=True),
    Group(SAME_SPEED, ("gain:speed", "speed_curve"), manoeuvres.steady_speed, exclusive=True),
    Group("the car goes one way", ("gain:speed", "speed_asymmetry"), manoeuvres.single_direction, exclusive=True),
    Group("the car drives one circle", ("gain:steer", "steering_asymmetry"), manoeuvres.single_circle, exclusive=True),
)

# A curve is no mass, but beside one it fits what neither of them models where the thrust is far from that in hover.
ALTERNATIVES = tuple(
    Group(SAME_THRUST, (key, "thrust_curve"), manoeuvres.steady_thrust, exclusive=True)
    for key in ("added_mass", "gain:thrust")
)


def equivalents(key: str) -> tuple[str, ...]:
    """Keys, or patterns of keys, that may stand for ``key``; without itself."""
    return (*others_of(key, GROUPS), *EFFECTS[key.partition(":")[0]].counts_as)


def holding(logs: Iterable[Trajectory]) -> tuple[Group, ...]:
    """Groups whose members these logs cannot tell apart, whatever a fit to them says.

    Where physics cannot separate two effects, a fit that does so leans on what neither of them models.
    """
    logs = list(logs)
    return tuple(group for group in (*GROUPS, *NAMED, *ALTERNATIVES) if group.holds(logs))


def same_on_every_flight(key: str, logs: Iterable[Trajectory]) -> tuple[str, ...]:
    """Keys, or patterns of them, that no flight of such a robot tells from one, whatever its manoeuvres."""
    logs, conditions = list(logs), (manoeuvres.always, manoeuvres.no_motor_torques)
    return others_of(key, (group for group in GROUPS if group.shown in conditions and group.holds(logs)))


def others_of(key: str, groups: Iterable[Group]) -> tuple[str, ...]:
    """The other members, or patterns of them, of those of the groups that a key is in."""
    members = dict.fromkeys(
        member for group in groups if any(fnmatch(key, own) for own in group.members) for member in group.members
    )
    return tuple(member for member in members if member != key)


def unnamed(keys: Collection[str], logs: Iterable[Trajectory]) -> dict[str, tuple[str, str]]:
    """Keys that another one, which is among these, stands for in these logs, with that one and the condition."""
    logs = list(logs)
    groups = (group for group in NAMED if group.members[0] in keys and group.holds(logs))
    return {member: (group.members[0], group.while_) for group in groups for member in group.members[1:]}
