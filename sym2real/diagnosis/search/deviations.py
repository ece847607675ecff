"""Fitted parameters as deviations from what calibration says of the base."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor

from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.search.select import Selection
from sym2real.effects.kind import Parameter


def reported(value: float, origin: float, parameter: Parameter) -> float:
    """A fitted value as a deviation from what calibration says of the base, counted from the null value.

    Of what cannot be less than nothing (a delay), less than the base's own is nothing.
    """
    if parameter.null == 0.0:
        return parameter.domain.nearest(value - origin)
    return value / origin if parameter.null == 1.0 and origin > 0 else value


def parameter_set(selection: Selection, chosen: Sequence[Candidate], values: Tensor) -> Tensor:
    """The library's parameter set of a model with some effects at their reported values, and nothing else."""
    library = selection.problems.problem.library
    result = library.null
    for candidate in chosen:
        for index in candidate.slots:
            parameter = library.slots[index].parameter
            result[index] = reported(float(values[index]), float(selection.origin[index]), parameter)
    return result
