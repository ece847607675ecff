"""What comes before any search: checked data, candidates, the covariance that weighs errors, the base's own faults."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import torch

from sym2real.diagnosis.calibrate import Calibration, calibrated
from sym2real.diagnosis.candidates import Candidate, candidates, library_for, swings, with_inputs_of
from sym2real.diagnosis.competing import NotTried, competing
from sym2real.diagnosis.fit import Problems
from sym2real.diagnosis.lengths import long_enough
from sym2real.diagnosis.library import SWINGING, Library
from sym2real.diagnosis.nuisance import nuisance_of
from sym2real.diagnosis.overfit import overfitted
from sym2real.diagnosis.prepared import with_filtered_commands
from sym2real.diagnosis.refine import refined
from sym2real.diagnosis.sanity import Checked, check
from sym2real.diagnosis.sensitivity import Problem
from sym2real.diagnosis.simulator import SWITCHED_OFF, flown_along, with_effects_of
from sym2real.diagnosis.swing import Swing, find_swing
from sym2real.diagnosis.unpredicted import unpredicted_said
from sym2real.diagnosis.whitening import Spread, Whitening, estimate
from sym2real.plants import MujocoPlant
from sym2real.robots import PER_KILOGRAM
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset, Trajectory

OnProgress = Callable[[str], None]
NO_SWING = "nothing in these logs swings at a frequency that is not the path's"

# Times that variances are estimated from over-fitted residuals, each over-fit weighed by the last estimate.
ROUNDS = 3


@dataclass(frozen=True, eq=False)
class Weighed:
    """A model against checked data, ready for hypotheses.

    Args:
        model: the base without its command filters, which have acted on the data.
        checked: the data, faults undone.
        library: the model's equations with every candidate in them; hypotheses compete on a refined base.
        tried: what competes.
        problems: data, whitening, folds.
        spread: what shapes the covariance.
        origin: parameter set from which effects are counted: null, or what calibration says of the base ``# (P,)``.
        calibration: the base against the plain simulator; None without one.
        notes: remarks on data and method.
        plant: the plain simulator with the effects that the model has already, if there is one.
        swing: frequency and phases of a force that swings, if one was found.
        not_tried: effects that do not compete, and why.
    """

    model: Equations
    checked: Checked
    library: Library
    tried: tuple[Candidate, ...]
    problems: Problems
    spread: Spread
    origin: torch.Tensor
    calibration: Calibration | None
    notes: tuple[str, ...]
    plant: MujocoPlant | None = None
    swing: Swing | None = None
    not_tried: tuple[NotTried, ...] = ()

    @property
    def whitening(self) -> Whitening:
        """Noise and disturbances of the logs."""
        return self.problems.whitening


def weigh(
    model: Equations,
    data: Dataset | Trajectory,
    plant: MujocoPlant | None,
    *,
    calibrate: bool = True,
    exclude: Collection[str] = (),
    include: Sequence[str] = (),
    on_progress: OnProgress = lambda _: None,
) -> Weighed:
    """Check the data, weigh errors, calibrate the base; arguments as of :func:`sym2real.diagnosis.diagnose`.

    Args:
        include: keys of effects that compete whatever the rules for candidates say.
    """
    on_progress("checking the data")
    checked = check_and_filter(model, data)
    plant, uncalibrated = with_effects_of(model, plant)
    flown = None
    if not calibrate:
        uncalibrated = SWITCHED_OFF
    elif plant is not None:
        on_progress("calibrating the base in the plain simulator")
        flown, uncalibrated = flown_along(model, plant, checked.data)
    notes = [*checked.notes, *units_said(model), *([uncalibrated] if uncalibrated else [])]
    model = replace(model, filters=()) if model.filters else model
    library = library_for(model, checked.data, exclude, include)
    base = model if flown is None else refined(library, flown, checked.data)
    searched = library if base is model else library_for(base, checked.data, exclude, include)
    tried, problem = candidates(searched, checked.data), Problem(searched, checked.data)
    notes += unpredicted_said(problem)
    on_progress("weighing errors")
    spread, whitening, values = whiten(problem, tried)
    swing = None
    if any(name in SWINGING for name in searched.effects):
        swing = find_swing(Problems.of(problem, whitening), values, len(tried))
    if swing is not None:
        checked = replace(checked, data=swing.in_data(checked.data))
        tried, problem = candidates(searched, checked.data), Problem(searched, checked.data)
        spread, whitening, _ = whiten(problem, tried)
    calibration = None if flown is None else calibrated(searched, tried, flown, whitening)
    origin = searched.null if calibration is None else calibration.origin
    problems = Problems.of(problem, whitening, nuisance_of(searched, origin))
    not_tried = _not_tried(model, checked.data, exclude, include)
    return Weighed(
        model, checked, library, tried, problems, spread, origin, calibration, tuple(notes), plant, swing, not_tried
    )


def _not_tried(
    model: Equations, data: Dataset, exclude: Collection[str], include: Sequence[str]
) -> tuple[NotTried, ...]:
    keys, others = competing(with_inputs_of(model, data), data, exclude)
    calm = [NotTried(key, NO_SWING) for key in keys if key in SWINGING and not swings(data)]
    return (*(one for one in others if one.effect not in include), *calm)


def units_said(model: Equations) -> list[str]:
    """What a reader of forces and masses must know, where nobody gave the robot's mass."""
    return [note for note in model.notes if note == PER_KILOGRAM]


def check_and_filter(model: Equations, data: Dataset | Trajectory) -> Checked:
    """Faults of the data undone, and commands as they reach a robot with the model's own filters.

    Raises:
        ShapeError: when no log is long enough to judge.
    """
    checked = check(model, long_enough(data))
    return replace(checked, data=with_filtered_commands(model, checked.data))


def whiten(problem: Problem, tried: tuple[Candidate, ...]) -> tuple[Spread, Whitening, torch.Tensor]:
    """The covariance of what a fully explained model leaves, from over-fitted residuals; and the over-fit itself."""
    null, segments = problem.library.null, problem.segments
    spread = Spread.of(problem, null)
    whitening = estimate(spread, problem.residuals(null[None])[0], segments.noise, segments.channel, alike=True)
    values = overfitted(Problems.of(problem, whitening), tried, null)
    for left in reversed(range(ROUNDS)):
        if left < ROUNDS - 1:
            values = overfitted(Problems.of(problem, whitening), tried, null, values)
        residuals = problem.residuals(values[None])[0]
        whitening = estimate(spread, residuals, segments.noise, segments.channel, alike=left == ROUNDS - 1)
    return spread, whitening, values
