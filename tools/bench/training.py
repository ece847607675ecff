"""Training on 400 rows: processor seconds of a round, and what is left of the base's error on another flight or drive.

Logs come from the plain simulator with one effect, flown by geometric controllers, with and without sensor noise; the
loss follows one step or ten; beside them the base's own constants, fine-tuned. Errors are of positions 0.8 s (car: 1 s)
ahead, on an exact log of another task.

    python tools/bench/training.py --json build/training.json
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from answers import error_ahead
from figures import Figure, report

from sym2real.adaptation.fine_tuning import FineTuning
from sym2real.control import geometric_controller
from sym2real.dataset import Dataset
from sym2real.effects import effect
from sym2real.experiments.standard_conditions import sensors
from sym2real.neural import Composed, ResidualTraining
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.tasks import make_task
from sym2real.trajectory import Trajectory

ROWS, BAR = 400, "<= 10"
# Robot, effect, its values, task of the training, task of the test, horizon in s.
CASES: tuple[tuple[Robot, str, dict[str, float], str, str, float], ...] = (
    (CRAZYFLIE, "added_mass", {"value": 0.007}, "circle", "lemniscate", 0.8),
    (CRAZYFLIE, "wind", {"fx": 0.02, "fy": 0.01}, "circle", "lemniscate", 0.8),
    (MUSHR, "offset:steer", {"value": 0.1}, "circle", "circle", 1.0),
)


@dataclass(frozen=True)
class Options:
    """Time the training of a residual, and score it.

    Args:
        seed: of starts, noise and training.
        json: write the figures to this file (- is standard output).
    """

    seed: int = 0
    json: Path | None = None


def flown(robot: Robot, changes: tuple[Any, ...], task: str, seed: int) -> Trajectory:
    """A log of a task."""
    wanted = make_task(task, robot)
    controller = geometric_controller(robot, wanted.reference)
    return run_episode(MujocoPlant(robot, changes), controller, wanted, seed=seed, steps=ROWS + 1)


def main(options: Options) -> None:
    """Measure every case."""
    figures = []
    for robot, key, values, task, test, seconds in CASES:
        change, base = effect(key, robot).inject(**values), robot.nominal()
        other = flown(robot, (change,), test, options.seed + 1)
        alone = error_ahead(base, other, seconds)
        for noisy in (False, True):
            kind = "noisy" if noisy else "exact"
            noise = (sensors(robot, np.random.default_rng(options.seed)),) if noisy else ()
            rows = Dataset([flown(robot, (*noise, change), task, options.seed)]).transitions()
            for steps in (1, 10):
                began = time.process_time()
                model: Composed = ResidualTraining(steps=steps, seed=options.seed).fit(rows, base)
                spent = time.process_time() - began
                name = f"{robot.name}, {key}, {kind} log, loss over {steps}"
                figures.append(Figure(f"{name}: training", spent, "s of one processor", BAR))
                figures.append(
                    Figure(f"{name}: error over the base's", error_ahead(model, other, seconds) / alone, "1")
                )
            tuned, name = FineTuning(seed=options.seed).fit(rows, base), f"{robot.name}, {key}, {kind} log, fine-tuned"
            left = error_ahead(tuned, other, seconds) / alone
            figures.append(Figure(f"{name}: error over the base's", left, "1"))
    report("Training of a residual on 400 rows", figures, [options.seed], options.json)


if __name__ == "__main__":
    main(tyro.cli(Options))
