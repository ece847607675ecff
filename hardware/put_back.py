"""Episode after episode on a robot that a person puts back in between: a car cannot turn on the spot."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hardware.interfaces import Pilot, RobotLink
from hardware.plant import HardwarePlant, Row
from sym2real.layout import Layouts
from sym2real.robots import Robot
from sym2real.trajectory import Array


class PutBackPlant:
    """A :class:`~sym2real.protocols.Plant` for `adapt`, with a :class:`HardwarePlant` for every episode.

    One that has ended by a fault does not keep the next from its start: a person has looked at the robot.

    Args:
        link: connected.
        pilot: makes the pilot of an episode.
        put: called with the start ``# (state,)``; returns when the robot stands near it.
        record: called once a control period.
    """

    def __init__(
        self,
        link: RobotLink,
        pilot: Callable[[], Pilot],
        put: Callable[[Array], None],
        record: Callable[[Row], None] = lambda _: None,
    ) -> None:
        self._link, self._pilot, self._put, self._record = link, pilot, put, record
        self._episode = self._begun()

    @property
    def robot(self) -> Robot:
        """With the limits of the link's commands."""
        return self._link.robot

    @property
    def layouts(self) -> Layouts:
        """The robot's columns."""
        return self.robot.layouts

    @property
    def dt(self) -> float:
        """Control period in s."""
        return self.robot.dt

    @property
    def inputs(self) -> Array:
        """Zeros ``# (inputs,)``."""
        return self._episode.inputs

    @property
    def crashed(self) -> bool:
        """Whether the episode has ended."""
        return self._episode.crashed

    @property
    def sent(self) -> Array:
        """What the robot was told last ``# (action,)``."""
        return self._episode.sent

    @property
    def ended(self) -> str:
        """Why the episode ended; empty while it goes on."""
        return self._episode.ended

    @property
    def missed(self) -> int:
        """Control periods of this episode that went by without an action."""
        return self._episode.missed

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Stop; have the robot put back; go to the start from there. Arguments and errors as of a hardware plant."""
        self._episode.close()
        self._put(self.robot.start if state is None else np.asarray(state, dtype=np.float64))
        self._episode = self._begun()
        return self._episode.reset(state, seed)

    def step(self, action: ArrayLike) -> Array:
        """As of a hardware plant."""
        return self._episode.step(action)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._episode.__exit__(kind, error, trace)

    def _begun(self) -> HardwarePlant:
        return HardwarePlant(self._link, self._pilot(), record=self._record)
