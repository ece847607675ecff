"""Equations as SymPy expressions, and their way to fast torch modules."""

from sym2real.symbolic.compile import (
    build_module as build_module,
    compile_function as compile_function,
    compile_model as compile_model,
    equations_of as equations_of,
    read_back as read_back,
    rollout as rollout,
)
from sym2real.symbolic.equations import Equations as Equations
from sym2real.symbolic.exporting import EXPORTS as EXPORTS, export as export
from sym2real.symbolic.expressions import symbol as symbol, text as text
from sym2real.symbolic.horner import factor_horner as factor_horner
from sym2real.symbolic.lifting import constants as constants, lift_constants as lift_constants
from sym2real.symbolic.node_count import complexity as complexity
from sym2real.symbolic.parsing import parse_expression as parse_expression
from sym2real.symbolic.storage import load_model as load_model, save_model as save_model
