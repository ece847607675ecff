"""``python -m hardware.check_link``: is everything there that a flight needs? Nothing moves."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import tyro
from rich.console import Console

from hardware.checks import checks, observe, report
from hardware.clock import SystemClock
from hardware.command_line import main
from hardware.crazyflie.laboratory import Laboratory
from hardware.safety import Limits

REAL, LIMITS = Laboratory(), Limits()


@dataclass(frozen=True)
class CheckLink:
    """Connect to a Crazyflie and its motion capture, and measure for some seconds what a flight needs. Nothing moves.

    For example:
      python -m hardware.check_link --sim
      python -m hardware.check_link --thrust-map 2026.04 --capture vicon --settings hostname=192.168.1.2
    """

    laboratory: tyro.conf.OmitArgPrefixes[Laboratory] = REAL
    """The robot and what sees it."""
    limits: Limits = LIMITS
    """Of the flight: what is measured must keep within half of its ages."""
    seconds: float = 3.0
    """How long to measure."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    def run(self, console: Console) -> dict[str, Any]:
        """Connect, measure, say what holds."""
        with self.laboratory.link(dry=True) as link:
            console.print("waiting for motion capture, the robot's tables and its first log packet")
            link.connect()
            console.print(f"connected: CRTP protocol {link.connection.protocol}, route {link.route.name}")
            found = checks(observe(link, SystemClock(), self.seconds), self.limits)
        ready = report(found, console.print)
        console.print("ready to fly" if ready else "not ready to fly")
        return {"ready": ready, "checks": [asdict(check) for check in found]}


if __name__ == "__main__":
    main(CheckLink, "python -m hardware.check_link")
