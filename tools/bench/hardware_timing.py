"""How steady the hardware loop's period is: hovers of the launch script over UDP, as a user starts it.

The fake Crazyflie runs in a process of its own; the stamps are those of the records. A run that is in the folder is not
flown again, so that the same command goes on where it was stopped. Give it a quiet machine:

    nice -n -15 python tools/bench/hardware_timing.py --out runs/timing
"""

import json
import math
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from figures import Figure, report

from hardware.recorder import task_of
from sym2real.files import write_text
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic.storage import save_model

ROOT = Path(__file__).resolve().parents[2]
RECORD = "flight.parquet"


@dataclass(frozen=True)
class Options:
    """Hover by MPPI at 50 Hz, again and again.

    Args:
        runs: hovers.
        seconds: length of each.
        quick: one hover of 5 s.
        out: folder that keeps every run.
        prefix: words before the launch script's command, such as "chrt -r 5" on a machine that others use.
        json: write the figures to this file (- is standard output).
    """

    runs: int = 20
    seconds: float = 30.0
    quick: bool = False
    out: Path = Path("build/bench/hardware_timing")
    prefix: str = ""
    json: Path | None = None


def timing(options: Options) -> list[Figure]:
    """Figures of all hovers together."""
    runs, seconds = (1, 5.0) if options.quick else (options.runs, options.seconds)
    save_model(CRAZYFLIE.nominal(), options.out / "model")
    places = [options.out / f"{seconds:g}_s_{number:02d}" for number in range(runs)]
    results = [_hovered(place, seconds, options.prefix) for place in places]
    flown = [place / RECORD for place, result in zip(places, results, strict=True) if "act_median" in result]
    periods = [np.diff(task_of(file, CRAZYFLIE).time) for file in flown]
    together = np.concatenate(periods) if periods else np.full(1, math.nan)
    jitter = np.abs(together - CRAZYFLIE.dt)
    steady = sum(1 for result in results if result["missed"] == 0)
    return [
        Figure(f"hovers of {seconds:g} s flown to their end", sum(result["completed"] for result in results),
               f"of {runs}", f">= {runs}"),
        Figure("mean period", 1000.0 * float(together.mean()), "ms", "19.9 to 20.1"),
        Figure("p99 of the jitter", 1000.0 * float(np.quantile(jitter, 0.99)), "ms", "< 2"),
        Figure("runs without a missed deadline", steady, f"of {runs}", f">= {math.ceil(0.95 * runs)}"),
    ]  # fmt: skip


def _hovered(out: Path, seconds: float, prefix: str) -> dict[str, Any]:
    """What the launch script says of a run, flown where it is not there yet."""
    answer = out.with_suffix(".json")
    if not answer.exists():
        shutil.rmtree(out, ignore_errors=True)  # of a run that was stopped
        command = [sys.executable, "-m", "hardware.run", "crazyflie", str(out.with_name("model"))]
        command += ["hover", "--sim", "--seconds", f"{seconds:g}", "--out", str(out), "--json", str(answer)]
        ended = subprocess.run([*shlex.split(prefix), *command], cwd=ROOT, stdout=subprocess.DEVNULL, check=False)
        if ended.returncode:
            write_text(answer, json.dumps({"completed": False, "missed": None}))
    result: dict[str, Any] = json.loads(answer.read_text())
    said = "to its end" if result["completed"] else "NOT to its end"
    print(f"{out.name}: {said}, {result['missed']} periods missed", file=sys.stderr)
    return result


def main(options: Options) -> None:
    """Print the table; write the figures."""
    report("The hardware loop's period, over UDP", timing(options), [], options.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
