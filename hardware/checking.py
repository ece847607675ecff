"""Connect to a robot and its motion capture, and measure for some seconds what a run needs. Nothing moves.

For example:
  python -m hardware.checking crazyflie --sim
  python -m hardware.checking crazyflie --thrust-map 2026.04 --capture vicon --settings hostname=192.168.1.2
  python -m hardware.checking mushr --master http://192.168.1.3:11311 --poses /vicon/car/car --kind TransformStamped
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Generic

import tyro
from rich.console import Console

from hardware.checks import connected
from hardware.command_line import main
from hardware.robots import Kind, of_every_robot
from sym2real.cli.numbers import Seconds


@dataclass(frozen=True)
class Checking(Generic[Kind]):
    """Connect to a robot and its motion capture, and measure for some seconds what a run needs. Nothing moves."""

    laboratory: Annotated[Kind, tyro.conf.arg(name="")]
    """The robot and what sees it; what is measured must keep within half of the ages that its limits allow."""
    dry_run: bool = False
    """Taken as by every launch script; a check sends nothing anyway."""
    seconds: Seconds = 3.0
    """How long to measure."""
    json: Path | None = None
    """Write the result to this file (- is standard output)."""

    def run(self, console: Console) -> dict[str, Any]:
        """Connect, measure, say what holds."""
        with self.laboratory.open(self.laboratory.ROBOT.start, console.print, dry=True) as opened:
            found = connected(opened.link, self.laboratory.checks, self.seconds, console.print)
        ready = all(check.holds for check in found)
        console.print("ready" if ready else "not ready")
        return {"ready": ready, "checks": [asdict(check) for check in found]}


if __name__ == "__main__":
    main(of_every_robot(Checking), "python -m hardware.checking", __doc__)
