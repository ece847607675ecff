"""Neural networks: what equations leave over and how it is trained, and the ensemble that the paper compares with."""

from sym2real.neural.composed import Composed
from sym2real.neural.descent import Descent
from sym2real.neural.ensemble import Ensemble
from sym2real.neural.residual_mlp import ResidualMLP
from sym2real.neural.residual_training import PAPER, ResidualTraining, TrainingReport
from sym2real.neural.storage import load_residual, save_residual

__all__ = [
    "PAPER",
    "Composed",
    "Descent",
    "Ensemble",
    "ResidualMLP",
    "ResidualTraining",
    "TrainingReport",
    "load_residual",
    "save_residual",
]
