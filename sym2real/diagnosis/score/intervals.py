"""Values of what was found, with intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import torch

from sym2real.diagnosis.estimate.quadratic import Fit
from sym2real.diagnosis.estimate.significance import half_widths
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.search.select import Selection, reported
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.kind import with_unit

# Filters act on the mean of a command over a control step. One that changes steadily within the step moves a position
# by a third of its change, its mean by a half: a sixth of a step that a lag's time cannot be told from.
WITHIN_A_STEP = 1 / 6
# Standard deviations of a 95 % interval.
TWO_SIDED = 1.96


@dataclass(frozen=True)
class Estimate:
    """A parameter's value with its 95 % interval."""

    value: float
    low: float
    high: float
    unit: str

    @property
    def said(self) -> str:
        """Value and unit, beside an interval."""
        return with_unit(self.value, self.unit)

    @property
    def with_half_width(self) -> str:
        """Value, half the interval and unit for a sentence, to two digits of what is unsure."""
        half = (self.high - self.low) / 2
        if not 0.0 < half < math.inf:
            return self.said
        places = max(0, 1 - math.floor(math.log10(half)))
        return f"{self.value:.{places}f} ± {half:.{places}f} {'' if self.unit == '1' else self.unit}".rstrip()


def about(value: float, deviation: float, unit: str) -> Estimate:
    """A value with the interval that its standard deviation makes."""
    return Estimate(value, value - TWO_SIDED * deviation, value + TWO_SIDED * deviation, unit)


def estimates(
    selection: Selection, candidate: Candidate, fit: Fit, form: Mapping[int, float]
) -> dict[str, dict[str, Estimate]]:
    """Values of a chosen candidate in a fit of all, by effect and parameter; form: variances over near sets.

    Of effects that compete as one, those that are zero within their intervals are left out.
    """
    problem, halves = selection.problems.problem, half_widths(selection.problems, fit)
    library = problem.library
    by_effect: dict[str, dict[str, Estimate]] = {}
    there = set()
    for place, tied in zip(selection.places(selection.chosen, candidate), candidate.free, strict=True):
        for index in tied:
            of, slot = library.slots[index].effect, library.slots[index].parameter
            origin = float(selection.origin[index])
            value = reported(float(fit.values[index]), origin, slot)
            half = float(halves[place]) * slot.scale
            reference = value - slot.null if slot.null in (0.0, 1.0) else value
            floor = (SETTINGS.interval_floor**2 + _stiffness(library, of) ** 2) ** 0.5
            choice = TWO_SIDED**2 * form.get(index, 0.0)
            half = (half**2 + choice + (floor * reference) ** 2 + _unresolved(library, of, problem.data.dt) ** 2) ** 0.5
            by_effect.setdefault(of, {})[slot.name] = Estimate(value, value - half, value + half, slot.unit)
            if abs(value - slot.null) >= half:
                there.add(of)
    return {of: parameters for of, parameters in by_effect.items() if of in there or not there}


def _unresolved(library: Library, name: str, dt: float) -> float:
    """Half-width of what control steps hide of a lag's time in s; none of other effects."""
    return WITHIN_A_STEP * dt if name in library.effects and library.effects[name].of.lagging else 0.0


def _stiffness(library: Library, name: str) -> float:
    """Relative half-width of what nobody knows of how a torque is answered; none of other effects."""
    effect = library.effects.get(name)
    return SETTINGS.stiffness if effect is not None and effect.of.by_torque(effect.body) else 0.0


def spread_over_logs(selection: Selection, candidate: Candidate, fit: Fit) -> dict[str, float]:
    """Standard deviation over logs of each parameter when every log fits its own, in its unit."""
    problems = selection.problems
    log = torch.as_tensor(problems.problem.segments.log)
    steps = [problems.best_step(fit.of_segments(log == index)) for index in log.unique()]
    if len(steps) < 2:
        return {}
    deviation = torch.stack(steps).std(dim=0)
    slots = problems.problem.library.slots
    return {
        slots[tied[0]].parameter.name: float(deviation[place]) * slots[tied[0]].parameter.scale
        for place, tied in zip(selection.places(selection.chosen, candidate), candidate.free, strict=True)
    }
