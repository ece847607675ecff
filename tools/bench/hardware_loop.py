"""The hardware loop: how steady its period is, what happens when a part fails, and the car over ROS 1.

It runs hardware_timing.py, hardware_faults.py and hardware_car.py one after the other; each also runs alone.

    python tools/bench/hardware_loop.py
"""

from pathlib import Path

import hardware_car
import hardware_faults
import hardware_timing
import tyro
from figures import report


def main(quick: bool = False, out: Path = hardware_timing.Options.out, json: Path | None = None) -> None:
    """Measure the loop's period, inject faults, drive the car.

    Args:
        quick: one hover of 5 s, one adaptation.
        out: folder that keeps every hover; the same command goes on with those that are missing.
        json: write the figures to this file (- is standard output).
    """
    figures = hardware_faults.faults()
    figures += hardware_timing.timing(hardware_timing.Options(quick=quick, out=out))
    figures += hardware_car.car(hardware_car.Options(seeds=1 if quick else 3))
    report("The hardware loop, over UDP and ROS 1", figures, [], json)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
