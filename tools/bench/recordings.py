"""How long other people's recordings take to open: ten minutes of 100 Hz, read and resampled to a car's step.

The files are written by the formats' own libraries (see tests/recordings.py) into a temporary folder.

    python tools/bench/recordings.py
"""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro
from figures import Figure, report

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

import test_logs_recordings as cases

from sym2real.logs import read_log

MINUTES, HERTZ, BAR = 10, 100, "<= 3"


@dataclass(frozen=True)
class Options:
    """Time the readers of recordings."""

    json: Path | None = None
    """Write the figures to this file (- is standard output)."""


def main(options: Options) -> None:
    """Print the seconds of every format, the least of three, beside those of the same rows as CSV."""
    cases.POSES_AT = np.arange(0.0, 60.0 * MINUTES, 1 / HERTZ)
    cases.COMMANDS_AT = np.arange(0.013, 60.0 * MINUTES, 0.05)
    figures = []
    for kind, write in cases.FORMATS.items():
        with tempfile.TemporaryDirectory() as folder:
            path, spec = write(Path(folder))
            seconds = []
            for _ in range(3):
                started = time.perf_counter()
                read_log(path, spec, layouts=cases.CAR)
                seconds.append(time.perf_counter() - started)
        figures.append(Figure(f"{kind}: {MINUTES} min of {HERTZ} Hz read and resampled", min(seconds), "s", BAR))
    report("Recordings", figures, [], options.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
