"""A check from the command line: connect, measure for some seconds, say what holds. Nothing moves."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from hardware.checks import Check, connected
from hardware.interfaces import Reading, RobotLink


@dataclass(frozen=True)
class Checking(ABC):
    """What checks share; a script's options are these and its own."""

    seconds: float = 3.0
    """How long to measure."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    @abstractmethod
    def link(self) -> AbstractContextManager[RobotLink]:
        """A link that sends nothing, not yet connected."""

    @abstractmethod
    def checks(self, readings: Sequence[Reading]) -> list[Check]:
        """Judge what was observed."""

    def run(self, console: Console) -> dict[str, Any]:
        """Connect, measure, say what holds."""
        with self.link() as link:
            found = connected(link, self.checks, self.seconds, console.print)
        ready = all(check.holds for check in found)
        console.print("ready" if ready else "not ready")
        return {"ready": ready, "checks": [asdict(check) for check in found]}
