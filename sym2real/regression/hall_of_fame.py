"""PySR's hall of fame: the best equation found at every complexity, and which of them to take."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import sympy

from sym2real.errors import ModelError
from sym2real.symbolic import complexity, parse_expression

# PySR's rule "best": among the equations whose loss is at most 1.5 times the smallest, the one that gained most
# −ln(loss) per node over the next simpler one.
CLOSE_TO_BEST = 1.5
# Julia writes single precision numbers as 1.0f-5.
JULIA_FLOAT = re.compile(r"\b(\d+\.?\d*)[fF]([+-]?\d+)\b")


@dataclass(frozen=True)
class Entry:
    """One equation of a hall of fame: PySR's count of nodes, its loss, its text."""

    complexity: int
    loss: float
    equation: str


def best_entry(entries: Sequence[Entry]) -> Entry:
    """The equation that PySR's rule "best" selects.

    Raises:
        ModelError: when there is none with a finite loss.
    """
    ordered = sorted((entry for entry in entries if math.isfinite(entry.loss)), key=lambda entry: entry.complexity)
    if not ordered:
        raise ModelError("expected a hall of fame with at least one equation of finite loss, found none")
    limit = CLOSE_TO_BEST * min(entry.loss for entry in ordered)
    gains = [0.0, *(_gain(simpler, entry) for simpler, entry in pairwise(ordered))]
    return max(
        ((gain, entry) for gain, entry in zip(gains, ordered, strict=True) if entry.loss <= limit),
        key=lambda pair: pair[0],
    )[1]


def _gain(simpler: Entry, entry: Entry) -> float:
    if entry.loss <= 0.0:
        return math.inf
    if simpler.loss <= 0.0:
        return -math.inf
    return math.log(simpler.loss / entry.loss) / max(entry.complexity - simpler.complexity, 1)


def expression_of(entry: Entry, names: Sequence[str], nodes: int) -> sympy.Expr:
    """The equation as an expression over these names.

    Raises:
        UnknownNameError: when it uses another name.
        ModelError: when the text is not such an expression or has more than ``nodes`` nodes.
    """
    expression = parse_expression(JULIA_FLOAT.sub(r"\1e\2", entry.equation).replace("^", "**"), names)
    if complexity(expression) > nodes:
        raise ModelError(f"expected at most {nodes} nodes, found {complexity(expression)} in {entry.equation[:60]!r}")
    return expression
