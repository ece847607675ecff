"""What a manoeuvre can show, before it is flown: the smallest effect that would be found, and what it is taken for.

An effect of size β changes the residuals of a log by r(β); what the free start cannot absorb of it, whitened, is
λ(β) = ‖r(β)‖². It is found where λ exceeds what the acceptance rule of the search asks for: a relative gain, and
Student's t on blocks. Near zero λ = β²F with the sensitivity matrix F = JᵀC⁻¹J; effects that begin at a threshold
(limits, grip, dead bands) are tried at rising sizes instead.

Two effects cannot be told apart where one's residuals are the other's: the part of F that fitting the other removes,
tr(F_ab F_bb⁻¹ F_ba) / tr F_aa in units of the parameters' scales, is above 0.96 (a correlation of 0.98). A delay and
a lag are the same to first order, so these are held against each other at the size that is to be expected.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
import torch
from scipy import stats
from torch import Tensor

from sym2real.diagnosis.data.lengths import long_enough
from sym2real.diagnosis.data.preparation import with_filtered_commands
from sym2real.diagnosis.design.visible import AssumedNoise, Plan, Visible
from sym2real.diagnosis.estimate.fit import Hypothesis, Problems, solve
from sym2real.diagnosis.estimate.significance import FALSE_ALARMS, FEWEST_BLOCKS
from sym2real.diagnosis.estimate.weighing import units_said, whiten
from sym2real.diagnosis.estimate.whitening import Spread, Whitening
from sym2real.diagnosis.predict.candidate import Candidate, candidates, library_for
from sym2real.diagnosis.predict.commands import values_for
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.select import GAIN
from sym2real.effects.catalogue import always_alike
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset, Trajectory

INSEPARABLE = 0.96
# Of a parameter's bounds: an effect that would have to be larger than this is not seen at all.
LARGEST = 0.9
# Sizes of a delay or lag in units of what is expected, for comparing one with the other.
SIZES = tuple(np.geomspace(0.25, 4.0, 13))


def plan(
    equations: Equations,
    data: Dataset | Trajectory,
    noise: AssumedNoise | None = None,
    exclude: Collection[str] = (),
) -> Plan:
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
    dataset = with_filtered_commands(equations, long_enough(data))
    library = library_for(equations, dataset, exclude)
    problem, tried = Problem(library, dataset), candidates(library, dataset)
    whitening = whiten(problem, tried)[1] if noise is None else _assumed(problem, noise)
    problems = Problems.of(problem, whitening)
    needed = _needed(problems, len(tried))
    smooth = [one for one in tried if not one.needs_start]
    information = _information(problems, smooth)
    like = _alike(problems, smooth, information)
    places = _places(smooth)
    visible = [
        replace(row, like=like[one.name])
        for one in smooth
        for row in _smooth_rows(one, places[one.name], library, information, needed)
    ]
    visible += [_threshold_row(one, problems, dataset, needed) for one in tried if one.needs_start]
    order = [one.name for one in tried]
    return Plan(
        visible=tuple(sorted(visible, key=lambda row: order.index(row.effect))),
        seconds=sum(len(trajectory) for trajectory in dataset) * dataset.dt,
        blocks=problems.block_count,
        notes=tuple(units_said(equations)),
    )


def _assumed(problem: Problem, noise: AssumedNoise) -> Whitening:
    spread, segments = Spread.of(problem, problem.library.null), problem.segments
    fields = segments.layout.fields
    sensors = torch.tensor([noise.sensors[fields[number].name] for number in segments.channel], dtype=torch.float64)
    power = torch.tensor([noise.pushes.get(name, 0.0) for name in spread.names], dtype=torch.float64) / spread.sizes
    return spread.whitening(sensors.square(), power.square().clamp_min(1e-8))


def _needed(problems: Problems, competitors: int) -> float:
    """Fall of the whitened loss that the acceptance rule asks for."""
    of_gain = GAIN / (1.0 - GAIN) * problems.whitening.freedom
    if problems.block_count < FEWEST_BLOCKS:
        return of_gain
    chance = FALSE_ALARMS / max(1, competitors)
    return max(of_gain, float(stats.t.isf(chance / 2, problems.block_count - 1)) ** 2)


def _information(problems: Problems, smooth: Sequence[Candidate]) -> Tensor:
    """The sensitivity matrix of all parameters of the candidates, in units of their scales ``# (A, A)``."""
    free = tuple(tied for one in smooth for tied in one.free)
    (fit,) = problems.quadratics([Hypothesis(free, problems.problem.library.null)])
    return fit.curvature.sum(0)


