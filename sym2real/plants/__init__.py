"""Plants: what a controller acts on, in a simulator or in a model; and episodes on them.

:mod:`sym2real.plants.gymnasium_view` stands apart, so that nobody waits for Gymnasium who does not use it.
"""

from sym2real.plants.episode import run_episode
from sym2real.plants.equations_plant import EquationsPlant
from sym2real.plants.model_plant import ModelPlant
from sym2real.plants.mujoco_plant import MujocoPlant
from sym2real.plants.plant_file import load_plant, save_plant
from sym2real.plants.push import random_push
from sym2real.plants.rollout import rollout_mujoco

__all__ = [
    "EquationsPlant",
    "ModelPlant",
    "MujocoPlant",
    "load_plant",
    "random_push",
    "rollout_mujoco",
    "run_episode",
    "save_plant",
]
