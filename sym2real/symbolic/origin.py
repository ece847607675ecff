"""What a generated text follows from, written down in a hundredth of the time that the text takes.

Compiled libraries are kept by it: a warm cache lowers, orders and prints nothing.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from uuid import uuid4

import numpy as np
import sympy
from sympy import Basic, Expr

from sym2real.symbolic.equations import Equations

PACKAGE = Path(__file__).parent.parent
ROOMS = (".", "native", "symbolic", "effects", "control")  # whose modules write texts


def origin_of_equations(equations: Equations) -> str:
    """Everything of equations that a text may contain, their parameters' values among it, and who writes texts.

    Filters are not among it: they act on whole series, and a text that has them says so by its own account.
    """
    layouts = equations.layouts
    parts = (
        generators(),
        repr((layouts.state, layouts.action, layouts.inputs, equations.dt, dict(equations.parameters))),
        *map(_all, (equations.next, equations.quantities, equations.start)),
    )
    return "\n".join(parts)


def _all(expressions: Mapping[str, Expr]) -> str:
    lines = _Lines()
    roots = [f"{name} = {lines.number(expression)}" for name, expression in expressions.items()]
    return "\n".join([*lines, *roots])


def origin_of_expression(expression: Basic) -> str:
    """The graph of an expression, a line for every part; numbers to the last bit, symbols by name."""
    lines = _Lines()
    lines.number(expression)
    return "\n".join(lines)


class _Lines:
    """Parts of expressions, each with the numbers of its arguments; equal ones are one line."""

    def __init__(self) -> None:
        self._numbers = dict[str, int]()
        self._seen = dict[int, int]()  # by object

    def __iter__(self) -> Iterator[str]:
        return iter(self._numbers)

    def number(self, part: Basic) -> int:
        """Of a part's line, which is added where there is none."""
        if id(part) not in self._seen:
            self._seen[id(part)] = self._numbers.setdefault(self._line(part), len(self._numbers))
        return self._seen[id(part)]

    def _line(self, part: Basic) -> str:
        if part.args:
            return f"{type(part).__name__}({','.join(str(self.number(argument)) for argument in part.args)})"
        if part.is_Symbol:
            return str(part.name)
        return repr(float(part)) if part.is_Float else sympy.srepr(part)


def generators() -> str:
    """Who writes texts: versions of the numerics, and what stands in the files of this package that do.

    Their dates would not do: images and package managers give all files one date, and an edit may keep the size. Where
    a file was edited after this process began to import them, nobody knows which text belongs to which content, so
    that every answer is another one.
    """
    return _content() if _dates() == _DATES else f"edited while it ran {uuid4()}"


@lru_cache(maxsize=1)
def _content() -> str:
    found = hashlib.sha256(f"numpy {np.__version__} sympy {sympy.__version__}".encode())
    for file in sorted(_DATES):
        content = (PACKAGE / file).read_bytes()
        found.update(f"\n{file} {len(content)}\n".encode() + content)
    return found.hexdigest()


def _dates() -> dict[str, tuple[int, int]]:
    """Path of each file that writes texts → its size and date, as Python tells stale modules."""
    found: dict[str, tuple[int, int]] = {}
    for room in ROOMS:
        with os.scandir(PACKAGE / room) as files:
            about = ((file.name, file.stat()) for file in files if file.name.endswith((".py", ".h")))
            found |= {f"{room}/{name}": (stat.st_size, stat.st_mtime_ns) for name, stat in about}
    return found


_DATES = _dates()
