"""Names of effects and of columns stand with the effects and in the vocabulary: nothing else may decide by them."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import sym2real
from sym2real.effects import EFFECTS
from sym2real.vocabulary import VOCABULARY

ROOT = Path(sym2real.__file__).parent
COLUMNS = {column for _, field in VOCABULARY for column in field.columns}
# What only looks like a name: how often, and why. Nothing may be added to it.
EXCEPTIONS = {
    "control/fused_residual.py": Counter({"x": 1, "y": 1}),  # arrays of the C text
    "control/geometric.py": Counter({"wheelbase": 1}),  # the robot's number
    "diagnosis/answer.py": Counter({"gain": 1}),  # an entry of diagnosis.json
    # A user's mistakes are about columns: which were exchanged, turned, or counted the other way.
    "diagnosis/faults/mistakes/listed.py": Counter(x=3, y=3, vx=3, vy=3),
    "diagnosis/faults/mistakes/transformation.py": Counter(sin_yaw=1, cos_yaw=1, x=1, y=1, z=1, vz=1, vx=1, vy=1),
}


def literals(path: Path) -> Iterator[str]:
    """Strings of a file but for docstrings."""
    tree = ast.parse(path.read_text())
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    docstrings = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, documented) and node.body and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield node.value


def is_name(text: str) -> bool:
    return text in COLUMNS or text.partition(":")[0] in EFFECTS


def test_nothing_but_effects_and_layout_decides_by_the_name_of_an_effect_or_a_column() -> None:
    found = {}
    for room in ("diagnosis", "cli", "control"):
        for path in sorted((ROOT / room).rglob("*.py")):
            names = Counter(text for text in literals(path) if is_name(text))
            beyond = names - EXCEPTIONS.get(str(path.relative_to(ROOT)), Counter())
            if beyond:
                found[str(path.relative_to(ROOT))] = dict(beyond)
    assert not found, "ask the effect (its `searching`), or the vocabulary for the columns of a field"


def test_no_exception_outlives_what_it_was_for() -> None:
    for name, allowed in EXCEPTIONS.items():
        path = ROOT / name
        left = Counter(text for text in literals(path) if is_name(text)) if path.exists() else Counter()
        assert not allowed - left, f"{name}: take it off the list"
