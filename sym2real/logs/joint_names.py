"""Which column of a log is which of a model's own, such as a joint's coordinate, rate and torque, by their names."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

from sym2real.layout import Layouts
from sym2real.logs.name_words import TABLES, WORDS, words_and_unit
from sym2real.logs.names import OF_ROLES, is_time
from sym2real.logs.of_model import own_units
from sym2real.logs.units import UNITS

Quantity = Literal["place", "rate", "force"]

OF_JOINTS = {meaning: frozenset(words) for meaning, words in TABLES["joints"].items()}
MEASURED = WORDS["measured"]
PLACE, RATE = WORDS["position"] | OF_JOINTS["place"], WORDS["velocity"] | OF_JOINTS["rate"]
FORCE = WORDS["torque"] | OF_JOINTS["force"]
OTHERS = (WORDS["acceleration"] - {"a"}) | OF_JOINTS["other"]
# What a name may say beside the joint, and says nothing about which.
NEUTRAL = OF_JOINTS["neutral"] | MEASURED
SHORTEST = 3  # letters of a joint's name that is looked for inside a word
# What an actuator is commanded, by the unit of its column.
COMMANDED: Mapping[str, Quantity] = {"rad": "place", "m": "place", "rad/s": "rate", "m/s": "rate"}


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
        pairs: by column of the model.
        open: column of the model that nothing matches → why.
    """

    pairs: dict[str, Match] = field(default_factory=dict)
    open: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class _Name:
    """A column's name: what it measures, of which joint.

    Args:
        text: as it stands.
        joints: of the model, which may stand in it without a gap (``currentPositionknee``).
        without: words that say nothing in this log.
        mine: words that the model's own columns are called by, which say no other quantity.
    """

    text: str
    joints: tuple[str, ...] = ()
    without: frozenset[str] = frozenset()
    mine: frozenset[str] = frozenset()

    @cached_property
    def words(self) -> tuple[str, ...]:
        text = re.sub(r"\[(\d+)\]", r".\1", self.text).replace("dQ", "dq").replace("dTheta", "dtheta")
        if glued := [joint for joint in self.joints if joint.lower() in text.lower()]:
            text = re.sub(f"({re.escape(max(glued, key=len))})", r"_\1_", text, flags=re.IGNORECASE)
        words, _ = words_and_unit(re.sub(r"(\d+)", r"_\1_", text))
        return tuple(word for word in words if word not in self.without)

    @property
    def wanted(self) -> bool:
        return bool(OF_ROLES.intersection(self.words)) and not MEASURED.intersection(self.words)

    @property
    def quantity(self) -> str:
        """What it measures: a place, a rate, a force, something else, or "" where no word says so."""
        kinds = (("other", OTHERS - self.mine), ("rate", RATE), ("force", FORCE), ("place", PLACE))
        # A joint's own name says none, and be it `twist` or `motor`.
        beside = {*self.words}.difference(*(_Name(joint).words for joint in self.joints))
        matching = (kind for kind, words in kinds if words & beside)
        # Beside a quantity, or commanded, an a counts axes (KUKA's A1, ax1); measured alone it is an acceleration.
        return next(matching, "other" if "a" in self.words and not self.wanted else "")

    @property
    def joint(self) -> frozenset[str]:
        """Words that name a joint."""
        other_words = PLACE | RATE | FORCE | NEUTRAL | OF_ROLES
        return frozenset(word for word in self.words if word not in other_words and not word.isdigit())

    @property
    def number(self) -> int | None:
        digits = [word for word in self.words if word.isdigit()]
        return int(digits[-1]) if digits else None

    @property
    def unit(self) -> str:
        """The SI unit of the one that it states, or ""."""
        stated = words_and_unit(self.text)[1]
        return UNITS[stated][0] if stated else ""

    @property
    def family(self) -> str:
        """What it has in common with names that differ in the number alone."""
        return "#".join(re.split(r"\d+(?=\D*$)", self.text))


Fits = Callable[[_Name, str], bool]  # whether a name may stand for a column of the model


