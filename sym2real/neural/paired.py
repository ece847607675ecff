"""Errors of several models on the same blocks of time, compared block by block.

Blocks differ much more from each other than models do on one of them: so what counts is the difference on each block,
and its standard error. Source: T. Hastie, R. Tibshirani, J. Friedman, "The Elements of Statistical Learning", 2nd ed.,
section 7.10 (one standard error), here of paired differences.
"""

from collections.abc import Sequence

from torch import Tensor

# Standard errors by which one must be better. Of few blocks the standard error is itself uncertain: so many mean what
# they do of many (Student's t distribution).
SURE = 2.0
# Share of the simplest model's error that is worth a richer one, however sure. Tuned on simulated flights: the tail of
# a lag, or a filter of the sensors, leaves what is small and sure.
WORTH = 0.02


def sureness(gain: Tensor) -> float:
    """Mean gain in its standard errors, as a normal variable is as sure; of one block, whether there is any."""
    from scipy.stats import norm, t  # noqa: PLC0415 — a second to import, and only needed to train

    mean = float(gain.mean())
    if len(gain) == 1:
        return float("inf") if mean > 0 else 0.0
    error = float(gain.std()) / len(gain) ** 0.5
    if not error > 0:
        return float("inf") if mean > 0 else 0.0
    return -float(norm.ppf(t.sf(mean / error, len(gain) - 1)))


def simplest(errors: Sequence[Tensor]) -> int:
    """Place of the first whose error is within a standard error of the best one's, or hardly above it.

    Args:
        errors: of every block ``# (blocks,)``, from the simplest model to the richest.
    """
    best = min(errors, key=lambda losses: float(losses.mean()))
    slight = WORTH * float(errors[0].mean())
    lost = [error - best for error in errors]
    return next(place for place, loss in enumerate(lost) if float(loss.mean()) <= slight or sureness(loss) <= 1.0)
