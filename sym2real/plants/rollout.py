"""Many short simulations from given physics states at once, through ``mujoco.rollout``."""

from __future__ import annotations

import copy

import mujoco
import numpy as np
from mujoco import rollout

from sym2real.errors import ModelError, ShapeError
from sym2real.plants.mujoco_plant import FULL_STATE, MujocoPlant
from sym2real.trajectory import Array


def rollout_mujoco(
    plant: MujocoPlant, full_states: Array, actions: Array, *, substeps: int | None = None, threads: int = 1
) -> Array:
    """States after each action ``# (N, H, state)``.

    Args:
        plant: whose physics is simulated; its own state is left alone.
        full_states: physics states as ``plant.full_state`` gives them ``# (N, full)`` or one for all ``# (full,)``.
        actions: ``# (N, H, action)``.
        substeps: physics steps per control period; None for the plant's own. For a free body under RK4 two
            are within 0.1 mm of ten over 0.8 s of wild commands, and five times as fast.
        threads: worker threads, kept between calls.

    Raises:
        ModelError: when the plant has force callbacks, filters or a wrench, which a rollout cannot apply.
        ShapeError: when shapes do not fit.
    """
    _refuse_callbacks(plant)
    model, robot = plant.mj_model, plant.robot
    starts = np.atleast_2d(full_states)
    size = mujoco.mj_stateSize(model, FULL_STATE)
    columns = robot.layouts.action.size
    fits = starts.shape[1] == size and len(starts) in (1, len(actions)) and actions.shape[2:] == (columns,)
    if not fits or not len(actions):
        raise ShapeError(
            f"expected full states (N, {size}) and actions (N, H, {columns}) with N > 0, "
            f"found {full_states.shape} and {actions.shape}"
        )
    if threads < 1 or (substeps is not None and substeps < 1):
        raise ShapeError(f"expected at least one thread and physics step, found {threads} and {substeps}")
    if substeps is None:
        substeps = robot.substeps
    else:
        model = copy.copy(model)
        model.opt.timestep = robot.dt / substeps
    controls = np.repeat(robot.to_control(actions), substeps, axis=1)
    workers = [mujoco.MjData(model) for _ in range(threads)]
    states, _ = rollout.rollout(model, workers, starts, controls, persistent_pool=True)
    after = states[:, substeps - 1 :: substeps]
    return robot.to_state(after[..., 1 : 1 + model.nq], after[..., 1 + model.nq : 1 + model.nq + model.nv])


def _refuse_callbacks(plant: MujocoPlant) -> None:
    unfit = [change.name for change in plant.changes if change.force or change.command or change.measure]
    if plant.inputs.any():
        unfit.append("a held wrench")
    if unfit:
        raise ModelError(f"mujoco.rollout cannot apply {', '.join(unfit)}: step the plant instead")
