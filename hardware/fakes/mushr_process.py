"""A fake MuSHR as a process: ``python -m hardware.fakes.mushr_process``; it ends with its input."""

import logging
import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from hardware.command_line import main
from hardware.fakes.master import FakeMaster
from hardware.fakes.mushr import TIMEOUT, Car, FakeMushr, Truth
from hardware.ros1 import Node
from sym2real.cli.chosen import chosen_effects, require_values
from sym2real.robots import MUSHR

LINGER = 10.0 * TIMEOUT  # s: longer than the multiplexer holds a command, and the car brakes


@dataclass(frozen=True)
class FakeCar:
    """A MuSHR on ROS 1 with MuJoCo behind it, its multiplexer, its motion capture, and a ROS master.

    It prints the master's address, and ends when its standard input does (Ctrl-D). A line with x and y in m and yaw in
    rad puts the car there, and is answered once it stands there.

    For example:
      python -m hardware.fakes.mushr_process --latency 0.2 --effects offset:steer value=0.1
    """

    master: str | None = None
    """Address of a ROS master; one of its own by default."""
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where it stands: x and y in m, yaw in rad."""
    latency: float = 0.0
    """From a command's arrival to the wheels, s."""
    effects: tuple[str, ...] = ()
    """Hidden in it: each KIND or KIND:COLUMN, then its PARAMETER=VALUE (`sym2real effects` lists them)."""
    seed: int = 0
    """Of motion capture's noise."""
    json: Path | None = None
    """Write the address to this file."""

    def run(self, console: Console) -> dict[str, Any]:
        """Serve until the input ends."""
        logging.getLogger("hardware.ros1").setLevel(logging.ERROR)  # scripts come and go
        chosen = chosen_effects(self.effects, MUSHR)
        require_values(chosen)
        hidden = [one.inject(**values) for one, values in chosen]
        car = Car(Truth(latency=self.latency, start=self.start, seed=self.seed), hidden)
        with ExitStack() as stack:
            master = self.master or stack.enter_context(FakeMaster()).uri
            fake = stack.enter_context(FakeMushr(Node("/fake_mushr", master), car))
            print(master, flush=True)
            for line in sys.stdin:
                x, y, yaw = map(float, line.split())
                fake.put(x, y, yaw)
                print("there", flush=True)
            time.sleep(LINGER)
        return {"master": master}


if __name__ == "__main__":
    main(FakeCar, "python -m hardware.fakes.mushr_process", FakeCar.__doc__)
