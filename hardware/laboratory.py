"""What a verb needs of a kind of robot: a link to it or to a fake, what must hold, what may pass."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, ClassVar

from hardware.checks import Check
from hardware.interfaces import Pilot, Reading, RobotLink
from sym2real.robots import Robot
from sym2real.trajectory import Array

Say = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Opened:
    """A link, and who puts the robot back.

    Args:
        link: not yet connected.
        put: brings the robot near a start ``# (state,)`` and returns; None for a robot that goes to any start itself.
    """

    link: RobotLink
    put: Callable[[Array], None] | None = None


@dataclass(frozen=True, kw_only=True)
class Laboratory(ABC):
    """The robot and what sees it."""

    ROBOT: ClassVar[Robot]
    RECORD: ClassVar[str]  # name of a run's file
    GOING: ClassVar[str]  # in words, before the task
    STOPPING: ClassVar[str]  # and behind it

    axes: tuple[str, str, str] = ("x", "y", "z")
    """Which of motion capture's axes are the world's x, y and z (z up); x -z y where y points upward."""
    sim: bool = False
    """A fake robot and what sees it start beside this script, in a process of their own."""
    effects: tuple[str, ...] = ()
    """Hidden in the fake: each KIND or KIND:COLUMN, then its PARAMETER=VALUE (`sym2real effects` lists them)."""

    @abstractmethod
    def open(self, start: Array, say: Say, *, dry: bool = False) -> AbstractContextManager[Opened]:
        """A link that is not yet connected, closed in the end.

        Args:
            start: state ``# (state,)`` near which a fake is put.
            say: tells a person what to do.
            dry: nothing is sent.

        Raises:
            ModelError: for options that do not fit together.
            LinkError: where what the link needs does not answer, or the fake does not start.
        """

    @abstractmethod
    def checks(self, readings: Sequence[Reading]) -> list[Check]:
        """Judge what was observed at rest."""

    @abstractmethod
    def pilot(self) -> Pilot:
        """What may pass."""

    @property
    @abstractmethod
    def target(self) -> dict[str, Any]:
        """What a run that is continued must find again, or its logs are of different robots."""

    @property
    @abstractmethod
    def about(self) -> dict[str, Any]:
        """What a record says of the pilot: numbers, texts, lists and dictionaries of them."""
