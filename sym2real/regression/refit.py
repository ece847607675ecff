"""Coefficients of chosen terms: least squares, or least absolute errors by iteratively reweighted least squares."""

from typing import Literal

import numpy as np

from sym2real.trajectory import Array

Loss = Literal["l1", "l2"]

ITERATIONS = 50
CONVERGED = 1e-10
# Residuals below this share of the median one have the same weight, so that no weight becomes infinite.
SMOOTHING = 1e-3


def refit(columns: Array, target: Array, loss: Loss) -> Array:
    """Coefficients ``# (terms,)`` that bring ``columns @ coefficients`` nearest to ``target``.

    Args:
        columns: values of the terms ``# (rows, terms)``.
        target: ``# (rows,)``.
        loss: "l1" for the sum of absolute errors (Schlossmacher, "An iterative technique for absolute deviations
            curve fitting", J. Am. Stat. Assoc. 68, 1973), "l2" for the sum of squares.
    """
    if columns.shape[1] == 0:
        return np.zeros(0)
    scale = np.linalg.norm(columns, axis=0)
    scaled = columns / np.where(scale > 0, scale, 1.0)
    coefficients: Array = _least_squares(scaled, target)
    if loss == "l1":
        coefficients = _least_absolute(scaled, target, coefficients)
    return coefficients / np.where(scale > 0, scale, 1.0)


def _least_squares(columns: Array, target: Array) -> Array:
    return np.asarray(np.linalg.lstsq(columns, target, rcond=None)[0], dtype=np.float64)


def _least_absolute(columns: Array, target: Array, coefficients: Array) -> Array:
    for _ in range(ITERATIONS):
        residual = np.abs(target - columns @ coefficients)
        floor = SMOOTHING * np.median(residual) + np.finfo(float).tiny
        root = np.sqrt(1.0 / np.maximum(residual, floor))
        root /= root.max()
        previous = coefficients
        coefficients = _least_squares(columns * root[:, None], target * root)
        if np.abs(coefficients - previous).max() <= CONVERGED * np.abs(coefficients).max():
            break
    return coefficients
