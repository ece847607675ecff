"""Symbolic regression: engines that turn transitions into equations, and the check of what they depend on.

>>> list(ENGINES)
['beam', 'pysr']
"""

from __future__ import annotations

from collections.abc import Callable

from sym2real.protocols import SymbolicRegressor
from sym2real.registry import Registry
from sym2real.regression.beam import BeamSearch
from sym2real.regression.dependence_check import Dependence, dependence, require_dependence
from sym2real.regression.numeric import fit_quality
from sym2real.regression.pysr import PySR
from sym2real.regression.selection import SearchSettings
from sym2real.symbolic import Equations

ENGINES: Registry[Callable[..., SymbolicRegressor[Equations]]] = Registry("engine", {"beam": BeamSearch, "pysr": PySR})

__all__ = [
    "ENGINES",
    "BeamSearch",
    "Dependence",
    "PySR",
    "SearchSettings",
    "dependence",
    "fit_quality",
    "require_dependence",
]
