"""What a manoeuvre can show, before it is flown: the smallest effect that would be found, and what it is taken for.

An effect of size β changes the residuals of a log by r(β); what the free start cannot absorb of it, whitened, is
λ(β) = ‖r(β)‖². It is found where λ exceeds what the acceptance rule of the search asks for: a relative gain, and
Hotelling's test on blocks, which is Student's t for one parameter, also where blocks, or whole logs, of measured ones
differ by more than their noise does; and where it matters for predictions (see ``visible.py``), or whole logs tell it
from trim. Near zero λ = β²F with the sensitivity matrix F = JᵀC⁻¹J; effects that begin at a threshold (limits, grip,
dead bands) are evaluated at rising sizes instead, and forces that swing by the test that finds them among all
frequencies.

Two effects cannot be distinguished where one's residuals are the other's: the part of F that fitting the other removes,
tr(F_ab F_bb⁻¹ F_ba) / tr F_aa in units of the parameters' scales, is above 0.96 (a correlation of 0.98). A delay and
a lag are the same to first order, so these are held against each other at the size that is to be expected.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from math import inf

import numpy as np
import torch
from scipy import stats
from torch import Tensor

from sym2real.dataset import Logs
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.design.visible import AssumedNoise, Plan, Predictions, Visible
from sym2real.diagnosis.errors.floor import SensorNoise
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.preparation import whiten
from sym2real.diagnosis.estimate.quadratic import Fit, Hypothesis, solve
from sym2real.diagnosis.estimate.significance import least_gain, sizes_beyond_chance
from sym2real.diagnosis.estimate.swing import smallest_swings
from sym2real.diagnosis.estimate.whitening import Spread, Whitening
from sym2real.diagnosis.predict.candidate import Candidate, candidates, library_for
from sym2real.diagnosis.predict.competitors import values_for
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.intervals import unresolved
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.along_logs import with_filtered_commands
from sym2real.effects.catalogue import always_alike
from sym2real.symbolic import Equations
from sym2real.symbolic.mass_normalised import units_notes
from sym2real.threads import one_thread

# Sizes of a delay or lag in units of what is expected, for comparing one with the other.
SIZES = tuple(np.geomspace(0.25, 4.0, 13))


@one_thread()
def plan(equations: Equations, data: Logs, noise: AssumedNoise | None = None, exclude: Collection[str] = ()) -> Plan:
    """What logs of these manoeuvres would show of every effect that the equations can be given.

    Args:
        equations: the base.
        data: the manoeuvres, flown in a simulator, or a log.
        noise: of the robot; estimated from the log by default.
        exclude: keys or patterns of effects that are not looked at.

    Raises:
        ShapeError: when no trajectory is long enough, or columns differ.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> model, task = robot.nominal(), make_task("circle", robot)
        >>> log = run_episode(MujocoPlant(robot), MPPI(compile_model(model), robot, task), task, steps=60)
        >>> {row.effect for row in plan(model, log).visible} >= {"offset:steer", "gain:speed"}
        True
    """
    dataset = with_filtered_commands(equations, long_enough(data, equations))
    library = library_for(equations, dataset, exclude)
    problem, competing = Problem(library, dataset), candidates(library, dataset)
    problems, sensors = _with_noise(problem, competing, noise)
    needed, predictions = _needed(problems, len(competing)), Predictions.of(problems, sensors)
    chance = len(competing) if noise is None else None
    smooth = [candidate for candidate in competing if not candidate.needs_start]
    visible = _smooth(smooth, problems, predictions, needed, chance)
    thresholds = [candidate for candidate in competing if candidate.needs_start]
    visible += [_threshold_row(candidate, problems, predictions, needed) for candidate in thresholds]
    visible += _swinging(problems, predictions, len(competing))
    order = list(library.effects)
    return Plan(
        visible=tuple(sorted(visible, key=lambda row: order.index(row.effect))),
        seconds=sum(len(trajectory) for trajectory in dataset) * dataset.dt,
        blocks=problems.block_count,
        notes=units_notes(equations),
    )


def _with_noise(
    problem: Problem, competing: tuple[Candidate, ...], noise: AssumedNoise | None
) -> tuple[Problems, SensorNoise | None]:
    """The problem under assumed noise of these sensors, or under that which the logs show."""
    if noise is None:
        whitened = whiten(problem, competing)
        return Problems.of(whitened.problem, whitened.whitening), None
    return Problems.of(problem, _assumed(problem, noise)), SensorNoise.assumed(noise.sensors, problem.data)


def _assumed(problem: Problem, noise: AssumedNoise) -> Whitening:
    spread, segments = Spread.of(problem, problem.library.null), problem.segments
    fields = segments.layout.fields
    sensors = torch.tensor([noise.sensors[fields[number].name] for number in segments.channel], dtype=torch.float64)
    sizes = torch.tensor([noise.disturbances.get(name, 0.0) for name in spread.names], dtype=torch.float64)
    return spread.whitening(sensors.square(), (sizes / spread.sizes).square().clamp_min(1e-8))


def _needed(problems: Problems, competitors: int) -> float:
    """Fall of the whitened loss that the acceptance rule asks for beside another effect; an only one needs half."""
    of_gain = SETTINGS.gain_beside / (1.0 - SETTINGS.gain_beside) * problems.whitening.freedom
    if problems.block_count < SETTINGS.fewest_pieces:
        return of_gain
    chance = SETTINGS.false_alarms_of_each(competitors)
    return max(of_gain, float(stats.t.isf(chance / 2, problems.block_count - 1)) ** 2)


def _alike(problems: Problems, candidate: Candidate, smooth: Sequence[Candidate], fit: Fit) -> tuple[str, ...]:
    """Others that absorb nearly all that a candidate does to the residuals."""
    information, places = fit.curvature.sum(0), fit.places(candidate.free)
    return tuple(
        other.name
        for other in smooth
        if other is not candidate
        and _absorbs(information, places, fit.places(other.free))
        and not (candidate.starts and other.starts and _part_at_size(problems, candidate, other))
    )


def _part_at_size(problems: Problems, first: Candidate, other: Candidate) -> bool:
    """Whether an effect of the expected size differs from every size of the other."""
    library = problems.library
    scales = [float(library.scale[candidate.free[0]]) for candidate in (first, other)]
    sets = library.null.repeat(len(SIZES) + 2, 1)
    sets[1, first.free[0]] = scales[0]
    sets[2:, other.free[0]] = scales[1] * torch.tensor(SIZES, dtype=torch.float64)
    residuals = problems.problem.residuals(sets)
    wanted = residuals[1] - residuals[0]
    whole = float(problems.whitening.loss(wanted[None]).sum())
    left = problems.whitening.loss(residuals[2:] - residuals[1]).sum(1)
    return float(left.min()) > (1.0 - SETTINGS.inseparable) * whole


def _smooth(
    smooth: Sequence[Candidate], problems: Problems, predictions: Predictions | None, needed: float, tested: int | None
) -> list[Visible]:
    """Rows of effects that act from zero on; where the noise was measured its blocks and logs, too, must tell them."""
    library, free = problems.library, tuple(slot for candidate in smooth for slot in candidate.free)
    (fit,) = problems.quadratics([Hypothesis(free, library.null)])
    sizes = (needed / fit.curvature.sum(0).diagonal().clamp_min(1e-300)).sqrt()
    mattering = sizes.new_full(sizes.shape, inf) if predictions is None else predictions.of_parameters(free)
    if tested is not None and smooth:  # measured logs also tell what is narrow from trim
        own = [fit.part(candidate.free) for candidate in smooth]
        gains = [least_gain(problems, candidate, library.null, 2) for candidate in smooth]
        least = np.repeat(gains, [len(candidate.free) for candidate in smooth])
        sizes *= torch.as_tensor(least).div(SETTINGS.gain_beside).sqrt()
        tests = [sizes_beyond_chance(problems, part, tested) for part in own]
        of_chance, of_trim = map(torch.cat, zip(*tests, strict=True))
        sizes = torch.maximum(sizes, of_chance)
        if predictions is not None:  # what predictions do not need, whole logs must establish
            sizes = torch.maximum(sizes, torch.minimum(mattering, of_trim))
    hidden = torch.tensor([unresolved(problems.problem, slot) for slot in free], dtype=torch.float64)
    sizes = torch.maximum(sizes, hidden / library.scale[list(free)])
    rows = list[Visible]()
    for candidate in smooth:
        places, like = fit.places(candidate.free), _alike(problems, candidate, smooth, fit)
        rows += _smooth_rows(candidate, library, sizes[places], mattering[places], like)
    return rows


def _smooth_rows(
    candidate: Candidate, library: Library, seen: Tensor, mattering: Tensor, like: tuple[str, ...] = ()
) -> list[Visible]:
    """A row per parameter, from the sizes from which on it is seen and matters, in units of scale ``# (A,)``."""
    rows, always = [], always_alike(candidate.name, library.equations)
    for place, *sizes in zip(candidate.free, seen.tolist(), mattering.tolist(), strict=True):
        of, slot = library.slots[place].effect, library.slots[place].parameter
        largest = SETTINGS.nearly * max(slot.high - slot.null, slot.null - slot.low)
        smallest, matters = (slot.scale * size if slot.scale * size < largest else None for size in sizes)
        shown_by = library.effects[of].shown_by
        rows.append(Visible(candidate.name, slot.name, slot.unit, smallest, matters, like, always, shown_by))
    return rows


