"""What a plan says: per parameter the smallest effect that would be found, and what it would be taken for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sym2real.diagnosis.json_objects import fields_of
from sym2real.upward import upward


@dataclass(frozen=True)
class AssumedNoise:
    """Noise and disturbances of a robot that has not flown yet.

    Args:
        sensors: standard deviation by state field: m, rad, rad/s.
        disturbances: standard deviation of each, constant over a fifth of a segment, by column.
    """

    sensors: Mapping[str, float]
    disturbances: Mapping[str, float]


@dataclass(frozen=True)
class Visible:
    """What a manoeuvre shows of one parameter.

    Args:
        effect, parameter, unit: which.
        smallest: deviation from the null value that would be found, for limits the value itself; None where none
            within the parameter's bounds would.
        matters: deviation from which on a tenth of a prediction's error goes with the effect, for limits the value
            itself; None where that is beyond the parameter's bounds, or where logs are too short to predict.
        like: effects that this manoeuvre cannot tell from it.
        always: effects that no manoeuvre tells from it.
        shown_by: the manoeuvre that shows it.
    """

    effect: str
    parameter: str
    unit: str
    smallest: float | None
    matters: float | None
    like: tuple[str, ...]
    always: tuple[str, ...]
    shown_by: str

    def to_dict(self) -> dict[str, Any]:
        """An entry of ``visible`` in what ``sym2real plan --json`` prints."""
        return {**vars(self), "like": list(self.like), "always": list(self.always)}


@dataclass(frozen=True)
class Plan:
    """What manoeuvres would show.

    Args:
        visible: a row per parameter, in the order of the catalogue.
        seconds: of data.
        blocks: independent pieces of it; fewer than ten allow provisional findings only.
        notes: remarks on the model.
    """

    visible: tuple[Visible, ...]
    seconds: float
    blocks: int
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        seen = [visible for visible in self.visible if visible.smallest is not None]
        return f"<Plan: {len(seen)} of {len(self.visible)} parameters visible in {self.seconds:.0f} s>"

    def _repr_html_(self) -> str:
        return str(upward("plan_html")(self))

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Pairs of effects that the manoeuvres leave inseparable, each once."""
        found = {tuple(sorted((visible.effect, other))) for visible in self.visible for other in visible.like}
        return tuple(sorted((first, second) for first, second in found))

    def to_dict(self) -> dict[str, Any]:
        """The object that ``sym2real plan --json`` prints."""
        return {**fields_of(self), "inseparable": [list(pair) for pair in self.pairs]}
