"""Beam search as residual learner: the paper's SR*+SR and NN*+SR."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import torch
from sympy import Expr

from sym2real.dataset import Transitions
from sym2real.layout import Layouts
from sym2real.neural import Composed, SymbolicResidual
from sym2real.neural.composed import Base, state_of
from sym2real.neural.leftover import leftover
from sym2real.regression.residual_terms import ResidualSettings, residual_terms
from sym2real.symbolic import Equations
from sym2real.trajectory import Array


@dataclass(frozen=True)
class ResidualSearch:
    """A :class:`~sym2real.protocols.Learner` of residual equations on a frozen base.

    On equations the result is equations again, their sum, which flies in the fused kernel and exports like any other.
    On an ensemble the expressions stand beside it.

    Args:
        settings: of the search.
        angles: columns in rad whose sine and cosine may stand in terms, as the robot's equations have them.
    """

    settings: ResidualSettings = field(default_factory=ResidualSettings)
    angles: Sequence[str] = ()

    def fit(
        self, transitions: Transitions, base: Base, start: Equations | Composed | None = None
    ) -> Equations | Composed:
        """The base with the terms of the residual.

        Args:
            transitions: of the target.
            base: frozen.
            start: has no part: all rows are searched anew, so the answer does not depend on the way there.

        Raises:
            ModelError: for too few consecutive transitions.
            ShapeError: for other columns than the base's.
        """
        layouts = Layouts(state_of(base), base.layouts.action)
        rows = leftover(transitions, base)
        state, action = rows.seen.double().split([len(layouts.state), len(layouts.action)], dim=-1)
        meant = replace(
            transitions,
            state=state.numpy(),
            action=action.numpy(),
            next_state=layouts.state.retract(state, rows.change.double()).numpy(),
            inputs=transitions.inputs[:, :0],
            layouts=layouts,
        )
        left: Array = -(torch.linalg.pinv(rows.moved.double()) @ rows.error.double()[..., None])[..., 0].numpy()
        terms = residual_terms(meant, left, self.settings, self.angles)
        if isinstance(base, Equations):
            return with_added(base, terms)
        return Composed(base, SymbolicResidual(layouts, terms))


def with_added(equations: Equations, expressions: Mapping[str, Expr]) -> Equations:
    """Equations whose next states have expressions added, before they are put back on the manifold.

    Args:
        equations: stay as they are.
        expressions: state column → what is added to its next value.

    Raises:
        UnknownNameError: for a column that is no state, or a name in an expression that the equations do not have.
    """
    for column in expressions:
        equations.layouts.state.index(column)
    return replace(equations, next={c: value + expressions.get(c, 0) for c, value in equations.next.items()})
