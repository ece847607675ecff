"""Control noise of MPPI: a standard deviation for every action, smoothness over the horizon.

::

    δ = B ε diag(σ),   ε ~ N(0, 1) of shape (draws, actions)

B makes the noise smooth over the horizon; its rows have length one, so that every step has the standard deviations σ.
"""

import numpy as np
import torch
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from torch import Tensor

from sym2real.errors import ShapeError
from sym2real.robots.robot import MPPISettings


def deviations(noise: ArrayLike, actions: int) -> Tensor:
    """Standard deviations ``# (actions,)``; one of zero leaves its action alone.

    Raises:
        ShapeError: for noise of another number of actions, or a standard deviation that is negative or not finite.
    """
    values = torch.as_tensor(np.asarray(noise, dtype=np.float64))
    if values.shape != (actions,) or not bool(values.isfinite().all()):
        raise ShapeError(f"control noise: expected finite numbers for {actions} actions, found {values.tolist()}")
    if (values < 0).any():
        raise ShapeError(f"control noise: expected standard deviations of at least 0, found {values.tolist()}")
    return values


def smoothing(steps: int, dt: float, settings: MPPISettings) -> Tensor:
    """Matrix B ``# (steps, draws)`` that the settings ask for: a spline, correlated noise or white noise.

    Raises:
        ShapeError: when the settings ask for a spline through a single knot.
    """
    if settings.knots:
        return spline(steps, settings.knots)
    if settings.correlation > 0:
        return correlated(steps, dt, settings.correlation)
    return torch.eye(steps, dtype=torch.float64)


def spline(steps: int, knots: int) -> Tensor:
    """Cubic spline through equally spaced knots ``# (steps, knots)``, rows of length one."""
    if knots < 2:
        raise ShapeError(f"control noise: expected 0 knots (no spline) or at least 2, found {knots}")
    through = CubicSpline(np.linspace(0.0, 1.0, knots), np.eye(knots))
    matrix = through(np.linspace(0.0, 1.0, steps))
    return torch.from_numpy(matrix / np.linalg.norm(matrix, axis=1, keepdims=True))


def correlated(steps: int, dt: float, time_constant: float) -> Tensor:
    """Factor ``# (steps, steps)`` of the covariance exp(-|i - j| dt / τ): first-order coloured noise."""
    times = torch.arange(steps, dtype=torch.float64) * dt
    factor: Tensor = torch.linalg.cholesky(torch.exp(-(times[:, None] - times).abs() / time_constant))
    return factor


def require_steps(noise: Tensor, mean: Tensor) -> None:
    """Refuse noise that is not ``# (N, H, m)`` for a mean ``# (H, m)``.

    Raises:
        ShapeError: for other steps or actions, or without a sample.
    """
    if noise.dim() != 3 or noise.shape[1:] != mean.shape or not len(noise):
        wanted = ", ".join(map(str, ("N", *mean.shape)))
        raise ShapeError(f"noise: expected the shape ({wanted}) with N > 0, found {tuple(noise.shape)}")


def sample(count: int, smooth: Tensor, spread: Tensor, generator: torch.Generator) -> Tensor:
    """Noise ``# (count, steps, actions)``; the first sample is zero, so that the mean is among the candidates."""
    draws, actions = smooth.shape[1], len(spread)
    normal = torch.randn(draws, actions, count, generator=generator, device=spread.device, dtype=spread.dtype)
    normal[..., 0] = 0.0
    # Samples lie next to each other, as rollouts and weights read them.
    by_step = spread[:, None] * (smooth @ normal.reshape(draws, -1)).reshape(-1, actions, count)
    return by_step.permute(2, 0, 1)
