"""A residual as expressions, for bases that are no equations: there the sum of both is no expression.

::

    residual = r(s, a), one expression per state column
"""

from collections.abc import Mapping

from sympy import Expr, Float
from torch import Tensor, nn

from sym2real.layout import Layouts
from sym2real.symbolic.compile import build_function


class SymbolicResidual(nn.Module):
    """Residual of the next state ``# (..., n)`` for state ``# (..., n)`` and action ``# (..., m)``.

    Args:
        layouts: state and action columns.
        expressions: state column → expression over those columns; zero where there is none.

    Raises:
        ModelError: when a function is not supported.
        UnknownNameError: when an expression uses another name.
    """

    def __init__(self, layouts: Layouts, expressions: Mapping[str, Expr]) -> None:
        super().__init__()
        for column in expressions:
            layouts.state.index(column)
        self.columns = (layouts.state.columns, layouts.action.columns)
        self.expressions = {column: expressions.get(column, Float(0)) for column in layouts.state}
        self.commands, self.states = 0, 0
        self.function = build_function(list(self.expressions.values()), self.columns)

    def forward(self, state: Tensor, action: Tensor, past: Tensor | None = None) -> Tensor:
        """Residual ``# (..., n)``; leading dimensions broadcast; it sees no past."""
        residual: Tensor = self.function(state, action)
        return residual
