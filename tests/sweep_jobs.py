"""Jobs for the sweep's tests: importable by the processes that run them."""

import os
import signal
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from sym2real.experiments.study.sweep import Tell


@dataclass(frozen=True)
class Square:
    """Squares a number, and leaves a line in a file each time it runs; it may wait, fail, or kill its process once."""

    value: int
    log: str
    wait: float = 0.0
    fails: bool = False
    kills: bool = False

    @property
    def name(self) -> str:
        return f"square-{self.value}"

    @property
    def asked(self) -> dict[str, Any]:
        return {key: value for key, value in asdict(self).items() if key != "fails"}

    def run(self, tell: Tell) -> dict[str, Any]:
        tell("squaring")
        with Path(self.log).open("a") as file:
            file.write(f"{self.value} by {os.getpid()}\n")
        if self.fails:
            raise ValueError("no square today")
        if self.kills and Path(self.log).read_text().count(f"{self.value} by") == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(self.wait)
        return {"square": self.value**2}
