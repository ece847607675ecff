"""The authors' real car: after the first 1, 2, … of its logs, how far off a prediction of the last one is.

Errors are those of `sym2real compare`: root mean square of the position 1 s ahead, over windows from every 0.1 s. A
diagnosis has no seed; networks have several.

    python tools/bench/adaptation_logs.py --json build/adaptation_logs.json
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import torch
import tyro
from figures import Figure, report, say
from real_logs import DATA

from sym2real.dataset import Dataset
from sym2real.diagnosis import compare
from sym2real.experiments.learners import make_learner
from sym2real.experiments.models import base_folder, cached_base
from sym2real.experiments.study.contestants import CONTESTANTS, Contestant, informing
from sym2real.logs import read_logs
from sym2real.neural.model_folder import Model
from sym2real.robots import MUSHR
from sym2real.symbolic import Equations

FOLDER, HORIZON, SEEDS = "mushr_steering_offset", 1.0, (1, 2, 3)
ASKED = ("sr-nn", "sr-memory", "sr-effect", "sr-effect-memory")


def log_figures(seeds: Sequence[int] = SEEDS, counts: Sequence[int] = ()) -> list[Figure]:
    """A figure per contestant and number of logs; none, and why, without the logs."""
    folder = DATA / FOLDER
    paths = sorted(folder.glob("*.csv"))
    if len(paths) < 2:
        say(f"MuSHR logs left out: no logs in {folder} (SYM2REAL_DATA names the folder that holds {FOLDER})")
        return []
    if not (base_folder(MUSHR) / "equations.json").exists():
        say(f"the car's base is learned first, and kept in {base_folder(MUSHR)}")
    base = cached_base(MUSHR)
    logs = [read_logs([path], spec=FOLDER, layouts=base.layouts, dt=base.dt, upsample=True) for path in paths]
    figures = [Figure(f"MuSHR logs, base alone on {paths[-1].stem}", error_of(base, logs[-1]), "m")]
    for count in counts or range(1, len(logs)):
        data = Dataset(piece for log in logs[:count] for piece in log)
        figures += answers(
            base, data, logs[-1], seeds, f"MuSHR logs, {count} learned from", last=count + 1 == len(logs)
        )
    return figures


def answers(
    base: Equations, data: Dataset, held_out: Dataset, seeds: Sequence[int], title: str, *, last: bool
) -> Iterator[Figure]:
    """What each contestant makes of some logs; the last has a bar when it has seen all."""
    diagnose = informing(CONTESTANTS["sr-effect"], MUSHR, ())
    informed = base if diagnose is None else diagnose(data, base)
    for name in ASKED:
        contestant = CONTESTANTS[name]
        below = informed if contestant.effects == "diagnosed" else base
        errors = [error_of(model, held_out) for model in models(contestant, below, data, seeds)]
        spread = f" ({', '.join(f'{error:.3f}' for error in errors)})" if len(errors) > 1 else ""
        bar = "<= 0.1" if last and name == ASKED[-1] else ""
        say(f"{title}, {contestant.title}: {np.mean(errors):.3f} m{spread}")
        yield Figure(f"{title}, {contestant.title}{spread}", float(np.mean(errors)), "m", bar)


def models(contestant: Contestant, base: Equations, data: Dataset, seeds: Sequence[int]) -> Iterator[Model]:
    """One per seed of the network; the base alone without one."""
    if contestant.learner == "none":
        yield base
        return
    for seed in seeds:
        yield make_learner(contestant.learner, seed, memory=contestant.commands).fit(data.transitions(), base)


def error_of(model: Model, log: Dataset) -> float:
    """Of the position so far ahead, m."""
    compared = compare(model, log, horizons=(HORIZON,))
    return compared.horizons[0].errors["position"].value


def main(seeds: tuple[int, ...] = SEEDS, counts: tuple[int, ...] = (), json: Path | None = None) -> None:
    """Predict the last of the car's logs.

    Args:
        seeds: of the networks.
        counts: only after so many logs; after 1, 2, … by default.
        json: write the figures to this file (- is standard output).
    """
    torch.set_num_threads(1)
    figures = log_figures(seeds, counts)
    report("MuSHR logs", figures, seeds, json)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
