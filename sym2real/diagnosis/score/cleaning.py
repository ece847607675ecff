"""A fit without what the base's own errors contribute to it.

A base that is nearly right is still off by a little on every manoeuvre, in a way that looks like some of an effect: a
car whose speed in fast turns is wrong by a fifth of a percent seems to have a third of its yaw drag there. The plain
simulator has driven the same manoeuvres without any effect. What a parameter's score Σ JᵀC⁻¹r is there, per segment of
the same log, the base alone contributes to it here; it is taken away, and the fit moves by one Newton step.
"""

from __future__ import annotations

from dataclasses import replace

import torch

from sym2real.diagnosis.estimate.calibrate import Calibration
from sym2real.diagnosis.estimate.fit import Fit, Problems


def cleaned(problems: Problems, fit: Fit, own: Calibration | None) -> Fit:
    """The fit where its cleaned scores vanish; itself without a calibration.

    Args:
        problems: what was fitted.
        fit: at its best.
        own: the base against the plain simulator. Logs that were not flown there are cleaned by the mean of the others.
    """
    if own is None or not fit.whole:
        return fit
    shift = own.scores(fit.whole, problems.problem.log_names)
    moved = replace(fit, gradient=fit.gradient - problems.whitening.trust[:, None] * shift)
    step = problems.best_step(moved)
    gradient = moved.gradient + torch.einsum("sab,b->sa", fit.curvature, step)
    return replace(moved, values=problems.moved(moved, step), gradient=gradient)
