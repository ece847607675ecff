"""Plants: what a controller acts on, in a simulator or in a model; and episodes on them.

:mod:`sym2real.plants.gymnasium_view` stands apart, so that nobody waits for Gymnasium who does not use it.
"""

from sym2real.plants.episode import run_episode as run_episode
from sym2real.plants.equations_plant import EquationsPlant as EquationsPlant
from sym2real.plants.model_plant import ModelPlant as ModelPlant
from sym2real.plants.mujoco_plant import MujocoPlant as MujocoPlant
from sym2real.plants.plant_file import load_plant as load_plant, save_plant as save_plant
from sym2real.plants.rollout import rollout_mujoco as rollout_mujoco
from sym2real.plants.wrench import random_wrench as random_wrench
