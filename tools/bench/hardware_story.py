"""Two flights on the command line: fly, compare, diagnose, add, fly again; is what is wrong named, and is it mended?

Hidden in the fake Crazyflie: 5 g more, and 0.79 of the thrust that its map says. The commands are those of
docs/hardware.md; the model is the plain simulator's base, learned once and cached.

    python tools/bench/hardware_story.py
    python tools/bench/hardware_story.py --prefix "chrt -r 5"     # on a machine that others use
"""

import json
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tyro
from figures import Figure, report
from rich.console import Console

ROOT = Path(__file__).resolve().parents[2]
HIDDEN = ("added_mass", "value=0.005", "gain:thrust", "value=0.79")
GROUP = {"added_mass", "gain:thrust"}


@dataclass(frozen=True)
class Options:
    """Fly twice, with a diagnosis in between.

    Args:
        task: what is flown.
        seconds: length of a flight: below 20 s there are too few pieces to test what was found.
        seed: of MPPI's samples.
        prefix: words before the commands of flights, which need their periods.
        out: new folder that keeps what the commands write.
        json: write the figures to this file (- is standard output).
    """

    task: str = "circle"
    seconds: float = 24.0
    seed: int = 0
    prefix: str = ""
    out: Path | None = None
    json: Path | None = None


def told(command: Sequence[str], out: Path, prefix: Sequence[str] = ()) -> dict[str, Any]:
    """What a command says to ``--json``, once it has succeeded."""
    Console(stderr=True).print(f"$ python -m {' '.join(command)}", markup=False, soft_wrap=True)
    answer = out.with_suffix(".json")
    whole = [*prefix, sys.executable, "-m", *command, "--json", str(answer)]
    subprocess.run(whole, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    return json.loads(answer.read_text())


def flown(model: str, name: str, folder: Path, options: Options) -> dict[str, Any]:
    """A flight of the launch script."""
    out = folder / name
    command = ["hardware.run", "crazyflie", model, options.task, "--sim", "--effects", *HIDDEN]
    command += ["--seconds", f"{options.seconds:g}", "--seed", str(options.seed), "--out", str(out)]
    return told(command, out, shlex.split(options.prefix))


def as_typed(findings: Sequence[Mapping[str, Any]]) -> list[str]:
    """Effects and their values as ``sym2real add`` takes them."""
    return [
        word
        for finding in findings
        for word in (finding["effect"], *(f"{name}={one['value']}" for name, one in finding["parameters"].items()))
    ]


def story(folder: Path, options: Options) -> list[Figure]:
    """The commands one after the other; a figure for what each must show."""
    first = flown("crazyflie", "flight_1", folder, options)
    log = str(first["log"])
    before = told(["sym2real", "compare", "crazyflie", log, "--out", str(folder / "compared")], folder / "compared")
    found = told(["sym2real", "diagnose", "crazyflie", log, "--out", str(folder / "found")], folder / "answer")
    effects = as_typed(found["findings"])
    told(["sym2real", "add", "crazyflie", *effects, "--out", str(folder / "informed")], folder / "added")
    second = flown(str(folder / "informed"), "flight_2", folder, options)
    named = [one for one in found["findings"] if {one["effect"], *one["group"]} >= GROUP]
    return [
        Figure("verdict EFFECT", found["verdict"] == "EFFECT", "", ">= 1"),
        Figure("finding that names the group of mass and thrust map", len(named), "", ">= 1"),
        Figure("part of the excess error that it explains", sum(one["share"] for one in named), ""),
        Figure("further findings", len(found["findings"]) - len(named), ""),
        Figure("position 1 s ahead on the first flight, off by", _ahead(before), "m"),
        Figure("the same with what was added, on the second", _ahead(second["comparison"]), "m"),
        Figure("mean position error of the first flight", first["tracking"], "m"),
        Figure("of the second", second["tracking"], "m"),
        Figure("it falls by", 1.0 - second["tracking"] / first["tracking"], "", ">= 0.6"),
        Figure("periods missed in both", first["missed"] + second["missed"], f"of {round(100 * options.seconds)}"),
    ]


def _ahead(comparison: Mapping[str, Any]) -> float:
    (position,) = (row["errors"]["position"]["value"] for row in comparison["horizons"] if row["horizon"] == 1.0)
    return float(position)


def main(options: Options) -> None:
    """Print the table; write the figures."""
    with tempfile.TemporaryDirectory() as name:
        folder = options.out or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        figures = story(folder, options)
    report("Two flights and a diagnosis", figures, [options.seed], options.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
