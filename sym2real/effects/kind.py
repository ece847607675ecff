"""An entry of the registry of effects: what a kind of effect is, its parameters, hypothesis and truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from sympy import Expr

from sym2real.effects.body import Body
from sym2real.effects.memory import LONGEST_DELAY, Memory
from sym2real.effects.searching import Searching
from sym2real.protocols import Change
from sym2real.symbolic import Equations

Stage = Literal["mass", "loop", "wrench", "thrust", "filter", "command", "measurement"]
Values = Mapping[str, Expr]
Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Domain:
    """An interval of real numbers: values that a parameter can have at all, beyond which there is no such thing.

    Args:
        low, high: its ends.
        open: whether ``low`` itself is outside.
    """

    low: float = -math.inf
    high: float = math.inf
    open: bool = False

    def __contains__(self, value: float) -> bool:
        return math.isfinite(value) and (value > self.low if self.open else value >= self.low) and value <= self.high

    def nearest(self, value: float) -> float:
        """The value, or the end of the interval that it lies beyond."""
        return min(max(value, self.low), self.high)

    def __str__(self) -> str:
        """For a sentence, without a unit."""
        low = "" if self.low == -math.inf else f"{'more than' if self.open else 'at least'} {self.low:g}"
        high = "" if self.high == math.inf else f"at most {self.high:g}"
        return " and ".join(part for part in (low, high) if part) or "a finite number"


ANYTHING = Domain()
NOT_NEGATIVE = Domain(0.0)
DELAY_TIME = Domain(0.0, LONGEST_DELAY)
SHIFT_TIME = Domain(-LONGEST_DELAY, LONGEST_DELAY)
POSITIVE = Domain(0.0, open=True)


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    Args:
        name: as the user types it.
        unit: SI unit.
        null: value at which the effect does nothing.
        low, high: bounds.
        scale: size that is to be expected beforehand: standard deviation of a prior, unit of a fit.
        per_log: true where every log has a value of its own (a phase).
        fitted: false where the motion hardly shows it, so that a fit had better leave it alone.
        domain: values that there can be, where ``low`` and ``high`` are what is likely.
        acts_alone: whether it does something while the effect's others are null.
        low_is_likely: whether ``low`` itself is, as nothing of a friction that a description has.
    """

    name: str
    unit: str
    null: float
    low: float
    high: float
    scale: float
    per_log: bool = False
    fitted: bool = True
    domain: Domain = ANYTHING
    acts_alone: bool = True
    low_is_likely: bool = False


def of_any_body(*parameters: Parameter) -> Callable[[Body], tuple[Parameter, ...]]:
    """Parameters that are the same for every robot."""
    return lambda _: parameters


def several(
    names: Iterable[str], unit: str, *, null: float, low: float, high: float, scale: float, domain: Domain = ANYTHING
) -> tuple[Parameter, ...]:
    """Parameters that differ in their names alone."""
    return tuple(Parameter(name, unit, null, low, high, scale, domain=domain) for name in names)


def about_zero(scales: float) -> Callable[[Body], tuple[Parameter, ...]]:
    """One value in the unit of the bound column, likely within so many of its scales, to either side."""
    return lambda body: (
        Parameter("value", body.unit, null=0.0, low=-scales * body.scale, high=scales * body.scale, scale=body.scale),
    )


def with_unit(value: float, unit: str, digits: int = 3) -> str:
    """A value for a sentence, with so many digits; the unit 1 goes without saying."""
    return f"{value:.{digits}g}" if unit in ("", "1") else f"{value:.{digits}g} {unit}"


Substitute = Callable[[Equations, Values, Body], Equations]
Inject = Callable[[Body, Numbers], Change]


def _of_none(_: Body) -> bool:
    return False


@dataclass(frozen=True)
class Kind:
    """An entry of the registry.

    Args:
        name: registry key.
        stage: where it acts; a composition substitutes from the dynamics outwards.
        parameters: its numbers for a body.
        formula: LaTeX.
        summary: what it is, one sentence.
        confused_with: what it looks like, one sentence.
        shown_by: which manoeuvre shows it, one sentence.
        fix: what to change on the robot or in the model, one sentence.
        inject: the truth.
        substitute: the hypothesis; None for effects that act as filters.
        memory: makes the recursion over a series, for filters.
        needs: names that must exist as columns or quantities; ``{column}`` in one stands for the bound column,
            ``{heading}`` for the first that tells where the robot points.
        numbers: the robot's numbers that it cannot do without, likewise.
        robot: the robots that have it.
        columns: group whose columns it binds to, the joints, the sites of loads, or parameters; "" for none.
        of_attitude: whether it may be on a commanded attitude, whose columns are no commands of their own.
        of_all: whether it may be on all columns of a robot like this one at once, which no column means.
        parts: for effects that are two others: their kinds and values.
        hidden: hidden states that it brings; equations that have one of them have the effect already.
        shared: hidden states that it may bring, and that several effects may have in common.
        contradiction: what is wrong with values that cannot stand together, "" where they can.
        counts_as: keys, or patterns of keys, of effects that together are this one.
        searching: how it takes part in a search.
        by_torque: whether it acts by a torque, whose answer is known no better than the loop's stiffness.
        lagging: whether its value is the time of a lag, by way or speed too, of which a control period hides a part.
        reads: inputs that it goes by where the equations have them.
        scales: name of the robot's number that its only value multiplies; "" for none.
        distinguished_by: how to tell it from what equals it on every flight, for a sentence; "" where nothing does.
        nuisance: factors on its values between which no healthy robot's are known: they are free in every fit.
        of_joints: name of the kind that a robot of joints has in its place; "" for none.
    """

    name: str
    stage: Stage
    parameters: Callable[[Body], tuple[Parameter, ...]]
    formula: str
    summary: str
    confused_with: str
    shown_by: str
    fix: str
    inject: Inject
    substitute: Substitute | None = None
    memory: Callable[[Body], Memory] | None = None
    needs: tuple[str, ...] = ()
    numbers: tuple[str, ...] = ()
    robot: Literal["quadrotor", "car", "both", "robot with joints", "model with named parameters"] = "both"
    columns: Literal["", "action", "state", "joint", "site", "parameter"] = ""
    of_attitude: bool = False
    of_all: Callable[[Body], bool] = _of_none
    parts: Callable[[Values, Body], tuple[tuple[Kind, Values], ...]] | None = None
    hidden: tuple[str, ...] = ()
    shared: tuple[str, ...] = ()
    contradiction: Callable[[Numbers], str] = lambda _: ""
    counts_as: tuple[str, ...] = ()
    searching: Searching = field(default_factory=Searching)
    by_torque: Callable[[Body], bool] = lambda _: False
    lagging: bool = False
    reads: tuple[str, ...] = ()
    scales: str = ""
    distinguished_by: str = ""
    nuisance: tuple[float, float] | None = None
    of_joints: str = ""

    @property
    def column_needed(self) -> bool:
        """Whether it is never on all columns at once."""
        return bool(self.columns) and self.of_all is _of_none

    def fits(self, body: Body) -> bool:
        """Whether robots like this one can have it."""
        if self.robot == "both":
            return body.moves != "joints" or bool(self.columns)
        if self.robot == "robot with joints":
            return bool(body.joints)
        if self.robot == "model with named parameters":
            return bool(body.parameters)
        return self.robot == {"space": "quadrotor", "plane": "car"}.get(body.moves)
