"""Neural networks: what a base leaves over and how it is trained, and the ensemble that the paper compares with."""

from sym2real.neural.composed import Composed as Composed
from sym2real.neural.descent import Descent as Descent
from sym2real.neural.ensemble import Ensemble as Ensemble
from sym2real.neural.ensemble_training import EnsembleTraining as EnsembleTraining
from sym2real.neural.exporting import export as export
from sym2real.neural.memory_order import memory_length as memory_length
from sym2real.neural.model_folder import Model as Model, open_model as open_model, save_model as save_model
from sym2real.neural.networks import PAPER as PAPER
from sym2real.neural.particles import particle_rollouts as particle_rollouts
from sym2real.neural.residual_mlp import ResidualMLP as ResidualMLP
from sym2real.neural.residual_training import ResidualTraining as ResidualTraining, TrainingReport as TrainingReport
from sym2real.neural.storage import load_residual as load_residual
from sym2real.neural.symbolic_residual import SymbolicResidual as SymbolicResidual
