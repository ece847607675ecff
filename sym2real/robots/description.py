"""A robot in a simulator: its description file, and the way between states and MuJoCo's coordinates."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from sym2real.trajectory import Array

if TYPE_CHECKING:
    import mujoco

# What ends an episode.
Crash = Literal["contact", "rolled over", "joint range", "never"]


def is_text(mjcf: str) -> bool:
    """Whether an MJCF is given as itself, not by the name of its file."""
    return mjcf.lstrip().startswith("<")


def spec_of(mjcf: str) -> mujoco.MjSpec:
    """An MJCF, a text or the path of a file, to be edited or compiled; includes are looked for beside a file.

    Joints and actuators have names that can be columns.

    Raises:
        ValueError: when MuJoCo cannot read it.
    """
    import mujoco  # noqa: PLC0415 — a simulator stays out of light imports

    from sym2real.robots.naming import give_names  # noqa: PLC0415 — as above

    spec = mujoco.MjSpec.from_string(mjcf) if is_text(mjcf) else mujoco.MjSpec.from_file(mjcf)
    give_names(spec)
    return spec


def yaw_of(qpos: Array, first: int = 3) -> Array:
    """Heading in rad ``# (...)`` of the quaternion that begins at a place of qpos ``# (..., nq)``."""
    w, x, y, z = (qpos[..., first + part] for part in range(4))
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@dataclass(frozen=True, eq=False)
class Coordinates:
    """States in MuJoCo's coordinates, and back.

    Args:
        places: of every state column in qpos and qvel, one after the other ``# (state,)``.
        standing: qpos and qvel of what the state does not say ``# (nq + nv,)``.
        positions: length of qpos.
    """

    places: list[int]
    standing: Array
    positions: int

    def to_state(self, qpos: Array, qvel: Array) -> Array:
        """States ``# (..., state)``."""
        velocities = len(self.standing) - self.positions
        whole = np.concatenate([qpos[..., : self.positions], qvel[..., :velocities]], axis=-1)
        return whole[..., self.places]

    def to_coordinates(self, state: Array) -> tuple[Array, Array]:
        """qpos ``# (nq,)`` and qvel ``# (nv,)``."""
        whole = self.standing.copy()
        whole[self.places] = state
        return whole[: self.positions], whole[self.positions :]


def unchanged(actions: Array) -> Array:
    """Actuator controls that are the actions themselves ``# (..., action)``."""
    return actions


@dataclass(frozen=True, eq=False)
class Description:
    """What a simulator needs of a robot.

    Args:
        mjcf: name of a file in this package, path of any MJCF, or its text.
        physics_dt: period of the simulator in s.
        start: state after a reset without one ``# (state,)``.
        rest: the action that holds the robot where it is ``# (action,)``.
        to_state: MuJoCo's qpos ``# (..., nq)`` and qvel ``# (..., nv)`` → states ``# (..., state)``; what a change has
            appended to them does not matter.
        to_coordinates: state ``# (state,)`` → qpos ``# (nq,)`` and qvel ``# (nv,)``.
        to_control: actions ``# (..., action)`` → actuator controls of the description ``# (..., nu)``.
        body: name of the free body that a wrench acts on; "" for a robot without one.
        crash: what ends an episode: touching anything, rolling over by 60°, leaving a joint's range, or nothing.
        coarse_substeps: physics steps per control period that are enough for planning; 0 for those of the simulator.
        quantities: names that its nominal equations derive, for effects.
        actuators: those that are commanded, each with its column, of a robot that its MJCF and these alone describe.
    """

    mjcf: str
    physics_dt: float
    start: Array
    rest: Array
    to_state: Callable[[Array, Array], Array]
    to_coordinates: Callable[[Array], tuple[Array, Array]]
    to_control: Callable[[Array], Array] = unchanged
    body: str = ""
    crash: Crash = "never"
    coarse_substeps: int = 0
    quantities: tuple[str, ...] = ()
    actuators: Mapping[str, str] = field(default_factory=dict)

    def spec(self) -> mujoco.MjSpec:
        """The description, to be edited or compiled; meshes and includes are looked for beside a file.

        Actuators bear the names of their columns, by which effects look for them.
        """
        given = is_text(self.mjcf) or Path(self.mjcf).is_absolute()
        inside = resources.files("sym2real.robots")
        spec = spec_of(self.mjcf if given else inside.joinpath(self.mjcf).read_text(encoding="utf-8"))
        for actuator in spec.actuators:
            actuator.name = self.actuators.get(actuator.name, actuator.name)
        return spec
