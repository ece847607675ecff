"""Stretches of logs of which a model predicts no number: their errors are cut off, and count all the same."""

from __future__ import annotations

from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.errors import ModelError

ADVICE = "check the units of its commands and its parameters"


def unpredicted_said(problem: Problem) -> tuple[str, ...]:
    """A sentence where the model without any effect predicts some segments and not others; none where it does all.

    Raises:
        ModelError: when it predicts no segment.
    """
    states = problem.states(problem.library.null[None])[0]
    lost = ~states.isfinite().flatten(1).all(1)
    if lost.all():
        raise ModelError(f"expected a model that predicts finite states along these logs, found none; {ADVICE}")
    if not lost.any():
        return ()
    return (f"the model predicts no number in {int(lost.sum())} of {len(lost)} segments of the logs: {ADVICE}",)
