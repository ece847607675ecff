"""The hardware loop: how steady its period is, what happens when a part fails, and the car over ROS 1.

It runs hardware_timing.py, hardware_faults.py and hardware_car.py one after the other; each also runs alone.

    python tools/bench/hardware_loop.py
"""

from dataclasses import dataclass
from pathlib import Path

import hardware_car
import hardware_faults
import hardware_timing
import tyro
from figures import report


@dataclass(frozen=True)
class Options:
    """Measure the loop's period, inject faults, drive the car.

    Args:
        quick: one hover of 5 s, one adaptation.
        out: folder that keeps every hover; the same command goes on with those that are missing.
        json: write the figures to this file (- is standard output).
    """

    quick: bool = False
    out: Path = hardware_timing.Options.out
    json: Path | None = None


def main(options: Options) -> None:
    """Print all tables; write the figures."""
    figures = hardware_faults.faults()
    figures += hardware_timing.timing(hardware_timing.Options(quick=options.quick, out=options.out))
    figures += hardware_car.car(hardware_car.Options(seeds=1 if options.quick else 3))
    report("The hardware loop, over UDP and ROS 1", figures, [], options.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
