"""A robot from any MJCF: columns, limits and a recipe by what the file says."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from sym2real.errors import ModelError, UnknownNameError
from sym2real.layout import Layout, Layouts
from sym2real.robots import mjcf_columns as columns, planar
from sym2real.robots.covered import against_rolling, against_tree
from sym2real.robots.description import Coordinates, Crash, Description, is_text
from sym2real.robots.driven import braking, strengths
from sym2real.robots.flying import Rotorcraft, against_flying, flying
from sym2real.robots.recipe import Recipe
from sym2real.robots.robot import GRAVITY, Limits, MPPISettings, Robot
from sym2real.trajectory import Array
from sym2real.vocabulary import DRILLING, HEADING, MOTOR_TORQUES, RATE, THRUST_COLUMN, push_column, rate_column

if TYPE_CHECKING:
    from sym2real.symbolic import Equations

PERIOD = 0.02  # s, about
# Accelerations (m/s², rad/s²) that forces reach along a joint; a wrench's share of the weight, and its lever in m.
REACHED_ACCELERATION, WRENCH_SHARE, LEVER = 3.0, 0.3, 0.02
# Parts of the commands' range: MPPI's noise, and dither.
NOISE, DITHER = 0.15, 0.02
HORIZON = 40  # control periods
WEIGHTS = {"position": 1.0, "orientation": 0.4, "joint displacement": 1.0, "joint angle": 1.0}
WEIGHTS |= dict.fromkeys(("velocity", "rate", "joint speed", "joint rate"), 0.05)


def from_mjcf(
    path: str | Path,
    *,
    name: str = "",
    actions: Mapping[str, str] | Sequence[str] | None = None,
    state: Sequence[str] | None = None,
    dt: float | None = None,
    recipe: Recipe | None = None,
    mppi: MPPISettings | None = None,
    numbers: Mapping[str, float] | None = None,
    rigid_body: Callable[[], Equations] | None = None,
    title: str = "",
) -> Robot:
    """A robot from its MJCF alone.

    It starts at the file's first keyframe, whose controls are its action at rest. A free joint makes touching
    anything a crash; of other robots leaving a joint's range is one. Its equations carry the description with them, so
    that a folder of them is enough to simulate it.

    Args:
        path: of the file, or its text; meshes and includes are looked for beside a file.
        name: key in the registry; by default the file's stem.
        actions: actuators that are commanded, as ``{actuator: column}`` where columns are to be called otherwise; all
            by default. The column of one that the file calls as a joint, J, is ``J_cmd``.
        state: columns of the state (:mod:`sym2real.robots.mjcf_columns`); all by default. With ``sin_yaw`` the robot
            is one of the plane (:mod:`sym2real.robots.planar`).
        dt: control period in s, simulated in whole steps no longer than the file's; by default near 20 ms.
        recipe: how a model is learned; by default on the task ``regulate`` from its start, and its base is the
            first-principles equations where there are any.
        mppi: sampling; by default a horizon of 40 periods.
        numbers: further ones, SI units.
        rigid_body: makes the first-principles equations; by default those of
            :func:`sym2real.robots.multibody.multibody`, for robots of hinges and slides, of
            :func:`sym2real.robots.rolling.rolling`, for robots of the plane on wheels of one axle, or of
            :func:`sym2real.robots.flying.flying`, for a free body with rotors.
        title: what people call it.

    Raises:
        ModelError: for a file that MuJoCo does not open, or a joint, actuator or period that is not covered.
        UnknownNameError: for an actuator or column that the file does not have.
    """
    file = str(path) if is_text(str(path)) else str(Path(path).resolve())
    model, data = columns.opened(file)
    known = columns.state_columns(model)
    wanted = _named(columns.names_of(model, "actuator") if actions is None else actions, known)
    if not wanted:
        raise ModelError(
            "expected actuators, the robot's actions, found none: give the file an <actuator> section"
            " (a URDF has none; mujoco.mj_saveLastXML writes it as an MJCF)"
        )
    if planar.asked(state):
        motion = _in_a_plane(model, data, wanted)
    elif columns.FREE in model.jnt_type:
        motion = _in_space(model, data, wanted, known, _state(known, state))
    else:
        motion = _of_joints(model, data, wanted, known, _state(known, state))
    layouts, period = motion.layouts, _period(model, dt)
    actuators = [model.actuator(actuator_name).id for actuator_name in wanted]
    low, high = columns.ranges_of(model, actuators)
    moving = model.body_weldid != 0  # a table in the scene is none of the robot's mass
    own = {"mass": float(model.body_mass[moving].sum())} | _joint_numbers(model, columns.inertias(model, motion.data))
    own |= _ranges(layouts.action, low, high) | strengths(model, actuators, np.maximum(-low, high)) | motion.numbers
    return Robot(
        name=name or Path(file).stem,
        layouts=layouts,
        dt=period,
        limits=Limits(low, high, push=_input_limits(layouts.inputs, own)),
        description=Description(
            mjcf=file,
            physics_dt=float(model.opt.timestep),
            start=motion.coordinates.to_state(data.qpos.copy(), np.zeros(model.nv)),
            rest=np.clip(motion.resting, low, high),
            to_state=motion.coordinates.to_state,
            to_coordinates=motion.coordinates.to_coordinates,
            to_control=partial(columns.controls_of, actuators, model.nu),
            body=_free_body(model),
            crash=motion.crash,
            quantities=columns.quantities_of(model) + _derived_rates(model, layouts.state) + motion.quantities,
            actuators=wanted,
        ),
        recipe=recipe
        or default_recipe(model, layouts.state, wanted, high - low, rigid_body is not None or not motion.uncovered),
        numbers=own | dict(numbers or {}),
        mppi=mppi or MPPISettings(horizon=HORIZON * period, noise=tuple(NOISE * (high - low))),
        rigid_body=rigid_body or cache(partial(_equations, file, layouts, wanted, period)),
        title=title,
    ).at_period(period)


@dataclass(frozen=True, eq=False)
class _Motion:
    """What the way in which a robot moves decides: in a plane on wheels, free in space, or by its joints alone.

    Args:
        data: where its masses are taken.
        layouts, coordinates: its columns, and states in MuJoCo's coordinates.
        crash: what counts as one.
        uncovered: why it has no first-principles equations; empty where it has.
        resting: its action at rest ``# (action,)``.
        numbers, quantities: of its own way to move.
    """

    data: mujoco.MjData
    layouts: Layouts
    coordinates: Coordinates | planar.PlanarCoordinates
    crash: Crash
    uncovered: Sequence[str]
    resting: Array
    numbers: dict[str, float] = field(default_factory=dict)
    quantities: tuple[str, ...] = ()


def _in_a_plane(model: mujoco.MjModel, data: mujoco.MjData, actions: Mapping[str, str]) -> _Motion:
    layouts = columns.layouts_of(model, Layout.of(planar.STATE), actions)
    facing = planar.facing_x(model, data)
    wheels = planar.Wheels.of(model, facing)
    uncovered = against_rolling(model, wheels)
    return _Motion(
        facing,
        replace(layouts, inputs=planar.inputs_of(model)),
        planar.PlanarCoordinates(wheels, facing.qpos.copy(), model.nv),
        "rolled over",
        uncovered,
        _controls(model, facing, actions),
        wheels.numbers(model, facing, actions),
        () if uncovered else (DRILLING,),
    )


def _in_space(
    model: mujoco.MjModel, data: mujoco.MjData, actions: Mapping[str, str], known: Mapping[str, Any], state: Layout
) -> _Motion:
    motion = _of_joints(model, data, actions, known, state)
    motion = replace(motion, crash="contact", uncovered=against_flying(model, data, actions))
    if motion.uncovered:
        return motion
    craft = Rotorcraft.of(model, data, [model.actuator(name).id for name in actions])
    resting = motion.resting if model.nkey else craft.hovering
    given = (THRUST_COLUMN, *MOTOR_TORQUES)
    quantities = tuple(name for name in given if name not in actions.values())
    return replace(motion, resting=resting, numbers=craft.numbers, quantities=quantities)


def _of_joints(
    model: mujoco.MjModel, data: mujoco.MjData, actions: Mapping[str, str], known: Mapping[str, Any], state: Layout
) -> _Motion:
    layouts = columns.layouts_of(model, state, actions)
    places = [known[column][1] for column in layouts.state]
    standing = np.concatenate([data.qpos, np.zeros(model.nv)])
    return _Motion(
        data,
        layouts,
        Coordinates(places, standing, model.nq),
        "joint range" if model.jnt_limited.any() else "never",
        against_tree(model, layouts.state),
        _controls(model, data, actions),
    )


def _controls(model: mujoco.MjModel, data: mujoco.MjData, actions: Mapping[str, str]) -> Array:
    """Of the first keyframe ``# (action,)``."""
    return np.asarray(data.ctrl[[model.actuator(name).id for name in actions]])


