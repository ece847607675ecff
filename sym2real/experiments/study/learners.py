"""What contestants learn with."""

from __future__ import annotations

from typing import Any

from sym2real.adaptation import NoResidual
from sym2real.adaptation.fine_tuning import FineTuning
from sym2real.adaptation.residual_search import ResidualSearch
from sym2real.experiments.study.contestants import Contestant
from sym2real.neural import ResidualTraining
from sym2real.protocols import Learner
from sym2real.robots import Robot

# Past commands that a residual with memory sees: half a second of a car's, a fifth of a quadrotor's.
COMMANDS = 10


def learner_of(contestant: Contestant, robot: Robot, seed: int) -> Learner[Any, Any]:
    """The learner of a contestant's residual."""
    if contestant.residual == "none":
        return NoResidual()
    if contestant.residual == "sr":
        return ResidualSearch(angles=robot.recipe.angles)
    if contestant.residual == "tuned":
        return FineTuning(seed=seed)
    return ResidualTraining(seed=seed, commands=COMMANDS if contestant.residual == "memory" else 0)
