"""A case of the study: a robot, a task, and what its target has that the plain simulator lacks, from a TOML file."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import numpy as np
from msgspec import Meta

from sym2real.effects import effect
from sym2real.errors import DataError, ModelError, Sym2RealError, UnknownNameError
from sym2real.experiments.study.contestants import CONTESTANTS
from sym2real.experiments.study.mechanisms import MECHANISMS
from sym2real.files import read_toml
from sym2real.plants import MujocoPlant
from sym2real.registry import Registry
from sym2real.robots import ROBOTS, Robot
from sym2real.tasks import Task, make_task
from sym2real.toml_tables import of_kind

Parts: TypeAlias = tuple[tuple[str, Mapping[str, float]], ...]

FOLDER = resources.files("sym2real.experiments").joinpath("cases")


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
class Listed:
    """A file of cases, each a table."""

    title: str
    contestants: tuple[str, ...]
    case: Annotated[tuple[dict[str, Any], ...], Meta(min_length=1)]


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
    given = of_kind(file, table, Listed, key="field")
    try:
        asked = tuple(name for name in given.contestants if CONTESTANTS[name])
    except UnknownNameError as error:
        raise DataError(file, "contestants that exist", str(error)) from error
    cases = tuple(_case(file, row) for row in given.case)
    names = [case.name for case in cases]
    if len(set(names)) < len(names):
        raise DataError(file, "name: a name of its own for every case", ", ".join(names))
    return Suite(given.title, asked, cases)


def _case(file: Path, row: Mapping[str, Any]) -> Case:
    where = f"case {row.get('name', '')!r}"
    parts = {f"{kind}s": _parts(row[f"{kind}s"], kind) for kind in ("effect", "mechanism") if f"{kind}s" in row}
    case = of_kind(file, {**row, **parts}, Case, where=f"{where}, ", key="field")
    case = case if "truth" in row else replace(case, truth=tuple(key for key, _ in case.effects))
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
    if not case.name.replace("-", "").isalnum():
        raise ModelError(f"name: expected letters, digits and hyphens, which name files, found {case.name!r}")
    robot = case.of_robot
    case.of_task()
    for key, values in case.effects:
        if not values:
            raise ModelError(f"{key}: expected values, found none")
    for name, values in case.mechanisms:
        needed = [*inspect.signature(MECHANISMS[name]).parameters][2:]
        if {*values} != {*needed}:
            raise ModelError(f"{name}: expected the numbers {', '.join(needed)}, found {', '.join(values) or 'none'}")
        if wrong := [key for key, value in values.items() if not value > 0]:
            raise ModelError(f"{name}: expected {wrong[0]} > 0, found {values[wrong[0]]!r}")
    case.plant(0)
    for key in case.truth:
        effect(key, robot)


def _parts(entries: Any, kind: str) -> Any:
    """``effects`` or ``mechanisms`` of a case as pairs of a name and its numbers; what is none stays as it is."""
    if not isinstance(entries, list) or not all(isinstance(entry, dict) and kind in entry for entry in entries):
        return entries
    return [(entry[kind], {name: value for name, value in entry.items() if name != kind}) for entry in entries]
