"""Many short simulations from given physics states at once, through ``mujoco.rollout``."""

import copy

import mujoco
import numpy as np
from mujoco import rollout

from sym2real.errors import ModelError, ShapeError
from sym2real.plants.mujoco_plant import FULL_STATE, MujocoPlant
from sym2real.trajectory import Array


def rollout_mujoco(
    plant: MujocoPlant,
    full_states: Array,
    actions: Array,
    *,
    forces: Array | None = None,
    substeps: int | None = None,
) -> Array:
    """True states after each action ``# (N, H, state)``, whatever the plant's sensors make of them.

    Args:
        plant: whose physics is simulated; its own state is left alone.
        full_states: physics states as ``plant.full_state`` gives them ``# (N, full)`` or one for all ``# (full,)``.
        actions: ``# (N, H, action)``.
        forces: held on the bodies all along, as ``xfrc_applied`` has them ``# (bodies, 6)``, for a plant with force
            callbacks or a wrench (:attr:`MujocoPlant.forces` are those of now).
        substeps: physics steps per control period; None for the plant's own. For a free body under RK4 two
            are within 0.1 mm of ten over 0.8 s of wild commands, and five times as fast.

    Raises:
        ModelError: when the plant has command filters, a force acts along a joint, or on it and none are given: a
            rollout has neither.
        ShapeError: when shapes do not fit.
    """
    _refuse_callbacks(plant, forces)
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
    if substeps is not None and substeps < 1:
        raise ShapeError(f"expected at least one physics step, found {substeps}")
    if substeps is None:
        substeps = robot.substeps
    else:
        model = copy.copy(model)
        model.opt.timestep = robot.dt / substeps
    controls = np.repeat(robot.description.to_control(actions), substeps, axis=1)
    spec = mujoco.mjtState.mjSTATE_CTRL
    if forces is not None:
        spec |= mujoco.mjtState.mjSTATE_XFRC_APPLIED
        held = np.broadcast_to(np.ravel(forces), (*controls.shape[:2], forces.size))
        controls = np.concatenate([controls, held], axis=-1)
    states, _ = rollout.rollout(model, [mujoco.MjData(model)], starts, controls, control_spec=int(spec))
    after = states[:, substeps - 1 :: substeps]
    return robot.description.to_state(after[..., 1 : 1 + model.nq], after[..., 1 + model.nq : 1 + model.nq + model.nv])


def _refuse_callbacks(plant: MujocoPlant, forces: Array | None) -> None:
    free = forces is None
    unfit = [change.name for change in plant.changes if change.command or (change.force and free)]
    if (free or plant.mj_data.qfrc_applied.any()) and plant.inputs.any():
        unfit.append("a held wrench")
    if unfit:
        raise ModelError(f"mujoco.rollout cannot apply {', '.join(unfit)}: step the plant instead")
