"""The stages of long work: each says what it does; Ctrl-C ends one that need not be done, and what is done is kept."""

from collections.abc import Callable
from typing import TypeVar

Taken = TypeVar("Taken")
Made = TypeVar("Made")
OnProgress = Callable[[str], None]


class Stages:
    """Says what is being done, and remembers what was interrupted.

    Args:
        on_progress: told what is being done.
        finish: whether Ctrl-C ends a stage, and not the whole.

    Attributes:
        interrupted: stages that were.
    """

    def __init__(self, on_progress: OnProgress, *, finish: bool = False) -> None:
        self.on_progress, self._finish = on_progress, finish
        self.interrupted: list[str] = []

    def run(self, what: str, work: Callable[[Taken], Made], value: Taken) -> Made:
        """What a stage makes of a value."""
        self.on_progress(what)
        return work(value)

    def try_to(self, what: str, work: Callable[[Taken], Made], value: Taken) -> Made | None:
        """What a stage makes of a value, as in "searching among 20 effects"; None where Ctrl-C ended it."""
        try:
            return self.run(what, work, value)
        except KeyboardInterrupt:
            if not self._finish:
                raise
            self.interrupted.append(what)
            return None

    @property
    def notes(self) -> tuple[str, ...]:
        """A remark on each stage that was interrupted."""
        return tuple(f"interrupted while {what}" for what in self.interrupted)
