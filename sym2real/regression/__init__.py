"""Symbolic regression: engines that turn transitions into equations, and the check of what they depend on.

>>> list(ENGINES)
['beam', 'pysr', 'operon']
"""

from collections.abc import Callable

from sym2real.protocols import SymbolicRegressor
from sym2real.registry import Registry
from sym2real.regression.beam import BeamSearch as BeamSearch
from sym2real.regression.dependence_check import (
    Dependence as Dependence,
    dependence as dependence,
    require_dependence as require_dependence,
)
from sym2real.regression.numeric import fit_quality as fit_quality
from sym2real.regression.operon import Operon as Operon
from sym2real.regression.pysr import PySR as PySR
from sym2real.regression.selection import SearchSettings as SearchSettings
from sym2real.symbolic import Equations

ENGINES: Registry[Callable[..., SymbolicRegressor[Equations]]] = Registry(
    "engine", {"beam": BeamSearch, "pysr": PySR, "operon": Operon}
)
