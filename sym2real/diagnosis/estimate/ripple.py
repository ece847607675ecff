"""How many times in a turn a force along a joint goes up and down, settled before the search, which estimates its size.

As with a force that swings (``swing.py``): the likelihood has as many peaks as the joint passes periods, so that no fit
finds the count from none. What a full model leaves is looked at count by count, along the joint in place of time.
"""

from itertools import pairwise
from math import log, pi

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.signal import find_peaks
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.estimate.swing import AT_A_TIME, OVERSAMPLED
from sym2real.diagnosis.estimate.whitening import PIECES, Whitened
from sym2real.diagnosis.predict.candidate import Counts
from sym2real.diagnosis.settings import SETTINGS
from sym2real.least_squares import solve
from sym2real.vocabulary import push_column

# Periods that logs must pass, so that something repeats at all, and at most a piece passes; peaks that a search tries.
FEWEST_PERIODS, OF_A_PIECE, MOST_PEAKS = 2.0, 0.5, 4


def find_counts(whitened: Whitened) -> Counts:
    """By effect that repeats along a joint, the counts that the residuals ask for beyond chance, if any."""
    effects, names = whitened.problem.library.effects, whitened.spread.names
    own = {key: known.column for key, known in effects.items() if known.searching.repeats}
    pushed = {key: joint for key, joint in own.items() if push_column(joint) in names}
    return {key: counts for key, joint in pushed.items() if (counts := _peaks(whitened, joint))}


def slowest_count(data: Dataset, joint: str) -> float:
    """The least count, in 1/rad or 1/m, of which logs pass so many periods that they show that it repeats."""
    return 2 * pi * FEWEST_PERIODS / max(float(np.ptp(np.concatenate([log.column(joint) for log in data]))), 1e-12)


def _peaks(whitened: Whitened, joint: str) -> tuple[float, ...]:
    """The likeliest counts of one joint, in 1/rad or 1/m: those of which chance makes less of all that were looked at.

    What else is missing moves peaks, so that the likeliest may be another one in the end.
    """
    problem, spread, segments = whitened.problem, whitened.spread, whitened.problem.segments
    pushed = spread.disturbances[:, :, spread.names.index(push_column(joint))]  # (S, R, P)
    products = whitened.whitening.products(torch.cat([whitened.residuals[..., None], pushed], dim=-1))
    rows = zip(segments.log, segments.ahead(), strict=True)
    path = torch.as_tensor(np.stack([problem.data[which].column(joint)[own] for which, own in rows]))  # (S, N - 1)
    edges = segments.edges(PIECES)
    passed = float((path[:, edges[1:] - 1] - path[:, edges[:-1]]).abs().median())  # within a piece
    slowest = slowest_count(problem.data, joint)
    fastest = 2 * pi * OF_A_PIECE / passed if passed else 0.0
    counts = torch.as_tensor(np.arange(slowest, fastest, slowest / FEWEST_PERIODS / OVERSAMPLED))
    falls = torch.cat([_falls(products, path, edges, some) for some in counts.split(AT_A_TIME)])
    chance = 2 * log(max(len(counts), 1) / SETTINGS.false_alarms)
    peaks, found = find_peaks(np.pad(falls.numpy(), 1), height=0.0)
    highest = peaks[np.argsort(-found["peak_heights"])][:MOST_PEAKS] - 1
    return tuple(counts[highest].tolist()) if (falls > chance).any() else ()


def _falls(products: Tensor, path: Tensor, edges: NDArray[np.int64], counts: Tensor) -> Tensor:
    """Of the whitened squares by a sine and a cosine, beside a constant, of each of some counts ``# (F,)``.

    Args:
        products: under C⁻¹, of the residual and of a force on every piece ``# (S, 1 + P, 1 + P)``.
        path: of the joint, row by row ``# (S, N - 1)``.
        edges: rows at which pieces begin, and the last one ends ``# (P + 1,)``.
        counts: ``# (F,)``.
    """
    angle = counts[:, None, None] * path
    waves = torch.stack([angle.sin(), angle.cos(), torch.ones_like(angle)], dim=-1)  # (F, S, N - 1, 3)
    pieces = pairwise(edges.tolist())
    means = torch.stack([waves[:, :, first:last].mean(2) for first, last in pieces], dim=2)  # (F, S, P, 3)
    gradient = torch.einsum("sp,fspk->fk", products[:, 0, 1:], means)
    curvature = torch.einsum("fspk,spq,fsql->fkl", means, products[:, 1:, 1:], means)
    return (gradient * solve(curvature, gradient)).sum(1) - gradient[:, 2].square() / curvature[:, 2, 2]
