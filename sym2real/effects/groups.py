"""Effects that no flight, or hardly one, can tell apart, by physics: as each of them says in its own file."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from fnmatch import fnmatch

from sym2real.effects import alike
from sym2real.effects.alike import Alike
from sym2real.effects.kinds import EFFECTS
from sym2real.trajectory import Trajectory


@dataclass(frozen=True)
class Group:
    """Equivalents.

    Args:
        members: keys; ``?`` stands for one letter. The first is the one that is named.
        of: what makes them one.
    """

    members: tuple[str, ...]
    of: Alike

    @classmethod
    def collected(cls, of: Alike) -> Group:
        """All effects that say they belong to it."""
        found = [
            (member.place, name, member.on) for name in EFFECTS for member in EFFECTS[name].alike if member.of is of
        ]
        return cls(tuple(f"{name}:{on}" if on else name for _, name, on in sorted(found)), of)

    def holds(self, logs: Iterable[Trajectory]) -> bool:
        """Whether logs show that its members cannot be told apart."""
        return self.of.holds is not None and self.of.holds(logs)


GROUPS = tuple(Group.collected(likeness) for likeness in alike.ALL if likeness.counts)
NAMED = tuple(Group.collected(likeness) for likeness in alike.ALL if not likeness.counts)


def equivalents(key: str) -> tuple[str, ...]:
    """Keys, or patterns of keys, that may stand for ``key``; without itself."""
    return (*others_of(key, GROUPS), *EFFECTS[key.partition(":")[0]].counts_as)


def holding(logs: Iterable[Trajectory]) -> tuple[Group, ...]:
    """Groups whose members these logs cannot tell apart, whatever a fit to them says.

    Where physics cannot separate two effects, a fit that does so leans on what neither of them models.
    """
    logs = list(logs)
    return tuple(group for group in (*GROUPS, *NAMED) if group.holds(logs))


def others_of(key: str, groups: Iterable[Group]) -> tuple[str, ...]:
    """The other members, or patterns of them, of those of the groups that a key is in."""
    found = dict.fromkeys(
        member for group in groups if any(fnmatch(key, own) for own in group.members) for member in group.members
    )
    return tuple(member for member in found if member != key)


def unnamed(keys: Collection[str], logs: Iterable[Trajectory]) -> dict[str, tuple[str, str]]:
    """Keys that another one, which is among these, stands for in these logs, with that one and the condition."""
    logs = list(logs)
    found = (group for group in NAMED if group.members[0] in keys and group.holds(logs))
    return {member: (group.members[0], group.of.while_) for group in found for member in group.members[1:]}


def same_group(key: str, other: str) -> bool:
    """Whether two keys may stand for each other."""
    return key == other or any(fnmatch(other, member) for member in others_of(key, GROUPS))