def match_own(columns: Sequence[str], layouts: Layouts, moved: Mapping[str, str]) -> Matching:
    """Columns of a log that are the model's own: by their own names first, then by words, then by the order of numbers.

    Args:
        columns: of the log.
        layouts: of the model; only its columns outside the vocabulary are looked for.
        moved: joint that an action moves, as far as that is known.
    """
    units, rates = own_units(layouts), layouts.state.rates
    own = [column for column in (*layouts.state, *layouts.action) if column in units]
    places = {joint: joint for joint in layouts.state.joints if joint in units}
    actions = {action: moved.get(action, action) for action in own if action in layouts.action}

    def may_command(name: _Name, action: str) -> bool:
        quantity = COMMANDED.get(units[action], "force")
        return (name.wanted and name.quantity in {quantity, ""}) or name.quantity == quantity == "force"

    result = Matching(_by_own_names(columns, {column: units[column] for column in own}, rates, actions))
    called = tuple(joint for joint in places if len(joint) >= SHORTEST)
    mine = frozenset(word for column in own for word in _Name(column).words)
    log = [_Name(column, called, mine=mine) for column in columns]
    # A position is no electric current: who says "current position" means that it is so now, of torques too.
    if any("current" in name.words and (PLACE | RATE).intersection(name.words) for name in log):
        log = [replace(name, without=frozenset({"current"})) for name in log]
    _match(result, log, places, lambda name, _: name.quantity in {"place", ""} and not name.wanted, units)
    turned = {rates[joint]: joint for joint in places}
    _match(result, log, turned, lambda name, _: name.quantity == "rate" and not name.wanted, units)
    _match(result, log, actions, may_command, units, sent=True)
    used = {match.source for match in result.pairs.values()}
    for action, joint in actions.items():
        meant = {COMMANDED.get(units[action], "force"), ""}
        left = [name for name in log if name.text not in used and name.quantity in meant]
        if action not in {*result.pairs, *result.open} and (alike := _alike({action, joint}, left, log)):
            listed = " or ".join(repr(name.text) for name in alike)
            result.open[action] = f"it may be {listed}, whose name does not say that it was sent"
    missing = [name for name in own if name not in result.pairs and name not in rates.values()]
    used = {match.source for match in result.pairs.values()}
    spare = [name for name in log if name.text not in used and not is_time(name.text)]
    if len(missing) == len(spare) == 1:
        sort = COMMANDED.get(units[missing[0]], "force") if missing[0] in actions else "place"
        if spare[0].quantity in {sort, ""}:
            only = Match(spare[0].text, "the only column that is left over: check that it is", sure=False)
            result.pairs[missing[0]] = only
            result.open.pop(missing[0], None)
    # Columns of the model without a meaning of their own, such as coordinates whose rate it does not hold, too.
    for column in own:
        if column not in result.pairs:
            result.open[column] = result.open.pop(column, "no column is called like it")
    return result


def _by_own_names(
    columns: Sequence[str], own: Mapping[str, str], rates: Mapping[str, str], actions: Mapping[str, str]
) -> dict[str, Match]:
    """The model's columns, with their units, as the log calls them, also beside a unit; a rate by its joint's name.

    Beside a unit a command may be what was measured instead, unless another column is the joint that it moves.
    """
    texts = {column.lower(): column for column in columns}
    pairs = {name: Match(texts[name.lower()], "the model's own name") for name in own if name.lower() in texts}
    beside: dict[tuple[tuple[str, ...], str], list[str]] = {}
    for text in columns:
        words, unit = words_and_unit(text)
        beside.setdefault((tuple(words), UNITS[unit][0] if unit else ""), []).append(text)
    for name, unit in own.items():
        called = (name, *(place for place, rate in rates.items() if rate == name))
        alike = [text for word in called for text in beside.get((tuple(words_and_unit(word)[0]), unit), ())]
        sent = name not in actions or actions[name] in pairs
        if name not in pairs and len(alike) == 1 and sent:
            pairs[name] = Match(alike[0], "the model's own name beside a unit")
    return pairs


