"""Equations as SymPy expressions, and their way to fast torch modules."""

from sym2real.symbolic.compile import build_module, compile_function, compile_model, equations_of, read_back, rollout
from sym2real.symbolic.complexity import complexity
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.exporting import EXPORTS, export, exported_program
from sym2real.symbolic.expressions import symbol, text
from sym2real.symbolic.horner import factor_horner
from sym2real.symbolic.lifting import lift_constants
from sym2real.symbolic.parsing import parse_expression
from sym2real.symbolic.storage import load_model, save_model

__all__ = [
    "EXPORTS",
    "Equations",
    "build_module",
    "compile_function",
    "compile_model",
    "complexity",
    "equations_of",
    "export",
    "exported_program",
    "factor_horner",
    "lift_constants",
    "load_model",
    "parse_expression",
    "read_back",
    "rollout",
    "save_model",
    "symbol",
    "text",
]
