"""Correlations over lags of series in pieces, and their bands.

The bands hold when the series follow themselves: two independent series of n rows with autocorrelations ρ and σ have
correlations of the variance (Bartlett)

    var r(k) ≈ 1/n* = 1/n · (1 + 2 Σ_j ρ(j) σ(j)),        j = 1 … n/5

where ±1.96/√n is right only if one of them is white. The autocorrelation of a series that is correlated over one row
only has var r(k) ≈ (1 + 2 ρ(1)²)/n beyond that row.

Source: M. S. Bartlett, J. R. Stat. Soc. Suppl. 8 (1946) 27–41; G. Box, G. Jenkins, G. Reinsel, Time Series Analysis,
chapters 2 and 12; the sum's length: B. Pyper and R. Peterman, Can. J. Fish. Aquat. Sci. 55 (1998) 2127–2140.
"""

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from sym2real.trajectory import Array

# Part of the rows over which autocorrelations are summed.
SUMMED = 0.2
SHORTEST = 3  # rows: a shorter piece has no correlation worth the name


def centred(pieces: Sequence[Array]) -> list[Array]:
    """Each piece less its own mean, the short ones left out ``# (rows,)`` each."""
    return [piece - piece.mean() for piece in pieces if len(piece) >= SHORTEST]


def cross_correlations(later: Sequence[Array], earlier: Sequence[Array], lags: int) -> Array:
    """Correlations of ``later`` with ``earlier`` −lags … lags rows before, over pieces that do not touch.

    Args:
        later, earlier: centred pieces in the same order ``# (rows,)`` each, a pair of one length.
        lags: rows; with a negative lag ``later`` comes first.

    Returns:
        ``# (2 lags + 1,)``.
    """
    shared = np.zeros(2 * lags + 1)
    for first, other in zip(later, earlier, strict=True):
        shared += sliding_window_view(np.pad(other, lags), len(first))[::-1] @ first
    size = np.sqrt(sum(float(piece @ piece) for piece in later) * sum(float(piece @ piece) for piece in earlier))
    return shared / size if size > 0 else shared


def autocorrelation(pieces: Sequence[Array], lags: int) -> Array:
    """Correlation of centred pieces with themselves 1 … ``lags`` rows before ``# (lags,)``, by Fourier transform."""
    shared = np.zeros(lags)
    for piece in pieces:
        spectrum = np.fft.rfft(piece, 2 * len(piece))
        products = np.fft.irfft(np.abs(spectrum) ** 2, 2 * len(piece))[1 : min(lags, len(piece) - 1) + 1]
        shared[: len(products)] += products
    size = sum(float(piece @ piece) for piece in pieces)
    return shared / size if size > 0 else shared


def summed_lags(pieces: Sequence[Array]) -> int:
    """Over how many lags autocorrelations are summed: a fifth of the longest piece."""
    return max(1, int(SUMMED * max(map(len, pieces))))


def cross_deviation(rows: int, first: Array, other: Array) -> float:
    """Standard deviation of the correlation at any lag of two independent series.

    Args:
        rows: of all pieces together.
        first, other: their autocorrelations from lag 1 on ``# (lags,)``; biased, so that far lags count less.
    """
    inflated = 1.0 + 2.0 * float(first @ other)
    # A sum of estimates may come out below what white series have; that is no reason to be surer.
    return float(np.sqrt(max(inflated, 1.0) / rows))


def own_deviations(rows: int, own: Array) -> Array:
    """Standard deviations of autocorrelations of a series that remembers at most one row ``# (lags,)``."""
    deviations = np.full(len(own), np.sqrt((1.0 + 2.0 * own[0] ** 2) / rows))
    deviations[0] = np.sqrt(1.0 / rows)
    return deviations
