"""The simulator that a model is held against: the plain one, with the effects that the model has already.

Against a simulator without them, what the model knows rightly would count as its own error.
"""

from __future__ import annotations

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.preparation import with_filtered_commands
from sym2real.diagnosis.estimate.calibrate import simulated
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import injected
from sym2real.errors import Sym2RealError
from sym2real.plants import MujocoPlant
from sym2real.symbolic import Equations

# What a note says where the base is not calibrated.
UNCALIBRATED = "the base's own errors were not calibrated and may look like effects"
SWITCHED_OFF = f"calibration was switched off: {UNCALIBRATED}"
NO_SIMULATOR = f"no plain simulator: {UNCALIBRATED}; diagnose healthy logs first, and add --fit what they show"
NOT_FLOWN = "the logs' manoeuvres cannot be flown in the plain simulator: the base is not calibrated"


def with_effects_of(model: Equations, plant: MujocoPlant | None, dt: float) -> tuple[MujocoPlant | None, str]:
    """The plain simulator with a model's effects, by MuJoCo's own means, commanded every ``dt`` s where logs are slow.

    None, and why, where there is none.
    """
    if plant is None:
        return None, NO_SIMULATOR
    try:
        slow = dt > (1.0 + SETTINGS.time_step) * plant.dt
        robot = plant.robot.at_period(dt) if slow else plant.robot
        changes = (*plant.changes, *injected(model, robot))
        return MujocoPlant(robot, changes, description=plant.description), ""
    except Sym2RealError as error:
        return None, f"no simulator has all effects that the model has already ({error}): {UNCALIBRATED}"


def flown_along(model: Equations, plant: MujocoPlant, logs: Dataset) -> tuple[Dataset | None, str]:
    """The logs' manoeuvres in the simulator, commands as they reach the robot; None, and why, where none can be flown.

    Args:
        model: whose command filters the simulator has too.
        plant: of :func:`with_effects_of`.
        logs: whose manoeuvres are flown.
    """
    flown = simulated(plant, logs)
    return (None, NOT_FLOWN) if flown is None else (with_filtered_commands(model, flown), "")
