"""Neural networks: what a base leaves over and how it is trained, and the ensemble that the paper compares with."""

from sym2real.neural.composed import Composed
from sym2real.neural.descent import Descent
from sym2real.neural.ensemble import Ensemble
from sym2real.neural.ensemble_training import EnsembleTraining
from sym2real.neural.exporting import export
from sym2real.neural.memory_length import memory_length
from sym2real.neural.model_folder import Model, open_model, save_model
from sym2real.neural.particles import particle_rollouts
from sym2real.neural.residual_mlp import ResidualMLP
from sym2real.neural.residual_training import PAPER, ResidualTraining, TrainingReport
from sym2real.neural.storage import load_residual
from sym2real.neural.symbolic_residual import SymbolicResidual

__all__ = [
    "PAPER",
    "Composed",
    "Descent",
    "Ensemble",
    "EnsembleTraining",
    "Model",
    "ResidualMLP",
    "ResidualTraining",
    "SymbolicResidual",
    "TrainingReport",
    "export",
    "load_residual",
    "memory_length",
    "open_model",
    "particle_rollouts",
    "save_model",
]
