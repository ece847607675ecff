"""Linear algebra of least squares, in batches: minima, also within bounds, inverses and roots of their matrices."""

import torch
from torch import Tensor

RIDGE = 1e-9
# Far above the smallest normal number, also after the ridge: below it 0/0 is no zero.
LEAST_SCALE = 1e-200
ROUNDS = 2  # of the projected Newton method, per unknown
ROUNDING = 1e-12  # of a sum of squares: hundreds of rows, each rounded to 1e-16, in tens of columns


def solve(matrix: Tensor, vector: Tensor) -> Tensor:
    """Solutions with a hair of ridge, so that directions without weight stay put ``# (..., A, A), (..., A)``.

    Without an unknown (a robot of which nothing is found and nothing is free) there is none to solve for.
    """
    if vector.shape[-1] == 0:
        return vector
    scale = matrix.diagonal(dim1=-2, dim2=-1).clamp_min(LEAST_SCALE)
    ridge = torch.diag_embed(RIDGE * scale + 1e-12 * scale.amax(-1, keepdim=True))
    result: Tensor = torch.linalg.solve(matrix + ridge, vector)
    return result


def solve_within(matrix: Tensor, vector: Tensor, low: Tensor, high: Tensor) -> Tensor:
    """Minima of xᵀAx/2 - bᵀx within bounds ``# (..., A, A), (..., A), (A,), (A,)``.

    The projected Newton method: what a bound holds back stays there, the others go towards where they are best beside
    it, cut at their bounds, and half as far where that is no lower, until nothing changes (D. Bertsekas, SIAM J.
    Control Optim. 20 (1982) 221–246). To cut all unknowns once is no minimum: a lag at its bound hid the inertia beside
    it.
    """
    found = solve(matrix, vector)
    if bool(((low <= found) & (found <= high)).all()):
        return found
    best, goal, part = torch.zeros_like(found).clamp(low, high), found, torch.ones_like(found)
    least = torch.full_like(found[..., :1], torch.inf)
    for _ in range(ROUNDS * vector.shape[-1]):
        found = (best + part * (goal - best)).clamp(low, high)
        if torch.allclose(found, best, rtol=RIDGE, atol=0.0) and bool(least.isfinite().all()):
            break
        pull = vector - (matrix @ found[..., None])[..., 0]
        value = -0.5 * (found * (vector + pull)).sum(-1, keepdim=True)
        lower = value < least
        held = ((found <= low) & (pull < 0.0)) | ((found >= high) & (pull > 0.0))
        ends, free = torch.where(held, found, 0.0), (~held).to(matrix)
        beside = torch.where(held, 0.0, vector - (matrix @ ends[..., None])[..., 0])
        inner = matrix * free[..., None] * free[..., None, :] + torch.diag_embed(1.0 - free)
        least, best = torch.where(lower, value, least), torch.where(lower, found, best)
        goal, part = torch.where(lower, solve(inner, beside) + ends, goal), torch.where(lower, 1.0, part / 2)
    return best


def inverse_of(matrix: Tensor) -> Tensor:
    """Pseudoinverse of a symmetric matrix ``# (..., A, A)``."""
    result: Tensor = torch.linalg.pinv(matrix, hermitian=True)
    return result


def root_plus_identity(squares: Tensor) -> Tensor:
    """The lower triangular root of 1 + GᵀG ``# (…, K, K)``, where G may be so large that rounding hides the 1."""
    whole = torch.eye(squares.shape[-1], dtype=squares.dtype) + squares
    root: Tensor
    root, failed = torch.linalg.cholesky_ex(whole)
    if bool(failed.any()):
        sizes = torch.diag_embed(squares.diagonal(dim1=-2, dim2=-1))
        root = torch.linalg.cholesky(whole + ROUNDING * sizes)
    return root


def inflation(curvature: Tensor) -> Tensor:
    """Times as wide as alone the interval of each parameter is beside the others ``# (A, A) -> (A,)``.

    The root of the variance inflation factor; D. Belsley, E. Kuh, R. Welsch, "Regression Diagnostics", 1980, chapter 3.
    """
    return (curvature.diagonal() * inverse_of(curvature).diagonal()).sqrt()
