"""A robot in MuJoCo: noise-free and without delay, unless a list of changes says otherwise."""

import math
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from sym2real.errors import ModelError, ShapeError
from sym2real.layout import Layouts
from sym2real.protocols import Change, Filter, MovingFilter
from sym2real.robots import Robot
from sym2real.trajectory import Array
from sym2real.vocabulary import WRENCH, push_column

FULL_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
ROLL_OVER = np.deg2rad(60.0)
WITHOUT_REST = (int(mujoco.mjtDyn.mjDYN_NONE), int(mujoco.mjtDyn.mjDYN_INTEGRATOR))
OUT_OF_MEASURE = [int(getattr(mujoco.mjtWarning, f"mjWARN_BAD{name}")) for name in ("QPOS", "QVEL", "QACC")]
# MuJoCo prints its warnings and leaves MUJOCO_LOG.TXT where a user works; those that matter are errors here.
mujoco.set_mju_user_warning(lambda _: None)


def edited(robot: Robot, changes: Sequence[Change] = (), description: str | None = None) -> mujoco.MjSpec:
    """The robot's description, or another one in its place, edited by the changes.

    Inertial frames must be edited here: MuJoCo compiles a centred body to a form whose frame cannot move afterwards.
    """
    spec = robot.description.spec() if description is None else mujoco.MjSpec.from_string(description)
    spec.option.timestep = robot.description.physics_dt
    for change in changes:
        if change.edit is not None:
            change.edit(spec)
    return spec


def compile_robot(robot: Robot, changes: Sequence[Change] = (), description: str | None = None) -> mujoco.MjModel:
    """The compiled model of :func:`edited`."""
    return edited(robot, changes, description).compile()


