"""Mutants are other programs than what they were made of, one decision apart, and the same seed draws the same."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "tools"))

from mutations import Mutation, drawn, of_file

SOURCE = b'''"""Text with 1 number stays."""
LIMIT = 0.5


def chosen(values: list[float], most: int = 3) -> list[float]:
    """At most 3."""
    found = []
    for value in sorted(values, reverse=True):
        if value > LIMIT and not value == 7:
            found.append(value * 2)
    if len(found) >= most:
        return found[:most]
    return found if found else []
'''


def result(source: bytes) -> object:
    names: dict[str, object] = {}
    exec(compile(source, "mutant", "exec"), names)
    try:
        return names["chosen"]([0.2, 0.6, 0.9, 3.0, 4.0])  # type: ignore[operator]
    except TypeError as error:
        return str(error)


def test_every_mutant_is_valid_and_differs_in_one_place() -> None:
    found = list(of_file("some.py", SOURCE))
    for one in found:
        mutant = one.of(SOURCE)
        assert ast.dump(ast.parse(mutant)) != ast.dump(ast.parse(SOURCE))
        assert mutant[: one.start] == SOURCE[: one.start]
        assert mutant.endswith(SOURCE[one.end :])
        assert SOURCE[one.start : one.end].decode() == one.before
    operators = {one.operator for one in found}
    assert operators >= {
        *("comparison flipped", "constant changed", "truth value changed", "and or exchanged", "boolean negated"),
        *("operation exchanged", "argument dropped", "nothing returned", "statement skipped"),
    }


def test_text_and_defaults_of_arguments_stay_and_behaviour_changes() -> None:
    found = list(of_file("some.py", SOURCE))
    assert not [one for one in found if one.line in (1, 5, 6)]
    changed = [one for one in found if result(one.of(SOURCE)) != result(SOURCE)]
    # Four are alike on these values: not 7, the list's own emptiness, fewer than `most`, and its boundary.
    assert len(changed) >= len(found) - 6
    assert {one.function for one in found} == {"", "chosen"}


def test_a_seed_draws_the_same_and_every_operator_is_drawn() -> None:
    found = list(of_file("some.py", SOURCE))
    count = len({one.operator for one in found})
    assert drawn(found, count, 3) == drawn(found, count, 3)
    assert {one.operator for one in drawn(found, count, 3)} == {one.operator for one in found}
    assert len(drawn(found, 10_000, 3)) == len(found)


def test_what_a_mutant_is_called_does_not_depend_on_its_line() -> None:
    moved = list(of_file("some.py", SOURCE.replace(b"LIMIT = 0.5", b"\n\nLIMIT = 0.5")))
    assert [one.said for one in moved] == [one.said for one in of_file("some.py", SOURCE)]
    assert isinstance(moved[0], Mutation)


@pytest.mark.parametrize(
    "text", [b"pairs = dict(zip(names, values, strict=True))\n", b"if TYPE_CHECKING:\n    import one\n"]
)
def test_checks_of_lengths_and_imports_for_types_are_no_decisions(text: bytes) -> None:
    assert not list(of_file("some.py", text))
