"""What a robot is to this package: columns, limits, description file, and the way between states and coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np

from sym2real.errors import ShapeError
from sym2real.layout import Layouts
from sym2real.trajectory import Array

if TYPE_CHECKING:
    from sym2real.symbolic import Equations

GRAVITY = 9.81  # m/s²
MOST_SAMPLES = 2**20  # of MPPI: states of more rollouts than a million take gigabytes


@dataclass(frozen=True)
class MPPISettings:
    """How MPPI samples for a robot.

    Args:
        samples: rollouts per action.
        horizon: length of a rollout in s.
        temperature: of the softmax over costs, in units of cost.
        noise: standard deviation of the sampled commands, in each action's unit.
        knots: number of spline knots over the horizon; 0 samples every step on its own.
        correlation: time constant of the noise in s where there are no knots; 0 is white.

    Raises:
        ShapeError: for a number of samples below one or beyond :data:`MOST_SAMPLES`, or a number that cannot be such a
            length, temperature or time.
    """

    samples: int = 1024
    horizon: float = 0.8
    temperature: float = 0.05
    noise: tuple[float, ...] = ()
    knots: int = 0
    correlation: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.samples, Integral) or not 1 <= self.samples <= MOST_SAMPLES:
            raise ShapeError(f"MPPI: expected at least 1 sample and at most {MOST_SAMPLES}, found {self.samples!r}")
        for name in ("horizon", "temperature"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise ShapeError(f"MPPI: expected a {name} > 0, found {getattr(self, name)!r}")
        if not 0.0 <= self.correlation < math.inf:
            raise ShapeError(f"MPPI: expected a correlation >= 0 s, found {self.correlation!r}")


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot and all the numbers that its plants, tasks and controllers need.

    Args:
        name: key in the registry.
        title: what people call it.
        layouts: state, action and, as inputs, the wrench: force in world axes at the centre of mass in N,
            torque in body axes in N m.
        dt: control period in s.
        physics_dt: period of the simulator in s.
        low, high: limits of the commands ``# (action,)``.
        rest: the action that holds the robot where it is ``# (action,)``.
        random_low, random_high: range of the random commands of the first episode ``# (action,)``.
        start: state after a reset without one ``# (state,)``.
        mass: in kg.
        constants: further numbers by name, SI units.
        mjcf: file name of the description in this package.
        to_control: actions ``# (..., action)`` → actuator controls of the description ``# (..., nu)``.
        to_state: MuJoCo's qpos ``# (..., nq)`` and qvel ``# (..., nv)`` → states ``# (..., state)``; what a change has
            appended to them does not matter.
        to_coordinates: state ``# (state,)`` → qpos ``# (nq,)`` and qvel ``# (nv,)``.
        crashes_on_contact: true when touching the ground ends an episode; else rolling over does.
        dependencies: pairs (state column, action column): that action must show in that state's equation.
        angles: columns that may stand inside sin and cos.
        push_limits: largest absolute value of each wrench column in pushed rollouts.
        workspace_radius: half the width in m of the place that it is flown or driven in; an episode counts as that far
            off its path from a crash on.
        state_limits: norm of a state field that the robot cannot exceed, in its unit: a model that predicts more is
            wrong.
        cost_weights: default weights of the running cost, by position, orientation, velocity, rate.
        mppi: default sampling.
        nominal: makes the first-principles equations.
    """

    name: str
    title: str
    layouts: Layouts
    dt: float
    physics_dt: float
    low: Array
    high: Array
    rest: Array
    random_low: Array
    random_high: Array
    start: Array
    mass: float
    mjcf: str
    to_control: Callable[[Array], Array]
    to_state: Callable[[Array, Array], Array]
    to_coordinates: Callable[[Array], tuple[Array, Array]]
    crashes_on_contact: bool
    dependencies: tuple[tuple[str, str], ...]
    angles: tuple[str, ...]
    push_limits: Mapping[str, float]
    workspace_radius: float
    state_limits: Mapping[str, float]
    cost_weights: Mapping[str, float]
    mppi: MPPISettings
    nominal: Callable[[], Equations]
    constants: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("low", "high", "rest", "random_low", "random_high"):
            if getattr(self, name).shape != (self.layouts.action.size,):
                raise ShapeError(f"robot {self.name!r}: {name} needs {self.layouts.action.size} numbers")
        if self.start.shape != (self.layouts.state.size,):
            raise ShapeError(f"robot {self.name!r}: start needs {self.layouts.state.size} numbers")

    @property
    def substeps(self) -> int:
        """Physics steps per control period."""
        return round(self.dt / self.physics_dt)

    @property
    def numbers(self) -> dict[str, float]:
        """Mass in kg and the further numbers, as equations carry them for effects."""
        return {"mass": self.mass, **self.constants}

    def mjcf_text(self) -> str:
        """The description file's content."""
        return resources.files("sym2real.robots").joinpath(self.mjcf).read_text(encoding="utf-8")

    def read_state(self, mj_data: Any) -> Array:
        """State ``# (state,)`` of a simulation."""
        return self.to_state(np.array(mj_data.qpos), np.array(mj_data.qvel))

    def write_state(self, mj_data: Any, state: Array) -> None:
        """Put a simulation at a state ``# (state,)``; joints that a change has appended stay where they are."""
        if state.shape != (self.layouts.state.size,):
            raise ShapeError(f"a state of {self.name!r} has columns {self.layouts.state.columns}, found {state.shape}")
        qpos, qvel = self.to_coordinates(state)
        mj_data.qpos[: len(qpos)], mj_data.qvel[: len(qvel)] = qpos, qvel
