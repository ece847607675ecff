"""The authors' real car: its logs in the order in which they were driven, each predicted after those before it."""

from __future__ import annotations

import math
import os
from pathlib import Path

from figures import Figure

from sym2real.adaptation import Adapting, adapt
from sym2real.experiments.models import cached_base
from sym2real.experiments.study.contestants import CONTESTANTS
from sym2real.experiments.study.effects_first import informing
from sym2real.experiments.study.learners import learner_of
from sym2real.logs import read_logs
from sym2real.robots import MUSHR

BESIDE = Path(__file__).resolve().parents[3] / "shared" / "data"
FOLDER, SEED = "mushr_steering_offset", 1
ASKED = ("sr-nn", "sr-memory", "sr-effect", "sr-effect-memory")


def log_figures() -> list[Figure]:
    """Error of the position predicted 1 s ahead on the next log, after every number of logs; none without the logs."""
    paths = sorted((Path(os.environ.get("SYM2REAL_DATA", BESIDE)) / FOLDER).glob("*.csv"))
    if len(paths) < 2:
        return []
    base, figures = cached_base(MUSHR), []
    logs = [read_logs([path], spec=FOLDER, layouts=base.layouts, dt=base.dt) for path in paths]
    for name in ASKED:
        contestant = CONTESTANTS[name]
        settings = Adapting(rounds=len(logs) - 1, until_settled=False, seed=SEED)
        inform = informing(contestant, MUSHR, ())
        adaptation = adapt(base, logs, None, learner_of(contestant, MUSHR, SEED), settings, robot=MUSHR, inform=inform)
        errors = [report.prediction for report in adaptation.reports]
        said = ", ".join(f"{error:.3f}" for error in errors)
        bar = "<= 0.1" if name == ASKED[-1] else ""
        last = errors[-1] if errors else math.nan
        figures.append(Figure(f"MuSHR logs, 1 s ahead, {contestant.title} (after 0, 1, …: {said})", last, "m", bar))
    return figures
