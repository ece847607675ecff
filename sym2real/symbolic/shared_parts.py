"""Expressions as the graphs that they are: what several expressions, or places of one, share is visited once.

SymPy's own ``free_symbols``, ``atoms``, ``has`` and ``xreplace`` follow every path through an expression. A force that
is put into a velocity and a position, whose numbers are put into further forces, has exponentially many paths.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from sympy import Basic, Expr

Result = TypeVar("Result")
# Expressions of which something is known: a chain of substitutions asks of the same ones again and again, and an arm of
# seven joints has more than five thousand.
REMEMBERED = 65536


def distinct(expression: Basic) -> Iterator[Basic]:
    """Every part of an expression once, itself the first; equal parts that are two objects may come twice."""
    seen, waiting = {id(expression)}, [expression]
    while waiting:
        part = waiting.pop()
        yield part
        new = {id(argument): argument for argument in part.args if id(argument) not in seen}
        seen.update(new)
        waiting += new.values()


def remembered(function: Callable[[Expr], Result]) -> Callable[[Expr], Result]:
    """The function, asked once of every object: two equal expressions are told equal by following every path."""
    known: dict[int, tuple[Expr, Result]] = {}  # the expression too, so that no other object has its id

    def ask(expression: Expr) -> Result:
        """As the function itself."""
        entry = known.get(id(expression))
        if entry is None:
            if len(known) >= REMEMBERED:
                known.clear()  # also of what another thread has just put there
            entry = known[id(expression)] = (expression, function(expression))
        return entry[1]

    return ask


class Exchange:
    """Parts of expressions replaced, all at once; one exchange does shared parts of all its expressions once.

    Args:
        replacements: leaf (a symbol, a number) or relation → what stands in its place, in which nothing is replaced.
        rebuild: an operation of the same kind on other arguments.
    """

    def __init__(self, replacements: Mapping[Basic, Basic], rebuild: Callable[[Basic, list[Basic]], Basic]) -> None:
        self._replacements, self._rebuild = replacements, rebuild
        self._done: dict[int, tuple[Basic, Basic]] = {}  # the part too, so that no other object has its id

    def __call__(self, expression: Expr) -> Expr:
        """The expression with the parts replaced; itself where it has none of them."""
        entry = self._done.get(id(expression))
        if entry is None:
            entry = self._done[id(expression)] = (expression, self._exchanged(expression))
        return entry[1]

    def _exchanged(self, part: Basic) -> Basic:
        if part in self._replacements:
            return self._replacements[part]
        arguments = [self(argument) for argument in part.args]
        same = all(new is old for new, old in zip(arguments, part.args, strict=True))
        return part if same else self._rebuild(part, arguments)
