"""What a manoeuvre can show, before it is flown: the smallest effect that would be found, and what it is taken for.

An effect of size β changes the residuals of a log by r(β); what the free start cannot absorb of it, whitened, is
λ(β) = ‖r(β)‖². It is found where λ exceeds what the acceptance rule of the search asks for: a relative gain, and
Hotelling's test on blocks, which is Student's t for one parameter, also where blocks, or whole logs, of measured ones
differ by more than their noise does; and where it matters for predictions (see ``visible.py``), or whole logs tell it
from trim. Near zero λ = β²F with the sensitivity matrix F = JᵀC⁻¹J; effects that begin at a threshold (limits, grip,
dead bands) are evaluated at rising sizes instead, and forces that swing by the test that finds them among all
frequencies.

Two effects cannot be distinguished where one's residuals are the other's (see ``visible.py``).
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from math import inf

import numpy as np
import torch
from scipy import stats
from torch import Tensor

from sym2real.dataset import Logs
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.data.segments import cut
from sym2real.diagnosis.design.visible import AssumedNoise, Changes, Others, Plan, Predictions, Visible
from sym2real.diagnosis.errors.floor import SensorNoise
from sym2real.diagnosis.estimate.fit import Hypothesis, Problems
from sym2real.diagnosis.estimate.preparation import whiten
from sym2real.diagnosis.estimate.significance import least_gain, sizes_beyond_chance
from sym2real.diagnosis.estimate.swing import smallest_swings
from sym2real.diagnosis.estimate.whitening import Spread
from sym2real.diagnosis.predict.candidate import Candidate, candidates, library_for
from sym2real.diagnosis.predict.competitors import values_for
from sym2real.diagnosis.predict.instability import steady_length
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.intervals import unresolved
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.along_logs import with_filtered_commands
from sym2real.effects.catalogue import always_alike
from sym2real.symbolic import Equations
from sym2real.symbolic.mass_normalised import units_notes
from sym2real.threads import one_thread


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
    segments = cut(dataset, length=steady_length(library, dataset))
    problem, competing = Problem(library, dataset, segments), candidates(library, dataset)
    problems, sensors = _with_noise(problem, competing, noise)
    needed, predictions = _needed(problems, len(competing)), Predictions.of(problems, sensors)
    smooth = [candidate for candidate in competing if not candidate.needs_start]
    changes = Changes.of(problems, smooth)
    visible = _smooth(smooth, changes, predictions, needed, len(competing) if noise is None else None)
    visible += [_threshold_row(own, changes, predictions, needed) for own in competing if own.needs_start]
    visible += _swinging(problems, predictions, len(competing))
    return Plan(
        visible=tuple(sorted(visible, key=lambda row: list(library.effects).index(row.effect))),
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
        return Problems(whitened.problem, whitened.whitening), None
    spread, segments = Spread.of(problem, problem.library.null), problem.segments
    fields = segments.layout.fields
    sensors = torch.tensor([noise.sensors[fields[number].name] for number in segments.channel], dtype=torch.float64)
    sizes = torch.tensor([noise.disturbances.get(name, 0.0) for name in spread.names], dtype=torch.float64)
    whitening = spread.whitening(sensors.square(), (sizes / spread.sizes).square().clamp_min(1e-8))
    return Problems(problem, whitening), SensorNoise.assumed(noise.sensors, problem.data)


def _needed(problems: Problems, competitors: int) -> float:
    """Fall of the whitened loss that the acceptance rule asks for beside another effect; an only one needs half."""
    of_gain = SETTINGS.gain_beside / (1.0 - SETTINGS.gain_beside) * problems.whitening.freedom
    if problems.block_count < SETTINGS.fewest_pieces:
        return of_gain
    chance = SETTINGS.false_alarms_of_each(competitors)
    return max(of_gain, float(stats.t.isf(chance / 2, problems.block_count - 1)) ** 2)


def _smooth(
    smooth: Sequence[Candidate], changes: Changes, predictions: Predictions | None, needed: float, tested: int | None
) -> list[Visible]:
    """Rows of effects that act from zero on; where the noise was measured its blocks and logs, too, must tell them."""
    problems, free = changes.problems, tuple(slot for candidate in smooth for slot in candidate.free)
    library = problems.library
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
        places = fit.places(candidate.free)
        _, others = changes.others(changes.columns[..., places], but=candidate.name)
        rows += _smooth_rows(candidate, library, sizes[places], mattering[places], others)
    return rows


def _smooth_rows(
    candidate: Candidate, library: Library, seen: Tensor, mattering: Tensor, others: Sequence[Others]
) -> list[Visible]:
    """A row per parameter, from the sizes from which on it is seen and matters, in units of scale ``# (A,)``."""
    rows, always = [], always_alike(candidate.name, library.equations)
    for place, own, matter, part in zip(candidate.free, seen.tolist(), mattering.tolist(), others, strict=True):
        if not (slot := library.slots[place].parameter).acts_alone:  # at none it does nothing
            continue
        largest = SETTINGS.nearly * max(slot.high - slot.null, slot.null - slot.low)
        sizes = [slot.scale * size for size in (own, own / part.left**0.5, matter)]
        smallest, separable, matters = (size if size < largest else None for size in sizes)
        row = (smallest, separable, matters, part.nearest, part.like, always, library.effects[candidate.name].shown_by)
        rows.append(Visible(candidate.name, slot.name, slot.unit, *row))
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
        alone = [Others()] * len(sizes)
        rows += _smooth_rows(candidate, library, sizes / library.scale[candidate.slots], mattering, alone)
    return rows


def _threshold_row(own: Candidate, changes: Changes, predictions: Predictions | None, needed: float) -> Visible:
    """The mildest sizes of an effect with a threshold that would be found, separable, and that would matter."""
    problem, library = changes.problems.problem, changes.problems.library
    effect, slot = library.effects[own.name], library.slots[own.free[0]].parameter
    levels = effect.searching.sizes(effect.body, values_for(library.equations, effect, problem.data))
    sets = library.null.repeat(len(levels) + 1, 1)
    sets[1:, own.free[0]] = torch.as_tensor(np.asarray(levels))
    residuals = problem.residuals(sets)
    squares, others = changes.others((residuals[1:] - residuals[0]).permute(1, 2, 0))
    left = torch.tensor([part.left * (not part.like) for part in others], dtype=torch.float64)
    smallest, separable = (_first(levels, part > needed) for part in (squares, squares * left))
    matters = None if predictions is None else _first(levels, predictions.matter(sets[1:]))
    like, nearest, _ = next((part for part, size in zip(others, levels, strict=True) if size == smallest), Others())
    return Visible(own.name, slot.name, slot.unit, smallest, separable, matters, nearest, like, (), effect.shown_by)


def _first(levels: Sequence[float], enough: Tensor) -> float | None:
    return next((level for level, is_enough in zip(levels, enough.tolist(), strict=True) if is_enough), None)