def default_recipe(
    model: mujoco.MjModel, state: Layout, actions: Mapping[str, str], span: Array, described: bool
) -> Recipe:
    """Regulation about the start; every actuator must show in the rate of the joint that it moves.

    Of a robot in a plane paths, and its turning rate. ``span`` is that of the commands ``# (action,)``; a robot that is
    ``described`` has first-principles equations, which are its base.
    """
    joints = {column: columns.driven_joint(model, model.actuator(name).id) for name, column in actions.items()}
    moved = [(rate_column(joint), column) for column, joint in joints.items() if joint]
    on_paths = HEADING.columns[0] in state
    if on_paths:
        moved = [(RATE.columns[2], column) for column in joints]
    return Recipe(
        tasks=(("circle", {}), ("lemniscate", {})) if on_paths else (("regulate", {}),),
        base="nominal" if described else "episodes",
        dither=tuple(DITHER * span),
        dependencies=tuple((rate, column) for rate, column in moved if rate in state),
        angles=tuple(column for column in state if state.units[column] == "rad"),
        cost_weights=WEIGHTS,
    )


def _named(actions: Mapping[str, str] | Sequence[str], known: Collection[str]) -> dict[str, str]:
    """Column of every actuator; a file may call one as the joint that it moves, whose column is known by that name."""
    if isinstance(actions, Mapping):
        return dict(actions)
    return {actuator: f"{actuator}_cmd" if actuator in known else actuator for actuator in actions}


