"""The models that a page switches among: one that is given, with any of a few additions.

Findings of a diagnosis that are on have the values of their joint estimate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

from sym2real.dataset import Dataset
from sym2real.diagnosis import Finding
from sym2real.effects import compose, effect
from sym2real.effects.along_logs import prepared
from sym2real.effects.composing import Chosen
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations

MOST_SWITCHES = 5
Predicting = Equations | DynamicsModel


@dataclass(frozen=True)
class Switch:
    """Something that can be added: its name, and its values in words."""

    name: str
    about: str


def subsets(count: int) -> list[tuple[bool, ...]]:
    """Every combination of so many switches; the first switch is the lowest bit of a combination's place."""
    return [on[::-1] for on in product((False, True), repeat=count)]


@dataclass(frozen=True)
class Given:
    """Whole models: the one that is judged and, where there is one, what it has become.

    Args:
        models: one, or two.
        switches: one fewer.
    """

    models: tuple[Predicting, ...]
    switches: tuple[Switch, ...] = ()

    def prepared(
        self, on: Sequence[bool], data: Dataset, _like: DynamicsModel | None = None
    ) -> tuple[DynamicsModel, Dataset]:
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

    def prepared(
        self, on: Sequence[bool], data: Dataset, like: DynamicsModel | None = None
    ) -> tuple[DynamicsModel, Dataset]:
        """The model with these switches on, and the logs as it takes them; compiled as that with others is."""
        off = [finding for group, is_on in zip(self._groups, on, strict=True) if not is_on for finding in group]
        whole, at_none = self._whole
        none = {name: value for finding in off for name, value in at_none[finding.effect].items()}
        return prepared(replace(whole, parameters={**whole.parameters, **none}), data, like)

    @cached_property
    def _whole(self) -> tuple[Equations, dict[str, dict[str, float]]]:
        """The equations with all findings, whose fitted values are parameters: all variants are compiled as one.

        By effect, its parameters at none of it.
        """
        base, chosen, values = self.base, list[Chosen](), dict[str, float]()
        none: dict[str, dict[str, float]] = {}
        for finding in self.findings:
            base = finding.bound(base)
        for finding in self.findings:
            own = effect(finding.effect, base)
            symbols, choices = own.symbols(), own.searching.choices
            settled = choices(own.body)[0] if choices else ""
            free = [p for p in own.parameters if p.name in finding.values and p.name != settled]
            none[finding.effect] = {symbols[p.name].name: p.null for p in free}
            values |= {symbols[p.name].name: finding.values[p.name] for p in free}
            chosen.append((own, {**finding.values, **{p.name: symbols[p.name] for p in free}}))
        whole = compose(base, chosen)
        return replace(whole, parameters={**whole.parameters, **values}), none


def _switch(group: Sequence[Finding]) -> Switch:
    about = "; ".join(f"{name} {estimate.text}" for finding in group for name, estimate in finding.parameters.items())
    return Switch(" and ".join(finding.effect for finding in group), about)
