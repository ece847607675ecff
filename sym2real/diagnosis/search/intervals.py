"""Values of what was found, with intervals."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import torch
from scipy.optimize import brentq
from scipy.stats import norm
from torch import Tensor

from sym2real.diagnosis.estimate.fit import Fit
from sym2real.diagnosis.estimate.significance import collinear, half_widths
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.near import Near
from sym2real.diagnosis.search.select import EffectSet, Selection, reported
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.kind import Parameter, with_unit
from sym2real.effects.manoeuvres import typical_speed
from sym2real.effects.tyres import STANDING
from sym2real.logs.resample import is_resampled

# Filters act on one number a control step, its mean but behind rate loops. One that changes steadily within it moves a
# position by a third of its change, its mean by a half: a sixth of a step by which a lag or a delay is unsure. Of a
# log that was resampled commands changed within steps: what goes by a step's last goes by its mean, half a step away.
WITHIN_A_STEP, OF_UNEVEN = 1 / 6, 1 / 2
OF_SPEED = {"s": 0, "m": 1, "s²/m": -1}  # by the unit of a lag, the power of the speed by which a time becomes it
# Standard deviations of a 95 % interval.
TWO_SIDED = 1.96


@dataclass(frozen=True)
class Estimate:
    """A parameter's value with its 95 % interval; its bounds where the logs say nothing of it."""

    value: float
    low: float
    high: float
    unit: str
    determined: bool = True

    @property
    def text(self) -> str:
        """Value and unit, beside an interval."""
        return with_unit(self.value, self.unit) if self.determined else "undetermined"

    @property
    def with_half_width(self) -> str:
        """Value, interval and unit for a sentence, to two digits of how far the next end of it is; both ends where one
        is much further.
        """
        half, nearest = (self.high - self.low) / 2, min(self.high - self.value, self.value - self.low)
        if not (self.determined and 0.0 < half < math.inf):
            return self.text
        places = max(0, 1 - math.floor(math.log10(max(nearest, half / 100))))
        value, low, high, width = (f"{number:.{places}f}" for number in (self.value, self.low, self.high, half))
        even = abs(self.high + self.low - 2 * self.value) < half * SETTINGS.mostly
        interval, unit = f"± {width}" if even else f"({low} … {high})", "" if self.unit == "1" else self.unit
        return f"{value} {interval} {unit}".rstrip()


def about(value: float, deviation: float, unit: str) -> Estimate:
    """A value with the interval that its standard deviation makes."""
    return Estimate(value, value - TWO_SIDED * deviation, value + TWO_SIDED * deviation, unit)


def estimates(selection: Selection, candidate: Candidate, fit: Fit, near: Near | None) -> dict[str, Estimate]:
    """Values of a chosen candidate in a fit of all, by parameter.

    Intervals cover the choice of near sets: of all of them, by their weights, 95 % lie inside (Bayesian model
    averaging; J. Hoeting, D. Madigan, A. Raftery, C. Volinsky, Statistical Science 14 (1999) 382–417).
    """
    by_parameter, by_inertia = {}, _by_inertia(selection, candidate, fit)
    sets, weights = near.sets_with(candidate) if near else ([selection.present], torch.ones(1))
    shifts = torch.stack([effects.fit.values - sets[0].fit.values for effects in sets])
    for index, (slot, value, half) in zip(candidate.free, _around(selection, candidate, fit), strict=True):
        known = half < math.inf
        ends = averaged_ends(value, half, shifts[:, index], weights) if known else (slot.low, slot.high)
        either = [end * factor for end in ends for factor in (1.0, by_inertia)] if known else ends
        low, high = map(slot.domain.nearest, (min(either), max(either)))
        by_parameter[slot.name] = Estimate(value, low, high, slot.unit, known)
    return by_parameter


def _by_inertia(selection: Selection, candidate: Candidate, fit: Fit) -> float:
    """Factor on a torque where what makes the rate loop softer than nominal is inertia, not its stiffness; else one.

    The first of the nuisance parameters is the loop's gain, which torques are divided by.
    """
    problems = selection.problems
    effect = problems.library.effects[candidate.name]
    if not effect.of.by_torque(effect.body) or not problems.nuisance:
        return 1.0
    return 1.0 / float(fit.values[min(problems.nuisance)])


def averaged_ends(value: float, half: float, shifts: Tensor, weights: Tensor) -> tuple[float, float]:
    """Ends of an interval that holds the chosen set's own, and 95 % of normal distributions about all sets' values.

    Args:
        value: in the chosen set.
        half: half-width of the 95 % interval there.
        shifts, weights: of the value in every set, from the chosen one's, and of the sets ``# (sets,)``.
    """
    if half == 0.0:
        return value + float(shifts.min()), value + float(shifts.max())
    places = TWO_SIDED * shifts.numpy() / half

    def below(end: float, part: float) -> float:
        return float(weights.numpy() @ norm.cdf(end - places)) - part

    low = brentq(below, places.min() - 3.0, places.max() - 1.0, args=(0.025,))
    high = brentq(below, places.min() + 1.0, places.max() + 3.0, args=(0.975,))
    return value + min(low * half / TWO_SIDED, -half), value + max(high * half / TWO_SIDED, half)