def _state(known: Mapping[str, Any], wanted: Sequence[str] | None) -> Layout:
    for column in wanted or ():
        if column not in known:
            raise UnknownNameError("state column", column, known)
    chosen = {column: field for column, (field, _) in known.items() if wanted is None or column in wanted}
    speeds = ("velocity", "rate", "joint speed", "joint rate")  # behind where the robot is
    return columns.layout_of(sorted(chosen.items(), key=lambda entry: entry[1].name in speeds))


def _period(model: mujoco.MjModel, dt: float | None) -> float:
    step = float(model.opt.timestep)
    period = step * max(1, round(PERIOD / step)) if dt is None else dt
    if not 0.0 < period < math.inf:
        raise ModelError(f"expected a control period of more than 0 s, found {period!r}")
    return period


def _joint_numbers(model: mujoco.MjModel, masses: Array) -> dict[str, float]:
    """Of each joint what a force moves while all others are held, and while none is, what brakes it by the file, its
    dry friction and stiffness, and where its spring rests, if it has one.

    Args:
        masses: ``# (nv, nv)``.
    """
    single = [joint for joint in range(model.njnt) if model.jnt_type[joint] != columns.FREE]
    places = {model.joint(joint).name: model.jnt_dofadr[joint] for joint in single}
    held, free = masses.diagonal(), 1.0 / np.linalg.pinv(masses, hermitian=True).diagonal()
    numbers = {f"{name}_inertia": float(held[place]) for name, place in places.items()}
    numbers |= {f"{name}_alone": float(free[place]) for name, place in places.items()}
    brakes = braking(model)
    numbers |= {f"{name}_braking": float(brakes[place]) for name, place in places.items()}
    numbers |= {f"{name}_friction": float(model.dof_frictionloss[place]) for name, place in places.items()}
    numbers |= {f"{model.joint(joint).name}_stiffness": float(model.jnt_stiffness[joint]) for joint in single}
    sprung = (model.joint(joint) for joint in single if model.jnt_stiffness[joint])
    return numbers | {f"{joint.name}_rest": float(model.qpos_spring[joint.qposadr[0]]) for joint in sprung}


def _ranges(action: Layout, low: Array, high: Array) -> dict[str, float]:
    return {f"{column}_range": float(span) for column, span in zip(action, high - low, strict=True)}


def _input_limits(inputs: Layout, numbers: Mapping[str, float]) -> dict[str, float]:
    weight = WRENCH_SHARE * GRAVITY * numbers["mass"]
    wrench = {column: weight if column.startswith("f") else LEVER * weight for column in inputs}
    along = {push_column(key.removesuffix("_inertia")): REACHED_ACCELERATION * value for key, value in numbers.items()}
    return {column: along.get(column, wrench[column]) for column in inputs}


def _free_body(model: mujoco.MjModel) -> str:
    free = np.flatnonzero(model.jnt_type == columns.FREE)
    return str(model.body(model.jnt_bodyid[free[0]]).name) if len(free) else ""


def _derived_rates(model: mujoco.MjModel, state: Layout) -> tuple[str, ...]:
    """Rates of joints that the state does not hold, which equations may derive."""
    names = columns.names_of(model, "joint")
    single = (name for name, kind in zip(names, model.jnt_type, strict=True) if kind != columns.FREE)
    return tuple(rate_column(name) for name in single if rate_column(name) not in state)


def _equations(file: str, layouts: Layouts, actions: Mapping[str, str], dt: float) -> Equations:
    from sym2real.robots.left_out import left_out_of  # noqa: PLC0415 — SymPy stays out of light imports
    from sym2real.robots.multibody import multibody  # noqa: PLC0415 — as above
    from sym2real.robots.rolling import rolling  # noqa: PLC0415

    model, data = columns.opened(file)
    if planar.asked(layouts.state):
        return rolling(model, planar.facing_x(model, data), layouts, actions, dt)
    if columns.FREE in model.jnt_type:
        return flying(model, data, actions, dt)
    equations = multibody(model, layouts, actions, dt)
    return replace(equations, notes=(*equations.notes, *left_out_of(model)))
