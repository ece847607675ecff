"""Which column of a log is which of a model's own, such as a joint's coordinate, rate and torque, by their names."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from sym2real.layout import Layouts
from sym2real.logs import names as known
from sym2real.logs.name_words import TORQUE, words_and_unit
from sym2real.logs.of_model import own_units

Quantity = Literal["place", "rate", "force"]

WANTED = known.WANTED | known.COMMAND | known.REFERENCE
MEASURED = frozenset({"measured", "meas", "msr", "actual", "act"})
PLACE = known.POSITION | {
    "q", "qpos", "positions", "angle", "angles", "ang", "theta", "th", "phi", "encoder", "enc", "displacement",
}  # fmt: skip
RATE = known.VELOCITY | {"rate", "rates", "w", "omega", "dq", "qd", "qdot", "qvel", "dtheta", "thetadot", "angvel"}
FORCE = TORQUE | {"f", "force", "forces", "motor", "motors", "m", "u"}
OTHERS = (known.ACCELERATION - {"a"}) | {"ddq", "qdd", "ddot", "current", "temperature"}
# What a name may say beside the joint, and says nothing about which.
NEUTRAL = frozenset({
    "joint", "joints", "jnt", "j", "state", "states", "real", "raw", "data", "robot", "of", *MEASURED,
})  # fmt: skip
# What an actuator is told, by the unit of its column.
TOLD: Mapping[str, Quantity] = {"rad": "place", "m": "place", "rad/s": "rate", "m/s": "rate"}


@dataclass(frozen=True)
class Match:
    """A column of the model that one of the log is taken for.

    Args:
        source: column of the log.
        evidence: how one sees that.
        sure: whether the name says it, not the order alone.
    """

    source: str
    evidence: str
    sure: bool = True


@dataclass(frozen=True)
class Matching:
    """What names alone say.

    Args:
        found: by column of the model.
        open: column of the model that nothing was found for → why.
    """

    found: Mapping[str, Match]
    open: Mapping[str, str]


@dataclass(frozen=True)
class _Name:
    """A column's name: what it measures, of which joint."""

    text: str

    @cached_property
    def words(self) -> tuple[str, ...]:
        text = re.sub(r"\[(\d+)\]", r".\1", self.text).replace("dQ", "dq").replace("dTheta", "dtheta")
        words, _ = words_and_unit(re.sub(r"(\d+)", r"_\1_", text))
        return tuple(words)

    @property
    def wanted(self) -> bool:
        return bool(WANTED.intersection(self.words)) and not MEASURED.intersection(self.words)

    @property
    def quantity(self) -> str:
        kinds = (("other", OTHERS), ("rate", RATE), ("force", FORCE), ("place", PLACE))
        found = (kind for kind, words in kinds if words.intersection(self.words))
        # Beside a quantity, or told, an a counts axes (KUKA's A1, ax1); measured alone it is an acceleration.
        return next(found, "other" if "a" in self.words and not self.wanted else "")

    @property
    def joint(self) -> frozenset[str]:
        """Words that name a joint."""
        said = PLACE | RATE | FORCE | NEUTRAL | WANTED
        return frozenset(word for word in self.words if word not in said and not word.isdigit())

    @property
    def number(self) -> int | None:
        digits = [word for word in self.words if word.isdigit()]
        return int(digits[-1]) if digits else None

    @property
    def family(self) -> str:
        """What it has in common with names that differ in the number alone."""
        return "#".join(re.split(r"\d+(?=\D*$)", self.text))


def match_own(columns: Sequence[str], layouts: Layouts, moved: Mapping[str, str]) -> Matching:
    """Columns of a log that are the model's own.

    Args:
        columns: of the log.
        layouts: of the model; only its columns outside the vocabulary are looked for.
        moved: joint that an action moves, as far as that is known.
    """
    return _Matcher([_Name(column) for column in columns], layouts, moved).matching()


