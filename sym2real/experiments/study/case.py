"""A case of the study: a robot, a task, and what its target has that the plain simulator lacks, from a TOML file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import resources
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from sym2real.effects import effect
from sym2real.errors import DataError, ModelError, Sym2RealError, UnknownNameError
from sym2real.experiments.study.contestants import CONTESTANTS
from sym2real.experiments.study.mechanisms import MECHANISMS, require_mechanism
from sym2real.files import read_toml
from sym2real.plants import MujocoPlant
from sym2real.registry import Registry
from sym2real.robots import ROBOTS, Robot
from sym2real.tasks import Task, make_task
from sym2real.toml_tables import SWITCH, TABLE, TEXT, Rule, checked, number, tables, texts

Parts: TypeAlias = tuple[tuple[str, Mapping[str, float]], ...]

FOLDER = resources.files("sym2real.experiments").joinpath("cases")
OF_SUITE = {
    "title": TEXT,
    "contestants": texts("a list of names"),
    "case": tables("at least one [[case]]", least=1),
}
OF_CASE = {
    **dict.fromkeys(("title", "robot", "task", "paper"), TEXT),
    "name": Rule(
        "of letters, digits and hyphens: it names files",
        lambda name: isinstance(name, str) and name.replace("-", "").isalnum(),
    ),
    "options": TABLE,
    "effects": tables("a list of { effect = NAME, number = … }"),
    "mechanisms": tables("a list of { mechanism = NAME, number = … }"),
    "truth": texts("a list of effects"),
    "ensemble": SWITCH,
}


@dataclass(frozen=True)
class Case:
    """One target and what is wanted on it.

    Args:
        name: short, for files.
        title: in words.
        robot: name.
        task: name.
        options: of the task.
        effects: of the catalogue, in the target: keys with values.
        mechanisms: of :data:`~sym2real.experiments.study.mechanisms.MECHANISMS`, in the target: names with numbers.
        truth: keys of the effects that would explain the target; those of ``effects`` where nothing else is said.
        paper: what the paper says of it.
        ensemble: the contestants with a neural base are asked here even by the quick study.
    """

    name: str
    title: str
    robot: str
    task: str
    options: Mapping[str, Any] = field(default_factory=dict)
    effects: Parts = ()
    mechanisms: Parts = ()
    truth: tuple[str, ...] = ()
    paper: str = ""
    ensemble: bool = False

    @property
    def of_robot(self) -> Robot:
        """The robot itself."""
        return ROBOTS[self.robot]

    def of_task(self) -> Task:
        """The task itself."""
        return make_task(self.task, self.of_robot, **self.options)

    def plant(self, seed: int) -> MujocoPlant:
        """The target; ``seed`` draws its sensors' noise."""
        robot, rng = self.of_robot, np.random.default_rng([seed, 1])
        changes = [effect(key, robot).inject(**values) for key, values in self.effects]
        changes += [MECHANISMS[name](robot, rng, **values) for name, values in self.mechanisms]
        return MujocoPlant(robot, changes)


@dataclass(frozen=True)
class Suite:
    """Cases that belong together.

    Args:
        title: in words.
        contestants: that are asked, keys of :data:`~sym2real.experiments.study.contestants.CONTESTANTS`.
        cases: by row of the table.
    """

    title: str
    contestants: tuple[str, ...]
    cases: tuple[Case, ...]

    def only(self, cases: Sequence[str], contestants: Sequence[str]) -> Suite:
        """These of the cases, and these contestants whether the file names them or not; all where none are named.

        Raises:
            UnknownNameError: for one that does not exist.
        """
        known = Registry("case", {case.name: case for case in self.cases})
        for name in contestants:
            CONTESTANTS[name]  # refuses what does not exist
        return replace(
            self,
            cases=tuple(known[name] for name in dict.fromkeys(cases)) or self.cases,
            contestants=tuple(dict.fromkeys(contestants)) or self.contestants,
        )


def shipped_suites() -> tuple[str, ...]:
    """Names of the case files that come with the package."""
    return tuple(sorted(file.name.removesuffix(".toml") for file in FOLDER.iterdir() if file.name.endswith(".toml")))


def load_suite(name: str) -> Suite:
    """The cases of a file that comes with the package, by name, or of any other, by path.

    Raises:
        UnknownNameError: when it is neither.
        DataError: for a file that cannot be read, or whose content is no such list, naming case and field.
    """
    if name in shipped_suites():
        file = Path(str(FOLDER.joinpath(f"{name}.toml")))
    elif name.endswith(".toml"):
        file = Path(name)
    else:
        raise UnknownNameError("cases: neither a file.toml nor", name, shipped_suites())
    return _suite(file, read_toml(file, "cases in TOML"))


def _suite(file: Path, table: Mapping[str, Any]) -> Suite:
    given = checked(file, table, OF_SUITE, kind="field", needed=OF_SUITE)
    try:
        asked = tuple(name for name in given["contestants"] if CONTESTANTS[name])
    except UnknownNameError as error:
        raise DataError(file, "contestants that exist", str(error)) from error
    cases = tuple(_case(file, row) for row in given["case"])
    names = [case.name for case in cases]
    if len(set(names)) < len(names):
        raise DataError(file, "name: a name of its own for every case", ", ".join(names))
    return Suite(given["title"], asked, cases)


def _case(file: Path, row: Mapping[str, Any]) -> Case:
    where = f"case {row.get('name', '')!r}"
    given = checked(file, row, OF_CASE, where=f"{where}, ", kind="field", needed=("name", "title", "robot", "task"))
    for kind in ("effect", "mechanism"):
        given[f"{kind}s"] = _parts(file, where, given.get(f"{kind}s", ()), kind)
    given.setdefault("truth", tuple(key for key, _ in given["effects"]))
    case = Case(**given)
    try:
        require_possible(case)
    except (Sym2RealError, AttributeError, OverflowError, TypeError, ValueError) as error:
        raise DataError(file, f"{where} that its robot can have", str(error)) from error
    return case


def require_possible(case: Case) -> None:
    """Refuse a case whose names do not exist, or whose robot cannot have it; nothing is simulated.

    Raises:
        Sym2RealError: with the name or number that does not fit.
    """
    robot = case.of_robot
    case.of_task()
    for key, values in case.effects:
        if not values:
            raise ModelError(f"{key}: expected values, found none")
        effect(key, robot).inject(**values)
    for name, values in case.mechanisms:
        require_mechanism(name, robot, values)
    for key in case.truth:
        effect(key, robot)


def _parts(file: Path, where: str, entries: Sequence[Mapping[str, Any]], kind: str) -> Parts:
    """``effects`` or ``mechanisms`` of a case."""
    found = []
    for entry in entries:
        rules = dict.fromkeys(entry, number("a finite number", -math.inf)) | {kind: TEXT}
        values = checked(file, entry, rules, where=f"{where}, {entry.get(kind, kind)}, ", needed=(kind,))
        found.append((values.pop(kind), values))
    return tuple(found)
