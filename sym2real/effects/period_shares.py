"""What a loop behind a command that moves within a period makes of it: weights of the one number that stands for it."""

import torch
from torch import Tensor

SMALL = 1e-3  # of what a quotient's limit is taken for; its square is lost in single precision


def _mean_kept(x: Tensor) -> Tensor:
    """(1 - e^-x)/x, also of zero: the mean over a period of what a loop keeps, x its gain times the period."""
    small = x.abs() < SMALL
    return torch.where(small, 1.0 - 0.5 * x, -torch.expm1(-x) / torch.where(small, torch.ones_like(x), x))


def older_share(part: Tensor, gain: Tensor, dt: float) -> Tensor:
    """Weight of the older of two commands that a loop is given for the first ``part`` of a period, and its rest.

    Args:
        part: of the period.
        gain: of the loop, 1/s; 0 of an integrator.
        dt: period in s.
    """
    x = gain * dt
    return torch.exp(-x * (1.0 - part)) * part * _mean_kept(x * part) / _mean_kept(x)


def lag_share(time: Tensor, gain: Tensor, dt: float) -> Tensor:
    """Weight, of a command that fades by e^(-t/τ) over a period, of what it is at its beginning.

    Args:
        time: τ in s.
        gain: of the loop behind, 1/s; 0 of an integrator.
        dt: period in s.
    """
    x, fading = gain * dt, dt / time
    apart, left = x - fading, torch.exp(-fading)
    close = apart.abs() < SMALL
    faded = (left - torch.exp(-x)) / torch.where(close, torch.ones_like(apart), apart)
    return torch.where(close, left * (1.0 - 0.5 * apart), faded) / _mean_kept(x)


def ramp_share(part: Tensor, gain: Tensor, dt: float) -> Tensor:
    """Weight, of a command that moves evenly for the first ``part`` of a period, of what it is at its beginning.

    Args:
        part: of the period.
        gain: of the loop behind, 1/s; 0 of an integrator.
        dt: period in s.
    """
    x = gain * dt
    begun = torch.exp(-x * (1.0 - part)) * _mean_kept(x * part) - torch.exp(-x)
    small = x.abs() < SMALL
    whole = -torch.expm1(-torch.where(small, torch.ones_like(x), x))
    return torch.where(small, 0.5 * part * (1.0 - 0.5 * x + x * part / 3.0), begun / whole)


def kept(time: Tensor, dt: float, gain: Tensor) -> tuple[Tensor, Tensor]:
    """Of a first-order filter's distance: what is left after dt, and its mean over dt, as :func:`lag_share` says."""
    return torch.exp(-dt / time), lag_share(time, gain, dt)