class _Matcher:
    def __init__(self, log: Sequence[_Name], layouts: Layouts, moved: Mapping[str, str]) -> None:
        self.log = log
        own = own_units(layouts)
        state = layouts.state
        self.joints = [joint for joint in state.joints if joint in own]
        self.actions = [action for action in layouts.action if action in own]
        self.found: dict[str, Match] = {}
        self.open: dict[str, str] = {}
        self.moved, self.rates, self.units = moved, state.rates, own
        # Columns of the model without a meaning of their own, such as coordinates whose rate it does not hold.
        named = {*self.joints, *self.actions, *(state.rates[joint] for joint in self.joints)}
        self.others = [column for column in (*state, *layouts.action) if column in own and column not in named]

    def matching(self) -> Matching:
        """Own names first, then words, then the order of numbers."""
        places = {joint: joint for joint in self.joints}
        rates = {self.rates[joint]: joint for joint in self.joints}
        actions = {action: self.moved.get(action, action) for action in self.actions}
        by_text = {name.text.lower(): name for name in self.log}
        for column in (*places, *rates, *actions, *self.others):
            if (name := by_text.get(column.lower())) is not None:
                self.found[column] = Match(name.text, "the model's own name")
        self._group(places, lambda name, _: name.quantity in {"place", ""} and not name.wanted)
        self._group(rates, lambda name, _: name.quantity == "rate" and not name.wanted)
        self._group(actions, self._may_be_told)
        for column in self.others:
            if column not in self.found:
                self.open[column] = "no column is called like it"
        return Matching(self.found, self.open)

    def _may_be_told(self, name: _Name, action: str) -> bool:
        told = TOLD.get(self.units[action], "force")
        return (name.wanted and name.quantity in {told, ""}) or name.quantity == told == "force"

    def _group(self, joints: Mapping[str, str], fits: Callable[[_Name, str], bool]) -> None:
        """Columns of one quantity, each with its joint."""
        for column, joint in joints.items():
            if column not in self.found:
                self._by_words(column, {column, joint}, fits)
        left = [column for column in joints if column not in self.found]
        if left and left == [*joints]:
            self._by_order(left, fits)
        for column in joints:
            if column not in self.found:
                self.open.setdefault(column, "no column is called like it")

    def _free(self, column: str, fits: Callable[[_Name, str], bool]) -> list[_Name]:
        used = {match.source for match in self.found.values()}
        return [name for name in self.log if name.text not in used and fits(name, column)]

    def _by_words(self, column: str, called: Iterable[str], fits: Callable[[_Name, str], bool]) -> None:
        """The one name that has the words, or the number, of the column or its joint."""
        names = [_Name(text) for text in called]
        wanted = {(name.joint, name.number) for name in names if name.joint or name.number is not None}
        alike = [name for name in self._free(column, fits) if (name.joint, name.number) in wanted]
        # Where numbers count from 0 in the log and not in the model, they are no names.
        numbers = {name.number for name in names if not name.joint}
        alike = [name for name in alike if name.joint or (0 in numbers) == (0 in self._numbers(name))]
        told = [name for name in alike if name.wanted] if column in self.actions else []
        alike = told or alike
        if len(alike) == 1:
            self.found[column] = Match(alike[0].text, "by its name")
        elif alike:
            self.open[column] = f"it may be {' or '.join(repr(name.text) for name in alike)}"

    def _numbers(self, name: _Name) -> set[int | None]:
        return {other.number for other in self.log if other.family == name.family}

    def _by_order(self, columns: Sequence[str], fits: Callable[[_Name, str], bool]) -> None:
        """Names that only count, as ROS' ``position[0]``, where there are as many as the model has."""
        families: dict[str, list[_Name]] = {}
        for name in self._free(columns[0], fits):
            if name.number is not None:
                families.setdefault(name.family, []).append(name)
        count = len(columns)
        whole = [
            sorted(names, key=lambda name: name.number or 0)
            for names in families.values()
            if sorted(name.number or 0 for name in names) in ([*range(count)], [*range(1, count + 1)])
        ]
        if len(whole) == 1:
            for place, (column, name) in enumerate(zip(columns, whole[0], strict=True), 1):
                evidence = f"number {place} of {count}, in the order of the model's: check that the log has the same"
                self.found[column] = Match(name.text, evidence, sure=False)
            self.open = {column: why for column, why in self.open.items() if column not in self.found}
        elif families:
            said = ", ".join(f"{len(names)} like {names[0].text!r}" for names in families.values())
            for column in columns:
                self.open[column] = f"the log has {said} and the model {count}: which is which cannot be known"
