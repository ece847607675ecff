"""Equations as SymPy expressions, and their way to fast torch modules."""

from sym2real.symbolic.compile import build_module, compile_function, compile_model, read_back, rollout
from sym2real.symbolic.complexity import complexity
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.expressions import symbol
from sym2real.symbolic.parsing import parse_expression

__all__ = [
    "Equations",
    "build_module",
    "compile_function",
    "compile_model",
    "complexity",
    "parse_expression",
    "read_back",
    "rollout",
    "symbol",
]