def _swinging(problems: Problems, predictions: Predictions | None, tested: int) -> list[Visible]:
    """Rows of a force that swings, which has to be found among all frequencies; one of them stands for those."""
    library, rows = problems.library, list[Visible]()
    swing, smallest = smallest_swings(problems, SETTINGS.false_alarms_of_each(tested))
    swung = problems.data if swing is None else swing.in_data(problems.data)
    for candidate in (own for own in candidates(library, swung) if library.effects[own.name].searching.swings):
        sizes = torch.as_tensor(np.array([smallest[library.slots[slot].parameter.name] for slot in candidate.free]))
        mattering = torch.full_like(sizes, inf)
        if predictions is not None:
            windows = Problem(library, swung, predictions.problem.segments)
            mattering = replace(predictions, problem=windows).of_parameters(candidate.free)
        rows += _smooth_rows(candidate, library, sizes / library.scale[candidate.slots], mattering)
    return rows


def _absorbs(information: Tensor, own: list[int], other: list[int]) -> bool:
    """Whether the other's parameters absorb nearly all that these do to the residuals."""
    mixed, theirs = information[own][:, other], information[other][:, other]
    whole = float(information[own][:, own].trace())
    return whole > 0 and float((mixed @ solve(theirs, mixed.mT)).trace()) > SETTINGS.inseparable * whole


def _threshold_row(candidate: Candidate, problems: Problems, predictions: Predictions | None, needed: float) -> Visible:
    """The mildest sizes of an effect with a threshold that would be found, and that would matter."""
    problem, library = problems.problem, problems.library
    of = library.slots[candidate.free[0]]
    effect, slot = library.effects[of.effect], of.parameter
    smallest = matters = None
    levels = effect.searching.sizes(effect.body, values_for(library.equations, effect, problem.data))
    if len(levels):
        sets = library.null.repeat(len(levels) + 1, 1)
        sets[1:, candidate.free[0]] = torch.as_tensor(np.asarray(levels))
        residuals = problem.residuals(sets)
        detected = problems.whitening.loss(residuals[1:] - residuals[0]).sum(1) > needed
        smallest = _first(levels, detected)
        matters = None if predictions is None else _first(levels, predictions.matter(sets[1:]))
    return Visible(candidate.name, slot.name, slot.unit, smallest, matters, (), (), effect.shown_by)


def _first(levels: Sequence[float], enough: Tensor) -> float | None:
    return next((level for level, is_enough in zip(levels, enough.tolist(), strict=True) if is_enough), None)