class MujocoPlant:
    """A :class:`~sym2real.protocols.Plant` that simulates a robot.

    Commands outside the robot's limits are clipped, as on the hardware; :attr:`sent` says what was sent.

    Args:
        robot: what to simulate.
        changes: differences from the plain robot, applied in this order.
        description: MJCF in place of the robot's own, with its body, joints and actuators.

    Raises:
        ShapeError: for the description of another robot.

    Attributes:
        mj_model, mj_data: MuJoCo's own objects.
        changes, description: as given.
        time: since the reset in s.

    Examples:
        >>> plant = MujocoPlant(ROBOTS["crazyflie"])
        >>> plant.reset(seed=0).shape, plant.dt
        ((13,), 0.02)
    """

    def __init__(
        self,
        robot: Robot,
        changes: Sequence[Change] = (),
        description: str | None = None,
    ) -> None:
        self.robot = robot
        self.changes, self.description = tuple(changes), description
        self.mj_model = compile_robot(robot, self.changes, description)
        if description is not None:
            _require_same_robot(robot, self.mj_model)
        self.mj_data = mujoco.MjData(self.mj_model)
        self._body = mujoco.mj_name2id(self.mj_model, mujoco.mjtObj.mjOBJ_BODY, robot.description.body)
        self._wrench_places = [WRENCH.index(column) if column in WRENCH else -1 for column in robot.layouts.inputs]
        self._joint_places = _joint_inputs(robot, self.mj_model)
        self._limited = np.flatnonzero(self.mj_model.jnt_limited)
        self._forces = [change.force for change in self.changes if change.force is not None]
        self.reset()

    @property
    def layouts(self) -> Layouts:
        """The robot's columns."""
        return self.robot.layouts

    @property
    def dt(self) -> float:
        """Control period in s."""
        return self.robot.dt

    @property
    def time(self) -> float:
        """Since the reset, s."""
        return float(self.mj_data.time)

    @property
    def inputs(self) -> Array:
        """What acts now: a wrench, force in world and torque in body axes, or forces along joints ``# (inputs,)``."""
        return self._inputs.copy()

    @property
    def crashed(self) -> bool:
        """Whether the robot has crashed since the reset, as its description says (touched something, rolled over …)."""
        return bool(self.ended_by)

    @property
    def sent(self) -> Array:
        """The last action within the robot's limits, before any command filter ``# (action,)``."""
        return self._sent.copy()

    @property
    def true_state(self) -> Array:
        """State before any measurement filter ``# (state,)``."""
        return self.robot.read_state(self.mj_data)

    @property
    def full_state(self) -> Array:
        """The simulator's whole physics state (mjSTATE_FULLPHYSICS), without the memory of filters ``# (full,)``."""
        state = np.empty(mujoco.mj_stateSize(self.mj_model, FULL_STATE))
        mujoco.mj_getState(self.mj_model, self.mj_data, state, FULL_STATE)
        return state

    @full_state.setter
    def full_state(self, state: Array) -> None:
        mujoco.mj_setState(self.mj_model, self.mj_data, state, FULL_STATE)
        mujoco.mj_forward(self.mj_model, self.mj_data)

    @property
    def forces(self) -> Array:
        """What changes and wrench apply now, as ``xfrc_applied`` has it ``# (bodies, 6)``."""
        self._apply_forces()
        applied: Array = self.mj_data.xfrc_applied.copy()
        return applied

    def push(self, wrench: ArrayLike) -> None:
        """Hold a wrench until the next call or reset.

        Args:
            wrench: columns of ``layouts.inputs``: force at the centre of mass in N along world axes, torque in N m
                about body axes; or forces in N and torques in N m along joints ``# (inputs,)``.

        Raises:
            ShapeError: for another number of columns.
        """
        values = np.asarray(wrench, dtype=np.float64)
        if values.shape != (self.layouts.inputs.size,):
            raise ShapeError(f"a wrench has columns {self.layouts.inputs.columns}, found shape {values.shape}")
        self._inputs, self._wrench = values, np.zeros(6)
        for place, value in zip(self._wrench_places, values, strict=True):
            if place >= 0:
                self._wrench[place] = value
        self._has_wrench = bool(self._wrench.any())
        self._pushes = np.zeros(self.mj_model.nv)
        for place, dof in self._joint_places.items():
            self._pushes[dof] = values[place]
        self.mj_data.qfrc_applied[:] = self._pushes

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Start an episode at ``state``, or at the robot's start; nothing is random, so the seed has no effect.

        Raises:
            ShapeError: for another number of columns, or a state that is not finite.
        """
        start = self.robot.start if state is None else np.asarray(state, dtype=np.float64)
        if not np.isfinite(start).all():
            raise ShapeError(f"expected a finite state, found {start.tolist()}")
        mujoco.mj_resetData(self.mj_model, self.mj_data)
        self.robot.write_state(self.mj_data, start)
        mujoco.mj_forward(self.mj_model, self.mj_data)
        self._command_filters = [change.command() for change in self.changes if change.command is not None]
        self._moving = [apply for apply in self._command_filters if isinstance(apply, MovingFilter)]
        self._measure_filters = [change.measure() for change in self.changes if change.measure is not None]
        self.ended_by, self._fresh = "", True  # what the robot crashed by, in words
        self._sent = np.full(self.layouts.action.size, np.nan)
        self.push(np.zeros(self.layouts.inputs.size))
        return self._measured()

    def step(self, action: ArrayLike) -> Array:
        """Measured state ``# (state,)`` after one action ``# (action,)``, held for a control period.

        Raises:
            ShapeError: for another number of columns, or an action that is not finite, which MuJoCo takes for zero.
            ModelError: where forces or masses are such that the simulation leaves all measure.
        """
        asked = np.asarray(action, dtype=np.float64)
        if asked.shape != (self.layouts.action.size,):
            raise ShapeError(f"an action has columns {self.layouts.action.columns}, found shape {asked.shape}")
        if not np.isfinite(asked).all():
            raise ShapeError(f"expected a finite action, found {asked.tolist()}")
        self._sent = np.clip(asked, self.robot.low, self.robot.high)
        control = self.robot.description.to_control(_filtered(self._command_filters, self._sent))
        self.mj_data.ctrl[: len(control)] = control  # changes may append actuators of their own
        if self._fresh:
            self._settle(control)
        for _ in range(self.robot.substeps):
            for moving in self._moving:
                moving.move(self.mj_model, self.mj_data)
            self._apply_forces()
            mujoco.mj_step(self.mj_model, self.mj_data)
            self.ended_by = self.ended_by or self._crash()
        self._require_finite()
        if not (self.ended_by or np.isfinite(self.mj_data.qpos).all()):
            self.ended_by = "its state is no number"
        return self._measured()

    def _settle(self, control: Array) -> None:
        """Actuators with memory, and delayed ones, start as if the first command had been held for ever.

        An integrator starts from zero: it has no value that a held command would bring it to.
        """
        self._fresh, model = False, self.mj_model
        for actuator, value in enumerate(control):
            if model.actuator_dyntype[actuator] not in WITHOUT_REST:
                self.mj_data.act[model.actuator_actadr[actuator]] = value
            samples = model.actuator_history[actuator, 0]
            if samples:
                times = self.time + model.opt.timestep * np.arange(-samples, 0.0)
                mujoco.mj_initCtrlHistory(model, self.mj_data, actuator, times, np.full((samples, 1), value))

    def _measured(self) -> Array:
        return _filtered(self._measure_filters, self.true_state)

    def _apply_forces(self) -> None:
        self.mj_data.xfrc_applied[:], self.mj_data.qfrc_applied[:] = 0.0, self._pushes
        if self._forces:
            # A physics step leaves positions and velocities of its beginning behind; the callbacks read the present.
            mujoco.mj_forward(self.mj_model, self.mj_data)
        if self._has_wrench:
            outer, torque = self._wrench[:3], np.empty(3)
            mujoco.mju_rotVecQuat(torque, self._wrench[3:], self.mj_data.qpos[3:7])
            # MuJoCo's force acts at the centre of one body, a wrench at that of the robot.
            lever = self.mj_data.subtree_com[self._body] - self.mj_data.xipos[self._body]
            self.mj_data.xfrc_applied[self._body] = [*outer, *(torque + np.cross(lever, outer))]
        for force in self._forces:
            force(self.mj_model, self.mj_data)

    def _require_finite(self) -> None:
        """Refuse what MuJoCo has set back to the model's start, which would be read as a flight that goes on.

        It counts how often it did.
        """
        if self.mj_data.warning.number[OUT_OF_MEASURE].any():
            names = ", ".join(change.name for change in self.changes) or "the plain robot"
            raise ModelError(
                f"{names}: expected a {self.robot.name} that can be simulated, found accelerations beyond all measure "
                f'(a shorter timestep in the MJCF\'s option, or integrator="implicitfast", follows stiffer servos)'
            )

    def _crash(self) -> str:
        """What has just become of the robot that its description takes for a crash, in words; "" for nothing."""
        crash = self.robot.description.crash
        if crash == "contact":
            return "it touched something" if self.mj_data.ncon else ""
        if crash == "joint range":
            places = self.mj_data.qpos[self.mj_model.jnt_qposadr[self._limited]]
            low, high = self.mj_model.jnt_range[self._limited].T
            ended = self._limited[(places <= low) | (places >= high)]
            return " and ".join(f"{self.mj_model.joint(joint).name} at the end of its range" for joint in ended)
        if crash == "never":
            return ""
        x, y = self.mj_data.qpos[4:6]
        return "it rolled over" if 2.0 * math.asin(min(1.0, math.hypot(x, y))) > ROLL_OVER else ""


def _require_same_robot(robot: Robot, other: mujoco.MjModel) -> None:
    """Body, coordinates and actuators as the robot reads and writes them; changes may have appended actuators."""
    plain = compile_robot(robot)
    body = robot.description.body
    named = not body or mujoco.mj_name2id(other, mujoco.mjtObj.mjOBJ_BODY, body) >= 0
    if not named or not np.array_equal(plain.jnt_type, other.jnt_type) or other.nu < plain.nu:
        raise ShapeError(
            f"another robot: {'a' if named else 'no'} body named {body}, {other.njnt} joints and {other.nu} actuators "
            f"where a {robot.name} has {plain.njnt} and {plain.nu}"
        )


def _joint_inputs(robot: Robot, model: mujoco.MjModel) -> dict[int, int]:
    """Degree of freedom of every input that is a force along a joint."""
    names = {push_column(model.joint(index).name): int(model.jnt_dofadr[index]) for index in range(model.njnt)}
    return {place: names[column] for place, column in enumerate(robot.layouts.inputs) if column in names}


def _filtered(filters: Sequence[Filter], values: Array) -> Array:
    for apply in filters:
        values = apply(values)
    return values
