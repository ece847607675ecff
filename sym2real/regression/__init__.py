"""Symbolic regression: engines that turn transitions into equations, and the check of what they depend on.

Names are imported when first used: PySR's worker process runs inside this package and must not import torch.

>>> list(ENGINES)
['beam', 'pysr', 'operon']
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sym2real.regression.beam import BeamSearch
    from sym2real.regression.dependence_check import Dependence, dependence, require_dependence
    from sym2real.regression.engines import ENGINES
    from sym2real.regression.hall_of_fame import load_hall_of_fame
    from sym2real.regression.operon import Operon
    from sym2real.regression.pysr import PySR
    from sym2real.regression.report import EquationReport, Fit, fit_quality
    from sym2real.regression.selection import SearchSettings

__all__ = [
    "ENGINES",
    "BeamSearch",
    "Dependence",
    "EquationReport",
    "Fit",
    "Operon",
    "PySR",
    "SearchSettings",
    "dependence",
    "fit_quality",
    "load_hall_of_fame",
    "require_dependence",
]

_OWNERS = {
    "ENGINES": "engines",
    "BeamSearch": "beam",
    "Dependence": "dependence_check",
    "EquationReport": "report",
    "Fit": "report",
    "Operon": "operon",
    "PySR": "pysr",
    "SearchSettings": "selection",
    "dependence": "dependence_check",
    "fit_quality": "report",
    "load_hall_of_fame": "hall_of_fame",
    "require_dependence": "dependence_check",
}


def __getattr__(name: str) -> Any:
    if name not in _OWNERS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_OWNERS[name]}"), name)
