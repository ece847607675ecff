"""Neural networks: what equations leave over, and the ensemble that the paper compares with. Training comes later."""

from sym2real.neural.composed import Composed
from sym2real.neural.ensemble import Ensemble
from sym2real.neural.residual_mlp import ResidualMLP
from sym2real.neural.storage import load_residual, save_residual

__all__ = ["Composed", "Ensemble", "ResidualMLP", "load_residual", "save_residual"]
