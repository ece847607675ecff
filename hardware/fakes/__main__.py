"""A fake Crazyflie as a process: ``python -m hardware.fakes --port 19850 --poses-to 7000``; it ends with its input."""

import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from rich.console import Console

from hardware.command_line import main
from hardware.fakes.crazyflie import FakeCrazyflie
from hardware.fakes.vehicle import Truth
from sym2real.cli.chosen import chosen_effects, require_values
from sym2real.robots import CRAZYFLIE

LINGER = 4.0  # s: longer than the firmware's watchdogs, which act when a client is killed


@dataclass(frozen=True)
class Fake:
    """A Crazyflie on UDP with MuJoCo behind it, for cflib and for every program that is built on it.

    It prints its address, and ends when its standard input does (Ctrl-D).

    For example:
      python -m hardware.fakes --port 19850 --effects added_mass value=0.005 gain:thrust value=0.79
    """

    port: int = 0
    """UDP port to listen on; 0 takes one that is free."""
    poses_to: int | None = None
    """UDP port on this machine that motion capture sends poses to: 8 little-endian doubles, time, position, w x y z."""
    protocol: Literal[9, 10, 12] = 12
    """Version of CRTP that its firmware speaks."""
    counts_per_newton: float = 111342.0
    """What its motors make of a thrust count."""
    volts: float = 4.1
    """Of its battery."""
    effects: tuple[str, ...] = ()
    """Hidden in it: each KIND or KIND:COLUMN, then its PARAMETER=VALUE (`sym2real effects` lists them)."""
    seed: int = 0
    """Of the sensors' noise."""
    json: Path | None = None
    """Write the address to this file."""

    def run(self, console: Console) -> dict[str, Any]:
        """Serve until the input ends."""
        chosen = chosen_effects(self.effects, CRAZYFLIE)
        require_values(chosen)
        truth = Truth(counts_per_newton=self.counts_per_newton, volts=self.volts, seed=self.seed)
        poses_to = None if self.poses_to is None else ("127.0.0.1", self.poses_to)
        hidden = [(one.key, dict(values)) for one, values in chosen]
        with FakeCrazyflie(truth, hidden, protocol=self.protocol, port=self.port, poses_to=poses_to) as fake:
            print(fake.uri, flush=True)
            sys.stdin.read()
            time.sleep(LINGER)
        return {"uri": fake.uri}


if __name__ == "__main__":
    main(Fake, "python -m hardware.fakes", Fake.__doc__)
