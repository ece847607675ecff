"""How long other people's recordings take to open: ten minutes of 100 Hz, read and resampled to a car's step.

Seconds are of processor time, which other programs on the machine bend less.

The files are written by the formats' own libraries (see tests/recordings.py) into a temporary folder. Of a million rows
as Parquet, a flight of formulas at 100 Hz and at 1 kHz, it is how long `inspect` and a reading at 50 Hz take.

    python tools/bench/recordings.py
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import tyro
from figures import Figure, report

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

import test_logs_recordings as cases
from long_flight import flight, save

from sym2real.logs import inspect_logs, read_log

MINUTES, HERTZ, BAR = 10, 100, "<= 3"
MANY, MANY_AT, MANY_BAR = 10**6, (100.0, 1000.0), "<= 8"


def main(json: Path | None = None) -> None:
    """Print the seconds of processor time of every format, the least of three, and those of many rows as Parquet.

    Args:
        json: Write the figures to this file (- is standard output).
    """
    cases.POSES_AT = np.arange(0.0, 60.0 * MINUTES, 1 / HERTZ)
    cases.COMMANDS_AT = np.arange(0.013, 60.0 * MINUTES, 0.05)
    figures = []
    for kind, write in cases.FORMATS.items():
        with tempfile.TemporaryDirectory() as folder:
            path, spec = write(Path(folder))
            seconds = []
            for _ in range(3):
                started = time.process_time()
                read_log(path, spec, layouts=cases.CAR)
                seconds.append(time.process_time() - started)
        figures.append(Figure(f"{kind}: {MINUTES} min of {HERTZ} Hz read and resampled", min(seconds), "s CPU", BAR))
    for hertz in MANY_AT:
        figures += _many_rows(hertz)
    report("Recordings", figures, [], json)


def _many_rows(hertz: float) -> list[Figure]:
    """Opened and read once."""
    with tempfile.TemporaryDirectory() as folder:
        path = save(flight(MANY, hertz), Path(folder) / "many.parquet")
        started = time.process_time()
        spec = inspect_logs(path).spec
        inspected = time.process_time()
        read_log(path, spec, dt=0.02)
        read = time.process_time()
    rows = f"{MANY:,} Parquet rows of {hertz:g} Hz"
    return [
        Figure(f"inspect of {rows}", inspected - started, "s CPU", MANY_BAR),
        Figure(f"{rows} read at 50 Hz", read - inspected, "s CPU", BAR),
    ]


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
