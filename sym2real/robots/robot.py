"""What a robot is to this package: columns, limits, description, and the recipe by which its model is learned."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sym2real.errors import ShapeError
from sym2real.layout import Layouts
from sym2real.robots.description import Description
from sym2real.robots.recipe import Recipe
from sym2real.symbolic.period import at_period
from sym2real.trajectory import Array
from sym2real.vocabulary import LARGEST_PLACE

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
class Limits:
    """What a robot may be commanded, and how far it goes.

    Args:
        low, high: of the commands, in each action's unit ``# (action,)``.
        draws: range of the random commands of the first episode, twice ``# (action,)``; the limits by default.
        push: largest absolute value of each input column in rollouts under a wrench, N and N m.
        state: norm of a state field that the robot cannot exceed, in its unit: a model that predicts more is wrong.
        workspace: half the width of the place that it moves in, in the unit of its first state field; an episode
            counts as that far off its reference from a crash on.
    """

    low: Array
    high: Array
    draws: tuple[Array, Array] | None = None
    push: Mapping[str, float] = field(default_factory=dict)
    state: Mapping[str, float] = field(default_factory=dict)
    workspace: float = 1.0

    @property
    def random_low(self) -> Array:
        """Least random command ``# (action,)``."""
        return self.low if self.draws is None else self.draws[0]

    @property
    def random_high(self) -> Array:
        """Largest random command ``# (action,)``."""
        return self.high if self.draws is None else self.draws[1]


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot and all the numbers that its plants, tasks and controllers need.

    Args:
        name: key in the registry.
        layouts: state, action and, as inputs, external forces: of a free body the wrench, force in world axes at the
            centre of mass in N, torque in body axes in N m.
        dt: control period in s.
        limits: of commands, states and external forces.
        description: what a simulator needs.
        recipe: how a model of it is learned and judged.
        numbers: by name in SI units, as equations carry them for effects; ``mass`` in kg.
        mppi: default sampling.
        rigid_body: makes the first-principles equations of :meth:`nominal`.
        title: what people call it; its name by default.

    Raises:
        ShapeError: for limits or a start that do not fit the columns.

    Examples:
        >>> isinstance(ROBOTS["crazyflie"], Robot)
        True
        >>> ROBOTS["crazyflie"].layouts.action.columns
        ('thrust', 'wx_cmd', 'wy_cmd', 'wz_cmd')
    """

    name: str
    layouts: Layouts
    dt: float
    limits: Limits
    description: Description
    recipe: Recipe
    numbers: Mapping[str, float]
    mppi: MPPISettings
    rigid_body: Callable[[], Equations]
    title: str = ""

    def __post_init__(self) -> None:
        columns = self.layouts.action.size
        given = {"low": self.low, "high": self.high, "rest": self.rest}
        given |= {"random_low": self.limits.random_low, "random_high": self.limits.random_high}
        for name, values in given.items():
            if values.shape != (columns,):
                raise ShapeError(f"robot {self.name!r}: {name} needs {columns} numbers")
        if self.start.shape != (self.layouts.state.size,):
            raise ShapeError(f"robot {self.name!r}: start needs {self.layouts.state.size} numbers")
        object.__setattr__(self, "title", self.title or self.name)

    @property
    def low(self) -> Array:
        """Least commands ``# (action,)``."""
        return self.limits.low

    @property
    def high(self) -> Array:
        """Largest commands ``# (action,)``."""
        return self.limits.high

    @property
    def rest(self) -> Array:
        """The action that holds the robot where it is ``# (action,)``."""
        return self.description.rest

    @property
    def start(self) -> Array:
        """State after a reset without one ``# (state,)``."""
        return self.description.start

    @property
    def moved(self) -> dict[str, str]:
        """Joint that each action moves by itself, as far as the recipe says so."""
        joints = {rate: joint for joint, rate in self.layouts.state.rates.items()}
        return {action: joints[rate] for rate, action in self.recipe.dependencies if rate in joints}

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Least and largest place, rad or m, of the joints that have stops, and of the commands that are places."""
        from sym2real.robots.mjcf_columns import stops_of  # noqa: PLC0415 — it needs MuJoCo

        stops = stops_of(self.description.spec().compile())
        ends = zip(self.layouts.action, self.low.tolist(), self.high.tolist(), strict=True)
        commands = {name: (low, high) for name, low, high in ends if self.layouts.action.units[name] in LARGEST_PLACE}
        return {name: ends for name, ends in stops.items() if name in self.layouts.state} | commands

    @property
    def mass(self) -> float:
        """In kg."""
        return self.numbers["mass"]

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names that its nominal equations derive, as far as effects bind to them."""
        return self.description.quantities

    @property
    def substeps(self) -> int:
        """Physics steps per control period."""
        return round(self.dt / self.description.physics_dt)

    def at_period(self, dt: float) -> Robot:
        """The same commanded every ``dt`` s, in physics steps that are no longer than its own."""
        physics_dt = dt / math.ceil(dt / self.description.physics_dt - 1e-9)
        return replace(self, dt=dt, description=replace(self.description, physics_dt=physics_dt))

    @classmethod
    def from_mjcf(cls, path: str | Path, **options: Any) -> Robot:
        """A robot from any MJCF; options and errors of :func:`sym2real.robots.from_mjcf.from_mjcf`."""
        from sym2real.robots.from_mjcf import from_mjcf  # noqa: PLC0415 — it makes robots, and needs MuJoCo

        return from_mjcf(path, **options)

    def nominal(self) -> Equations:
        """First-principles equations over its period, or their own where that is longer, with its name and numbers."""
        return self.signed(at_period(self.rigid_body(), self.dt))

    def signed(self, equations: Equations) -> Equations:
        """Equations that say whose they are: name and numbers, and of a robot of one's own what it was made from."""
        from sym2real.robots.own import origin_of  # noqa: PLC0415 — it makes robots

        return replace(equations, robot=self.name, numbers=self.numbers, origin=origin_of(self))

    def within(self, low: Array, high: Array) -> Robot:
        """The robot with other limits of its commands ``# (action,)``."""
        return replace(self, limits=replace(self.limits, low=low, high=high))

    def read_state(self, mj_data: Any) -> Array:
        """State ``# (state,)`` of a simulation."""
        return self.description.to_state(np.array(mj_data.qpos), np.array(mj_data.qvel))

    def write_state(self, mj_data: Any, state: Array) -> None:
        """Put a simulation at a state ``# (state,)``; joints that a change has appended stay where they are."""
        if state.shape != (self.layouts.state.size,):
            raise ShapeError(f"a state of {self.name!r} has columns {self.layouts.state.columns}, found {state.shape}")
        qpos, qvel = self.description.to_coordinates(state)
        mj_data.qpos[: len(qpos)], mj_data.qvel[: len(qvel)] = qpos, qvel
