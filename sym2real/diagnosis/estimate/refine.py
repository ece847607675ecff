"""A learned base, its constants fitted once more to whole pieces of what the plain simulator does along the logs.

Regression fits single steps. Over a second, errors of a step add up: a car's base may answer its speed command a fifth
too slowly and still be a good one-step model. Effects that describe such an error exist for few of them, and what they
leave hides small effects of the real robot. So the numbers in the base's equations, not their form, are fitted to the
simulator's flights, which have no noise, by the estimator that reads the logs. It compares velocities here, which have
no noise either: a velocity that positions alone bind may drift off by a tenth, and a force, which acts on it, with it.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import torch

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import Segments, component_noise, cut, with_velocities
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.overfit import improved
from sym2real.diagnosis.estimate.variances import LEAST
from sym2real.diagnosis.estimate.whitening import Spread
from sym2real.diagnosis.predict.library import Library, Slot, shielded
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.kind import Parameter
from sym2real.symbolic import Equations, lift_constants
from sym2real.trajectory import Array

# Relative standard deviation of a constant beforehand; constants that are nearly zero have that of this size.
RELATIVE, SMALL = 0.1, 1e-3
STEPS = 4


def refined(library: Library, flown: Dataset, logs: Dataset) -> Equations:
    """The base with better constants as parameters; itself where its errors are far below the noise of the logs.

    Args:
        library: of the base.
        flown: the plain simulator along the logs.
        logs: whose sensors' noise says what matters.
    """
    noise, segments = component_noise(logs), cut(flown)
    if _misfit(_weighed(library, segments, flown, noise), library.null) < SETTINGS.worth_saying:
        return library.base
    constants = _of_constants(library.base)
    problems, start = _weighed(constants, with_velocities(segments), flown, noise), constants.null
    values = improved(problems, tuple((place,) for place in range(len(constants.slots))), start, start, STEPS)
    found = dict(zip((slot.parameter.name for slot in constants.slots), values.tolist(), strict=True))
    return replace(lifted(library.base), parameters={**library.base.parameters, **found})


def _weighed(library: Library, segments: Segments, flown: Dataset, noise: Array) -> Problems:
    """Errors weigh by the sensors' noise alone ``# (tangent,)``: what the simulator does, nothing disturbs."""
    problem = Problem(library, flown, segments)
    spread = Spread.of(problem, library.null)
    power = torch.full((len(spread.names),), LEAST, dtype=torch.float64)
    sensor = torch.as_tensor(noise[list(segments.compared)]).square()
    return Problems.of(problem, spread.whitening(sensor, power))


def _misfit(problems: Problems, values: torch.Tensor) -> float:
    """Squared error per degree of freedom."""
    loss = problems.whitening.loss(problems.problem.residuals(values[None])).sum()
    return float(loss) / problems.whitening.freedom


lifted = lru_cache(maxsize=4)(lift_constants)  # the same equations again, of which libraries are kept


@lru_cache(maxsize=4)
def _of_constants(base: Equations) -> Library:
    """A library whose parameters are the numbers in the base's equations."""
    free = lifted(base)
    constants = {name: value for name, value in free.parameters.items() if name not in base.parameters}
    slots = tuple(
        Slot("", Parameter(name, "", value, value - 10 * scale, value + 10 * scale, scale))
        for name, value in constants.items()
        for scale in [RELATIVE * max(abs(value), SMALL)]
    )
    return Library(base, shielded(free), {}, slots, shielded(free))
