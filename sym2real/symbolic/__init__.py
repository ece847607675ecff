"""Equations as SymPy expressions, and their way to fast torch modules."""

from sym2real.symbolic.compile import build_module as build_module
from sym2real.symbolic.compile import compile_function as compile_function
from sym2real.symbolic.compile import compile_model as compile_model
from sym2real.symbolic.compile import equations_of as equations_of
from sym2real.symbolic.compile import read_back as read_back
from sym2real.symbolic.compile import rollout as rollout
from sym2real.symbolic.equations import Equations as Equations
from sym2real.symbolic.exporting import EXPORTS as EXPORTS
from sym2real.symbolic.exporting import export as export
from sym2real.symbolic.expressions import symbol as symbol
from sym2real.symbolic.expressions import text as text
from sym2real.symbolic.horner import factor_horner as factor_horner
from sym2real.symbolic.lifting import lift_constants as lift_constants
from sym2real.symbolic.node_count import complexity as complexity
from sym2real.symbolic.parsing import parse_expression as parse_expression
from sym2real.symbolic.storage import load_model as load_model
from sym2real.symbolic.storage import save_model as save_model
