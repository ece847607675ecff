"""Coordinates that dynamics do not depend on: a residual of such a base does not see them.

No place on level ground is unlike another, so a free body's next state is the same wherever it is, shifted by as much.
What a base leaves over of it is too, unless its own equations have a place in them. A network that sees places anyway
learns what happened where. Height is none of them: the ground is below, with what it does to rotors. Source: H.
Goldstein, Classical Mechanics, 3rd ed., section 2.6 (cyclic coordinates, translation).
"""

from dataclasses import replace

from sym2real.level_ground import PLACE
from sym2real.neural.composed import Base
from sym2real.symbolic import Equations
from sym2real.symbolic.expressions import symbol


def cyclic_coordinates(base: Base) -> tuple[str, ...]:
    """Columns of the place of a free body that a base's change of the state does not depend on.

    An ensemble has none: its error is another at another place, because its networks see it.
    """
    if not isinstance(base, Equations):
        return ()
    return tuple(column for column in PLACE if column in base.layouts.state and not _changes_with(base, column))


def _changes_with(base: Equations, column: str) -> bool:
    """Whether the change of any state column depends on the coordinate."""
    moved = replace(base, next={**base.next, column: base.next[column] - symbol(column)})
    return any(moved.depends(output, column) for output in base.layouts.state)
