"""What decides is in one place, with its source: no module of the diagnosis compares with a number of its own."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import FrozenInstanceError, fields
from pathlib import Path

import pytest

import sym2real.diagnosis
from sym2real.diagnosis.settings import SETTINGS, Settings

FOLDER = Path(sym2real.diagnosis.__file__).parent
# What is compared with but decides nothing: steps and sizes of a computation, what fits a line, what a cache keeps.
COMPUTING = {
    "ALIKE", "BETTER", "CONVERGED", "FEWEST_IN_LEAF", "LAST_THIRD", "LEVEL", "MATTERS", "MISSED", "MOST",
    "MOST_CACHED", "MOST_CONSTANTS", "MOST_EFFECTS", "ORDER", "PIECE", "ROUNDS", "ROWS",
    "SMALLEST", "SMALLEST_NOISE", "STILL",
}  # fmt: skip
# Signs, counts of axes, halves of a range, and what keeps a division or a logarithm finite.
PLAIN = (-1, 0, 1, 2, 3)
TINY = 1e-8


def numbers(node: ast.AST) -> list[float]:
    constants = (part.value for part in ast.walk(node) if isinstance(part, ast.Constant))
    return [value for value in constants if isinstance(value, int | float) and not isinstance(value, bool)]


def constants_of(tree: ast.Module) -> set[str]:
    """Names in capitals that a module gives a number."""
    names = set()
    for node in tree.body:
        if isinstance(node, ast.Assign) and numbers(node.value):
            names |= {name.id for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name)}
    return {name for name in names if name.isupper()}


def compared(tree: ast.Module) -> Iterator[ast.expr]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            yield from (node.left, *node.comparators)


def test_every_threshold_says_where_its_number_comes_from() -> None:
    for one in fields(Settings):
        assert one.metadata["source"] in ("theory", "sensor", "tuned"), one.name
        assert one.metadata["why"], one.name
        if one.metadata["source"] == "tuned":
            data = ("simulated", "null sets", "the list of mistakes", "learned bases", "real")
            assert any(words in one.metadata["why"] for words in data), f"{one.name} does not say on what"


def test_every_threshold_decides_something() -> None:
    text = "".join(path.read_text() for path in FOLDER.rglob("*.py"))
    unused = [one.name for one in fields(Settings) if f"SETTINGS.{one.name}" not in text]
    assert not unused


def test_nobody_changes_a_threshold_on_the_way() -> None:
    with pytest.raises(FrozenInstanceError):
        SETTINGS.false_alarms = 1.0  # type: ignore[misc]


def test_no_module_compares_with_a_number_of_its_own() -> None:
    trees = {path: ast.parse(path.read_text()) for path in FOLDER.rglob("*.py")}
    literal = [
        f"{path.name}: {ast.unparse(side)}"
        for path, tree in trees.items()
        for side in compared(tree)
        if any(value not in PLAIN and abs(value) > TINY for value in numbers(side))
    ]
    assert not literal
    named = {name for tree in trees.values() for name in constants_of(tree)} - COMPUTING
    decides = [
        f"{path.name}: {ast.unparse(side)}"
        for path, tree in trees.items()
        for side in compared(tree)
        if any(isinstance(part, ast.Name) and part.id in named for part in ast.walk(side))
    ]
    assert not decides
    sides = {
        part.id
        for tree in trees.values()
        for side in compared(tree)
        for part in ast.walk(side)
        if isinstance(part, ast.Name)
    }
    assert not COMPUTING - sides, "names that nothing is compared with any more"


def test_those_that_compete_share_the_chance_of_a_false_alarm() -> None:
    assert SETTINGS.false_alarms_of_each(0) == SETTINGS.false_alarms_of_each(1) == SETTINGS.false_alarms
    assert 40 * SETTINGS.false_alarms_of_each(40) == pytest.approx(SETTINGS.false_alarms)
