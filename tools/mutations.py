"""Mutations of Python source: one changed decision each, as text, so that everything else stays as it is.

Own code, because the libraries that do this (mutmut, cosmic-ray) neither draw by seed nor choose tests by line.
"""

from __future__ import annotations

import ast
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

FLIPPED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    **{ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq},
    **{ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is},
}
SWAPPED: dict[type[ast.operator], type[ast.operator]] = {
    **{ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult},
}


@dataclass(frozen=True)
class Mutation:
    """One change of a file.

    Args:
        file: path below the repository.
        function: innermost function around it; "" for what runs when the file is imported.
        operator: what kind of change it is.
        line: first line of what changes, from 1.
        start, end: where it stands in the file, in bytes.
        before, after: its text.
    """

    file: str
    function: str
    operator: str
    line: int
    start: int
    end: int
    before: str
    after: str

    @property
    def said(self) -> str:
        """One line that stays the same when lines move: what a list of equivalents holds."""
        one_line = (" ".join(text.split()) for text in (self.before, self.after))
        return f"{self.file} | {self.function} | {self.operator} | {' => '.join(one_line)}"

    def of(self, source: bytes) -> bytes:
        """The source with the change."""
        return source[: self.start] + self.after.encode() + source[self.end :]


def mutations(root: Path, folders: Sequence[str]) -> list[Mutation]:
    """Every mutation of every file below some folders of a repository, in the order of the text."""
    files = sorted(file for folder in folders for file in (root / folder).rglob("*.py"))
    return [one for file in files for one in of_file(str(file.relative_to(root)), file.read_bytes())]


def drawn(among: Sequence[Mutation], count: int, seed: int) -> list[Mutation]:
    """``count`` of them by seed, every operator alike often as far as it goes."""
    rng = random.Random(seed)
    by_operator: dict[str, list[Mutation]] = {}
    for one in among:
        by_operator.setdefault(one.operator, []).append(one)
    for same in by_operator.values():
        rng.shuffle(same)
    taken: list[Mutation] = []
    while len(taken) < min(count, len(among)):
        for name in sorted(by_operator):
            if by_operator[name] and len(taken) < count:
                taken.append(by_operator[name].pop())
    return taken


def of_file(name: str, source: bytes) -> Iterator[Mutation]:
    """Every mutation of one file that is other code."""
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def place(node: ast.expr | ast.stmt) -> tuple[int, int]:
        assert node.end_lineno is not None and node.end_col_offset is not None
        return starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset

    for function, node in _decisions(ast.parse(source), ""):
        for operator, changed in _changes(node):
            where = node.test if isinstance(node, (ast.If, ast.While)) else node
            start, end = place(where)
            before, after = source[start:end].decode(), ast.unparse(changed)
            after = f"({after})" if isinstance(where, ast.expr) and not isinstance(where, ast.Constant) else after
            if after != before:
                yield Mutation(name, function, operator, where.lineno, start, end, before, after)


def _decisions(node: ast.AST, function: str) -> Iterator[tuple[str, ast.expr | ast.stmt]]:
    """Expressions and statements that run, each with its function: no annotations, decorators, defaults or text."""
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list", "args") and not isinstance(node, ast.Call):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or isinstance(child, (ast.Import, ast.ImportFrom, ast.JoinedStr)):
                continue
            if _is_check_of_lengths(child) or _is_for_types(child):
                continue
            inside = child.name if isinstance(child, ast.FunctionDef) else function
            if isinstance(child, (ast.expr, ast.stmt)):
                yield inside, child
            yield from _decisions(child, inside)


def _changes(node: ast.expr | ast.stmt) -> Iterator[tuple[str, ast.AST]]:
    """What may become of a node, with the operator's name."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        flipped = FLIPPED[type(node.ops[0])]()
        yield "comparison flipped", ast.Compare(node.left, [flipped], node.comparators)
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield "truth value changed", ast.Constant(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        yield "constant changed", ast.Constant(node.value + 1 if isinstance(node.value, int) else 2 * node.value + 0.1)
    elif isinstance(node, ast.BoolOp):
        other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield "and or exchanged", ast.BoolOp(other, node.values)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield "boolean negated", node.operand
    elif isinstance(node, (ast.If, ast.While)) and not isinstance(node.test, (ast.Compare, ast.UnaryOp, ast.BoolOp)):
        yield "boolean negated", ast.UnaryOp(ast.Not(), node.test)
    elif isinstance(node, ast.IfExp):
        yield "boolean negated", ast.IfExp(node.test, node.orelse, node.body)
    elif isinstance(node, ast.BinOp) and type(node.op) in SWAPPED:
        yield "operation exchanged", ast.BinOp(node.left, SWAPPED[type(node.op)](), node.right)
    elif isinstance(node, ast.Call) and node.keywords and not _is_check_of_lengths(node.keywords[-1]):
        yield "argument dropped", ast.Call(node.func, node.args, node.keywords[:-1])
    elif isinstance(node, ast.Return) and node.value is not None and not _is_none(node.value):
        yield "nothing returned", ast.Return(ast.Constant(None))
    elif isinstance(node, ast.AugAssign) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)):
        yield "statement skipped", ast.Pass()


def _is_check_of_lengths(node: ast.AST) -> bool:
    """``zip(…, strict=True)`` says what is so, as an assertion does, and decides nothing."""
    return isinstance(node, ast.keyword) and node.arg == "strict"


def _is_for_types(node: ast.AST) -> bool:
    """Imports that run for a type checker alone."""
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None
