"""A plant and a task as a Gymnasium environment, for agents from outside."""

from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium.wrappers import TransformReward

from sym2real.plants.model_plant import ModelPlant
from sym2real.plants.mujoco_plant import MujocoPlant
from sym2real.tasks import Task
from sym2real.tasks.cost import running_cost
from sym2real.trajectory import Array

__all__ = ["TaskEnvironment", "TransformReward"]


class TaskEnvironment(gymnasium.Env[Array, Array]):  # type: ignore[misc]
    """Observation: the measured state. Action: the robot's. Reward: minus the task's running cost.

    An episode terminates on a crash and is truncated after the task's duration.

    Args:
        plant: a plant of a robot.
        task: gives the start, the reference and the cost.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 — Gymnasium's own declaration

    def __init__(self, plant: MujocoPlant | ModelPlant, task: Task) -> None:
        self.plant, self.task = plant, task
        self.steps = round(task.duration / plant.dt)
        self._cost = running_cost(task, plant.layouts)
        size = plant.layouts.state.size
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (size,), np.float64)
        self.action_space = gymnasium.spaces.Box(plant.robot.low, plant.robot.high, dtype=np.float64)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Start an episode; the observation is the measured state ``# (state,)``."""
        super().reset(seed=seed)
        self._step = 0
        return self.plant.reset(self.task.start(self.np_random), seed), {}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """One control period; the episode is over when the plant crashed, and cut off after the task's duration.

        What comes back names the action as sent: ``info["sent"]``.
        """
        state = self.plant.step(action)
        self._step += 1
        time, sent = torch.tensor(self._step * self.plant.dt, dtype=torch.float64), self.plant.sent
        cost = float(self._cost(torch.as_tensor(state), torch.as_tensor(sent), self.task.reference(time)))
        return state, -cost, self.plant.crashed, self._step >= self.steps, {"sent": sent}