def _match(
    result: Matching,
    log: Sequence[_Name],
    joints: Mapping[str, str],
    fits: Fits,
    units: Mapping[str, str],
    *,
    sent: bool = False,
) -> None:
    """Columns of one quantity, each with its joint; ``sent`` where names of what is wanted go first."""

    def free(column: str) -> list[_Name]:
        used = {match.source for match in result.pairs.values()}
        return [name for name in log if name.text not in used and fits(name, column)]

    for column, joint in joints.items():
        if column not in result.pairs:
            alike = _alike({column, joint}, free(column), log)
            alike = ([name for name in alike if name.wanted] if sent else []) or alike
            if len(alike) == 1:
                sure = alike[0].joint in {_Name(text).joint for text in (column, joint)}
                evidence = "by its name" if sure else "by a word of its name"
                result.pairs[column] = Match(alike[0].text, evidence, sure)
            elif alike:
                result.open[column] = f"it may be {' or '.join(repr(name.text) for name in alike)}"
    if joints and not joints.keys() & result.pairs.keys():
        _by_order(result, [*joints], free(next(iter(joints))), units)
    kinds = dict.fromkeys(units[column] for column in joints)
    if len(kinds) > 1 and not sent and not joints.keys() & result.pairs.keys():  # hinges and slides, each counted alone
        for unit in kinds:
            stated = [name for name in free(next(iter(joints))) if name.unit == unit]
            _by_order(result, [column for column in joints if units[column] == unit], stated, units, unit)


def _alike(called: Iterable[str], free: Sequence[_Name], log: Sequence[_Name]) -> list[_Name]:
    """Names that have the words, or the number, of a column or its joint."""
    names = [_Name(text) for text in called]
    wanted = {(name.joint, name.number) for name in names if name.joint or name.number is not None}
    # Where numbers count from 0 in the log and not in the model, they are no names.
    from_0 = any(name.number == 0 for name in names if not name.joint)
    counted_from_0 = {name.family for name in log if name.number == 0}
    exact = [
        name
        for name in free
        if (name.joint, name.number) in wanted and (name.joint or from_0 == (name.family in counted_from_0))
    ]
    if exact:
        return exact
    # A column of no number by all its words ("Drive Force" for `drive`, "wheel cmd left" for `left`).
    return [name for name in free if any(other.number is None and {*other.words} <= {*name.words} for other in names)]


def _by_order(
    result: Matching, columns: Sequence[str], free: Sequence[_Name], units: Mapping[str, str], unit: str = ""
) -> None:
    """Names that only count, as ROS' ``position[0]``, where there are as many as the model has.

    Args:
        unit: that all of them state, of which one column needs no number.
    """
    families: dict[str, dict[int, _Name]] = {}
    if unit and len(columns) == len(free) == 1:
        result.pairs[columns[0]] = Match(free[0].text, f"the only one in a unit of {unit}", sure=False)
        result.open.pop(columns[0], None)
        return
    for name in free:
        if name.number is not None:
            families.setdefault(name.family, {})[name.number] = name
    count = len(columns)
    counts = [[*range(count)], [*range(1, count + 1)]]
    whole = [[names[number] for number in sorted(names)] for names in families.values() if sorted(names) in counts]
    pairs = list(zip(columns, whole[0], strict=True)) if len(whole) == 1 else []
    if pairs and all(name.unit in {"", units[column]} for column, name in pairs):
        for place, (column, name) in enumerate(pairs, 1):
            evidence = f"number {place} of {count}, in the order of the model's: check that the log has the same"
            result.pairs[column] = Match(name.text, evidence, sure=False)
            result.open.pop(column, None)
    elif families:
        described = ", ".join(f"{len(names)} like {next(iter(names.values())).text!r}" for names in families.values())
        reason = f"the log has {described} and the model {count}: which is which cannot be known"
        result.open.update(dict.fromkeys(columns, reason))
