"""The symbolic regression engines by name."""

from __future__ import annotations

from collections.abc import Callable

from sym2real.protocols import SymbolicRegressor
from sym2real.registry import Registry
from sym2real.regression.beam import BeamSearch
from sym2real.regression.operon import Operon
from sym2real.regression.pysr import PySR
from sym2real.symbolic import Equations

ENGINES: Registry[Callable[..., SymbolicRegressor[Equations]]] = Registry(
    "engine", {"beam": BeamSearch, "pysr": PySR, "operon": Operon}
)