def _alike(problems: Problems, smooth: Sequence[Candidate], information: Tensor) -> dict[str, tuple[str, ...]]:
    """Per candidate, the others that absorb nearly all that it does to the residuals."""
    places = _places(smooth)
    return {
        one.name: tuple(
            other.name
            for other in smooth
            if other is not one
            and _absorbs(information, places[one.name], places[other.name])
            and not (one.starts and other.starts and _part_at_size(problems, one, other))
        )
        for one in smooth
    }


def _part_at_size(problems: Problems, one: Candidate, other: Candidate) -> bool:
    """Whether an effect of the expected size differs from every size of the other."""
    library = problems.problem.library
    scales = [float(library.scale[candidate.free[0][0]]) for candidate in (one, other)]
    sets = library.null.repeat(len(SIZES) + 2, 1)
    sets[1, list(one.free[0])] = scales[0]
    sets[2:, list(other.free[0])] = scales[1] * torch.tensor(SIZES, dtype=torch.float64)[:, None]
    residuals = problems.problem.residuals(sets)
    wanted = residuals[1] - residuals[0]
    whole = float(problems.whitening.loss(wanted[None]).sum())
    left = problems.whitening.loss(residuals[2:] - residuals[1]).sum(1)
    return float(left.min()) > (1.0 - INSEPARABLE) * whole


def _smooth_rows(
    one: Candidate, places: list[int], library: Library, information: Tensor, needed: float
) -> list[Visible]:
    rows, always = [], always_alike(one.name, library.equations)
    for place, tied in zip(places, one.free, strict=True):
        of, size = library.slots[tied[0]].effect, float(information[place, place])
        slot = library.slots[tied[0]].parameter
        smallest = slot.scale * (needed / size) ** 0.5 if size > 0 else float("inf")
        seen = smallest < LARGEST * max(slot.high - slot.null, slot.null - slot.low)
        shown_by = library.effects[of].shown_by
        rows.append(Visible(one.name, slot.name, slot.unit, smallest if seen else None, (), always, shown_by))
    return rows


def _places(smooth: Sequence[Candidate]) -> dict[str, list[int]]:
    places, first = {}, 0
    for one in smooth:
        places[one.name] = list(range(first, first + len(one.free)))
        first += len(one.free)
    return places


def _absorbs(information: Tensor, own: list[int], other: list[int]) -> bool:
    """Whether the other's parameters absorb nearly all that these do to the residuals."""
    mixed, theirs = information[own][:, other], information[other][:, other]
    whole = float(information[own][:, own].trace())
    return whole > 0 and float((mixed @ solve(theirs, mixed.mT)).trace()) > INSEPARABLE * whole


def _threshold_row(one: Candidate, problems: Problems, data: Dataset, needed: float) -> Visible:
    """The mildest size of an effect with a threshold that would be found."""
    library = problems.problem.library
    of = library.slots[one.free[0][0]]
    effect, slot = library.effects[of.effect], of.parameter
    found = None
    levels = effect.searching.sizes(effect.body, values_for(library.equations, effect, data))
    if len(levels):
        sets = library.null.repeat(len(levels) + 1, 1)
        sets[1:, list(one.free[0])] = torch.as_tensor(np.asarray(levels))[:, None]
        residuals = problems.problem.residuals(sets)
        sizes = problems.whitening.loss(residuals[1:] - residuals[0]).sum(1)
        found = next((level for level, size in zip(levels, sizes, strict=True) if float(size) > needed), None)
    return Visible(one.name, slot.name, slot.unit, found, (), (), effect.shown_by)
