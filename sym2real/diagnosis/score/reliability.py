"""How sure a finding is: how often findings of its kind were right on the standard set, where the truth is known.

Kinds are what separates right from wrong there: whether free runs on held-out data became better, whether something is
left over, and whether the finding is the first or one beside it. The counts come from
``tools/bench/hidden_effects.py --confidence FILE``, over cases with one effect, with two, with none, and with one that
the library lacks. They hold for a base that was calibrated in its simulator and enough data for a test, as there.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any


@dataclass(frozen=True)
class Confidence:
    """Share of findings of a kind that were right, of so many.

    Args:
        right, of: counts.
    """

    right: int
    of: int

    @property
    def value(self) -> float:
        """Mean of the share under Jeffreys' prior: few cases never make certain."""
        return (self.right + 0.5) / (self.of + 1)

    @property
    def statement(self) -> str:
        """What was counted, for a report: not this effect's own evidence, which its probability is."""
        return (
            f"{100 * self.value:.0f} %: in simulation {self.right} of {self.of} findings were right "
            "where gate, rank and what is left over were alike"
        )

    def to_dict(self) -> dict[str, Any]:
        """The entry ``confidence`` of a finding."""
        return {"value": self.value, "cases": self.of}


def kind(*, passed: bool, leftover: bool, first: bool) -> str:
    """Name of a finding's kind.

    Args:
        passed: the gate on held-out data was.
        leftover: something is left over beside all findings.
        first: it is the first of them.
    """
    parts = ("gate passed" if passed else "gate not passed", "leftover" if leftover else "no leftover")
    return ", ".join((*parts, "first" if first else "further"))


def confidence(name: str) -> Confidence | None:
    """Of the findings of a kind; None for one that the standard set never had."""
    return counts().get(name)


@cache
def counts() -> Mapping[str, Confidence]:
    """Counts by kind, as the benchmark wrote them."""
    text = resources.files(__package__).joinpath("confidence.json").read_text(encoding="utf-8")
    return {name: Confidence(**load) for name, load in json.loads(text).items()}
