"""Expressions as the graphs that they are: what several expressions, or places of one, share is visited once.

SymPy's own ``free_symbols``, ``atoms``, ``has`` and ``xreplace`` follow every path through an expression. A push that
is put into a velocity and a position, whose numbers are put into further pushes, has exponentially many paths.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from sympy import Basic, Expr


def distinct(expression: Basic) -> Iterator[Basic]:
    """Every part of an expression once, itself the first."""
    seen, waiting = {expression}, [expression]
    while waiting:
        part = waiting.pop()
        yield part
        new = [argument for argument in part.args if argument not in seen]
        seen.update(new)
        waiting += new


class Exchange:
    """Parts of expressions replaced, all at once; one exchange does shared parts of all its expressions once.

    Args:
        replacements: part → what stands in its place, in which nothing is replaced.
        rebuild: an operation of the same kind on other arguments.
    """

    def __init__(self, replacements: Mapping[Basic, Basic], rebuild: Callable[[Basic, list[Basic]], Basic]) -> None:
        self._known, self._rebuild = dict(replacements), rebuild

    def __call__(self, expression: Expr) -> Expr:
        """The expression with the parts replaced; itself where it has none of them."""
        found = self._known.get(expression)
        if found is None:
            arguments = [self(argument) for argument in expression.args]
            same = all(new is old for new, old in zip(arguments, expression.args, strict=True))
            found = self._known[expression] = expression if same else self._rebuild(expression, arguments)
        return found
