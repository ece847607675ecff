"""Where outsiders plug in: what a model, a plant, a controller, a change and a regression engine must offer."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar, runtime_checkable

from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.dataset import Transitions
from sym2real.layout import Layouts
from sym2real.trajectory import Array

Filter = Callable[[Array], Array]
Fitted = TypeVar("Fitted")
Base_contra = TypeVar("Base_contra", contravariant=True)
Model = TypeVar("Model")


class DynamicsModel(Protocol):
    """A one-step prediction: state ``# (..., state)``, action ``# (..., action)`` → next state ``# (..., state)``."""

    def __call__(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor: ...


class WholeModel(DynamicsModel, Protocol):
    """A model that knows its columns."""

    @property
    def layouts(self) -> Layouts:
        """Columns of state, action and inputs, as a log has them."""


class Plant(Protocol):
    """What a controller acts on: a simulator, a model, a replayed log or a robot."""

    @property
    def layouts(self) -> Layouts:
        """Columns of state, action and inputs."""

    @property
    def dt(self) -> float:
        """Control period in s."""

    @property
    def inputs(self) -> Array:
        """Known inputs at the present moment ``# (inputs,)``."""

    @property
    def crashed(self) -> bool:
        """True once the episode cannot go on (ground contact)."""

    @property
    def sent(self) -> Array:
        """What the last step sent ``# (action,)``: the action that was asked for, unless a limit or a link changed it.

        Logs and controllers' memories hold this one.
        """

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Start an episode, at ``state`` or where the plant chooses; the measured state ``# (state,)``."""

    def step(self, action: ArrayLike) -> Array:
        """Hold ``action`` ``# (action,)`` for one control period; the measured state after it ``# (state,)``."""


class Controller(Protocol):
    """Chooses actions; owns the memory of what was sent."""

    def reset(self) -> None:
        """Forget what was sent: an episode begins."""

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Action ``# (action,)`` for a measured state ``# (state,)`` at this step of the task."""

    def remember(self, sent: ArrayLike) -> None:
        """Take note of the action that was really sent ``# (action,)``."""


class Memoryless:
    """Part of a :class:`Controller` whose actions follow from the state, the step and its own draws."""

    def reset(self) -> None:
        """Nothing to forget."""

    def remember(self, sent: ArrayLike) -> None:
        """What was sent does not alter the next action."""


@runtime_checkable
class MovingFilter(Protocol):
    """A filter of commands behind which actuators move within a control period."""

    def __call__(self, action: Array) -> Array:
        """Where they are after the period."""

    def move(self, model: Any, data: Any) -> None:
        """Called with ``(MjModel, MjData)`` before every physics step of the period: sets their controls."""


@dataclass(frozen=True)
class Change:
    """One physical difference between a target plant and the plain one, by the simulator's own means.

    Args:
        name: what to call it.
        edit: alters the ``mujoco.MjSpec`` before compilation.
        force: called with ``(MjModel, MjData)`` before every physics step; adds to ``data.xfrc_applied``,
            which the plant has set to zero, to ``data.qfrc_applied``, or sets what only the present state decides (a
            control, a wheel's angle).
        command: makes, at every reset, a filter of the actions (called once a control period with the action
            ``# (action,)`` that was sent; returns what reaches the actuators), perhaps a :class:`MovingFilter`.
        measure: makes, at every reset, a filter of the measured states ``# (state,)``.
    """

    name: str
    edit: Callable[[Any], None] | None = None
    force: Callable[[Any, Any], None] | None = None
    command: Callable[[], Filter] | None = None
    measure: Callable[[], Filter] | None = None


class SymbolicRegressor(Protocol[Fitted]):
    """Finds equations: warm-started from ``start`` where it is given."""

    def fit(self, transitions: Transitions, start: Fitted | None = None) -> Fitted:
        """Equations that predict the transitions."""


class Learner(Protocol[Base_contra, Model]):
    """Fits what a frozen base leaves of transitions: SR*+NN, SR*+SR, NN*+NN and NN*+SR are two arguments."""

    def fit(self, transitions: Transitions, base: Base_contra, start: Model | None = None) -> Model:
        """The base, which stays as it is, with what was learned; warm-started from an earlier result."""
