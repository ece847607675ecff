"""The stages of a diagnosis behind its search: Ctrl-C ends the one that runs, and what is done is kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Made = TypeVar("Made")


class Stages:
    """Says what is being done, and remembers what was interrupted.

    Args:
        on_progress: told what is being done.
        finish: whether Ctrl-C ends a stage, and not the diagnosis.

    Attributes:
        interrupted: stages that were.
    """

    def __init__(self, on_progress: Callable[[str], None], *, finish: bool) -> None:
        self._on_progress, self._finish = on_progress, finish
        self.interrupted: list[str] = []

    def run(self, what: str, work: Callable[[], Made]) -> Made | None:
        """What a stage makes, as in "searching among 20 effects"; None where Ctrl-C ended it."""
        try:
            self._on_progress(what)
            return work()
        except KeyboardInterrupt:
            if not self._finish:
                raise
            self.interrupted.append(what)
            return None

    @property
    def notes(self) -> tuple[str, ...]:
        """A remark on each stage that was interrupted."""
        return tuple(f"interrupted while {what}" for what in self.interrupted)
