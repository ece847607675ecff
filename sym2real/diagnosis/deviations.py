"""Fitted parameters as deviations from what calibration says of the base."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor

from sym2real.diagnosis.candidates import Candidate
from sym2real.diagnosis.select import Selection


def reported(value: float, origin: float, null: float) -> float:
    """A fitted value as a deviation from what calibration says of the base, counted from the null value."""
    if null == 0.0:
        return value - origin
    return value / origin if null == 1.0 and origin > 0 else value


def parameter_set(selection: Selection, chosen: Sequence[Candidate], values: Tensor) -> Tensor:
    """The library's parameter set of a model with some effects at their reported values, and nothing else."""
    library = selection.problems.problem.library
    result = library.null
    for one in chosen:
        for index in one.slots:
            null = library.slots[index].parameter.null
            result[index] = reported(float(values[index]), float(selection.origin[index]), null)
    return result
