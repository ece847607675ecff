"""The models that a page switches among: one that is given, with any of a few additions.

With findings of a diagnosis there is one set of equations, compiled once: the parameters of a finding stand at their
null value, where an effect does nothing, until its switch is on. All others keep the values of their joint estimate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import torch
from sympy import Expr

from sym2real.dataset import Dataset
from sym2real.diagnosis import Finding
from sym2real.diagnosis.data.preparation import in_parts, prepared
from sym2real.diagnosis.predict.library import shielded
from sym2real.effects import Effect, compose, effect
from sym2real.effects.inputs import with_inputs
from sym2real.effects.sensors import MeasuredModel
from sym2real.effects.visible import VisibleModel, visible_state
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations, compile_model
from sym2real.symbolic.period import at_period

MOST_SWITCHES = 5
Predicting = Equations | DynamicsModel


@dataclass(frozen=True)
class Switch:
    """Something that can be added: its name, and its values in words."""

    name: str
    about: str


def subsets(count: int) -> list[tuple[bool, ...]]:
    """Every combination of so many switches; the first switch is the lowest bit of a combination's place."""
    return [tuple(bool(place >> bit & 1) for bit in range(count)) for place in range(2**count)]


@dataclass(frozen=True)
class Given:
    """Whole models: the one that is judged and, where there is one, what it has become.

    Args:
        models: one, or two.
        switches: one fewer.
    """

    models: tuple[Predicting, ...]
    switches: tuple[Switch, ...] = ()

    def prepared(self, on: Sequence[bool], data: Dataset) -> tuple[DynamicsModel, Dataset]:
        """The model with these switches on, and the logs as it takes them."""
        return prepared(self.models[sum(on)], data)


@dataclass(frozen=True)
class WithFindings:
    """A base and its findings, any of which may be on; the last switch holds all findings that have none of their own.

    Args:
        base: equations without them, as they were diagnosed.
        findings: in order of importance, not none.
    """

    base: Equations
    findings: tuple[Finding, ...]

    @property
    def switches(self) -> tuple[Switch, ...]:
        """What can be added."""
        return tuple(_switch(group) for group in self._groups)

    @property
    def _groups(self) -> list[tuple[Finding, ...]]:
        own, rest = self.findings[: MOST_SWITCHES - 1], self.findings[MOST_SWITCHES - 1 :]
        return [*((finding,) for finding in own), *([rest] if rest else [])]

    @cached_property
    def bound(self) -> Equations:
        """The base with the inputs that the findings' values refer to."""
        equations = self.base
        for finding in self.findings:
            equations = finding.bound(equations)
        return equations

    @cached_property
    def shielded(self) -> Equations:
        """The base with a name of its own for everything that an effect may change before it acts."""
        return shielded(self.bound)

    @cached_property
    def effects(self) -> dict[str, Effect]:
        """The effect of every finding, by its key."""
        return {finding.effect: effect(finding.effect, self.bound) for finding in self.findings}

    @cached_property
    def equations(self) -> Equations:
        """All effects in the base; their fitted parameters are symbols at null."""
        return compose(
            self.shielded, [(self.effects[finding.effect], self.values(finding)) for finding in self.findings]
        )

    def values(self, finding: Finding) -> dict[str, Expr | float]:
        """A symbol for every parameter of a finding that a fit can vary, the value of the others."""
        of = self.effects[finding.effect]
        fitted = {parameter.name for parameter in of.parameters if parameter.fitted}
        return {name: of.symbols()[name] if name in fitted else value for name, value in finding.values.items()}

    def prepared(self, on: Sequence[bool], data: Dataset) -> tuple[DynamicsModel, Dataset]:
        """The model with these switches on, and the logs as it takes them."""
        parameters = dict(self.equations.parameters)
        for group, is_on in zip(self._groups, on, strict=True):
            for finding in group if is_on else ():
                parameters |= self._numbers(finding)
        equations = replace(self.equations, parameters=parameters)
        slow, logs = in_parts(equations, with_inputs(equations.layouts.inputs, data))
        compiled = _compiled(self.equations, data.dt, slow.layouts != equations.layouts)
        return MeasuredModel(slow, model=_At(compiled, slow)), logs

    def _numbers(self, finding: Finding) -> dict[str, float]:
        symbols = self.effects[finding.effect].symbols()
        names = {name: symbols[name].name for name in finding.values}
        return {
            names[name]: value for name, value in finding.values.items() if names[name] in self.equations.parameters
        }


@lru_cache(maxsize=4)
def _compiled(equations: Equations, dt: float, apart: bool) -> torch.jit.ScriptModule:
    return compile_model(at_period(equations, dt, apart=apart), dtype=torch.float64)


class _At(VisibleModel):
    """Compiled equations at values of their parameters, which hidden states start from too."""

    def __init__(self, compiled: torch.jit.ScriptModule, equations: Equations) -> None:
        self.compiled, self.equations, self.columns = compiled, equations, visible_state(equations).size
        self.values = torch.tensor(list(equations.parameters.values()), dtype=torch.float64)


def _switch(group: Sequence[Finding]) -> Switch:
    about = "; ".join(f"{name} {estimate.said}" for finding in group for name, estimate in finding.parameters.items())
    return Switch(" and ".join(finding.effect for finding in group), about)