def none_within(near: Near, candidate: Candidate) -> bool:
    """Whether a chosen candidate is none within the intervals of all its parameters, in the chosen set or another that
    may as well be true; with few blocks nobody can say.
    """
    selection, (sets, weights) = near.selection, near.sets_with(candidate)
    likely = (effects for effects, weight in zip(sets, weights, strict=True) if weight > SETTINGS.level)
    none = any(_none_in(selection, candidate, effects) for effects in likely)
    return none and selection.problems.block_count >= SETTINGS.fewest_pieces


def _none_in(selection: Selection, candidate: Candidate, effects: EffectSet) -> bool:
    """The same in one set. What is unsure only beside others may be there for sure (:func:`collinear`)."""
    around, problem = _around(selection, candidate, effects.fit), selection.problems.problem
    pairs = zip(candidate.free, around, strict=True)
    acting = [(abs(value - own.null), half, index) for index, (own, value, half) in pairs if own.acts_alone]
    if not all(away < half for away, half, _ in acting):
        return False
    hidden = all(away < unresolved(problem, index) for away, _, index in acting)
    return hidden or not (collinear(effects.fit, candidate) and selection.significant(effects.fit, candidate))


def _parameter(selection: Selection, index: int) -> Parameter:
    return selection.problems.library.slots[index].parameter


def _around(selection: Selection, candidate: Candidate, fit: Fit) -> Iterator[tuple[Parameter, float, float]]:
    """Parameter, reported value and half of its 95 % interval, of each that a chosen candidate has."""
    problem, halves = selection.problems.problem, half_widths(selection.problems, fit)
    halves = torch.where(selection.problems.identifiable(fit), halves, math.inf)
    library = problem.library
    for place, index in zip(fit.places(candidate.free), candidate.free, strict=True):
        effect, slot = library.effects[library.slots[index].effect], _parameter(selection, index)
        value = reported(float(fit.values[index]), float(selection.origin[index]), slot)
        # Of a factor that is far from one the smaller: of a hundredth, and of what it lacks to one.
        reference = min(abs(value - slot.null), abs(value)) if slot.null in (0.0, 1.0) else value
        # Nobody knows how a torque is answered.
        by_torque = SETTINGS.stiffness * effect.of.by_torque(effect.body)
        by_form = SETTINGS.interval_floor**2 + by_torque**2
        squares = (float(halves[place]) * slot.scale) ** 2 + by_form * reference**2
        yield slot, value, (squares + unresolved(problem, index) ** 2) ** 0.5


def unresolved(problem: Problem, index: int) -> float:
    """Half-width of what control steps hide, in a slot, of when a command acts; none of other effects."""
    slot = problem.library.slots[index]
    kind, power = problem.library.effects[slot.effect].of, OF_SPEED.get(slot.parameter.unit)
    if power is None or not (kind.lagging or (kind.columns == "action" and power == 0)):
        return 0.0
    hidden = (OF_UNEVEN if any(map(is_resampled, problem.data)) else WITHIN_A_STEP) * problem.data.dt
    return hidden * (max(typical_speed(problem.data), STANDING) ** power if power else 1.0)


def attenuated(selection: Selection, candidate: Candidate, fit: Fit) -> bool:
    """Whether factors on what commands do may be below one as those are held over rows: one may be one to a tenth.

    Held, a command that changes between rows is a regressor with errors. The factor is then between its estimate v and
    the reverse regression's, v/R² (R. Frisch, 1934; S. Klepper, E. Leamer, Econometrica 52, 1984). R² is the part that
    the factor's share has in itself and all errors together, the sensors' noise taken off. Where one of the factors is
    far below one all the same, that is not all.
    """
    problem, slots = selection.problems.problem, candidate.slots
    if not problem.library.effects[candidate.name].searching.attenuated:
        return False
    fitted, limits, near = estimates(selection, candidate, fit, None), list[float](), False
    noise, lines = torch.as_tensor(problem.segments.noise).square(), problem.linearised(fit.values[None], [slots])[0]
    missed, *shares = lines.square().unflatten(1, (-1, len(noise))).mean((0, 1)).unbind(-1)  # (C,) each
    for parameter, share in zip((_parameter(selection, index) for index in slots), shares, strict=True):
        factor, most = fitted[parameter.name], int((share / noise).argmax())
        explained = share[most] * (factor.value / parameter.scale) ** 2
        errors = max(float((missed[most] - noise[most]) / explained), 0.0)
        limits.append(factor.value * (1.0 + errors))
        near |= factor.high < 1.0 and errors > SETTINGS.worth_saying > 1.0 - limits[-1]
    return near and SETTINGS.far * min(limits) > 1.0


def spread_over_logs(selection: Selection, candidate: Candidate, fit: Fit) -> dict[str, float]:
    """Standard deviation over logs of each parameter when every log fits its own, in its unit; none for one log."""
    problems = selection.problems
    log = torch.as_tensor(problems.problem.segments.log)
    steps = [problems.best_step(fit.of_segments(log == index)) for index in log.unique()]
    if len(steps) < 2:
        return {}
    deviation, places = torch.stack(steps).std(dim=0), fit.places(candidate.free)
    slots = [_parameter(selection, index) for index in candidate.free]
    return {slot.name: float(deviation[place]) * slot.scale for place, slot in zip(places, slots, strict=True)}
