"""Plants: what a controller acts on, in a simulator or in a model; and episodes on them."""

from sym2real.plants.episode import run_episode
from sym2real.plants.mujoco_plant import MujocoPlant

__all__ = ["MujocoPlant", "run_episode"]
