"""Search engines side by side: the same flights and drives, more and more of them.

Prints position error 0.8 s ahead in and out of distribution, largest equation, and CPU seconds of the search. PySR
runs where Julia is: ``--engines beam operon pysr``.

    python tools/bench/engines.py --json build/engines.json
"""

import resource
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
import tyro
from base_flown import TEST_SEED, TRAIN_SEED
from base_model import position_errors, spread
from figures import Figure, report, say
from wild_flights import wild_drives, wild_flights

from sym2real.dataset import Dataset
from sym2real.experiments.flights import car_drives, quadrotor_flights
from sym2real.regression import ENGINES
from sym2real.robots import CRAZYFLIE, MUSHR, Robot

COUNTS = (1, 2, 3, 5, 10)
TESTS = 20


def cpu_seconds() -> float:
    """CPU time of this process and of the workers that have ended."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def measured(engine: str, robot: Robot, training: Dataset, tests: tuple[Dataset, Dataset]) -> list[Figure]:
    """Figures of one engine on one training set."""
    say(f"{engine}: {robot.name}, {len(training)} trajectories")
    started = cpu_seconds()
    equations = ENGINES[engine](angles=robot.recipe.angles).fit(training.transitions())
    seconds = cpu_seconds() - started
    inside, outside = (position_errors(equations, test) for test in tests)
    name = f"{engine}, {robot.name}, {len(training)} trajectories"
    return [
        *spread(name, inside),
        Figure(f"{name}: out of distribution, median", float(np.median(outside)), "cm"),
        Figure(f"{name}: largest equation", max(equations.complexity().values()), "nodes"),
        Figure(f"{name}: search", seconds, "CPU s"),
    ]


def main(
    engines: tuple[str, ...] = ("beam", "operon"), counts: tuple[int, ...] = COUNTS, json: Path | None = None
) -> None:
    """Compare the search engines.

    Args:
        engines: engines to run.
        counts: numbers of training trajectories.
        json: write the figures to this file (- is standard output).
    """
    torch.set_num_threads(1)
    kinds: tuple[tuple[Robot, Callable[..., Dataset], Callable[..., Dataset]], ...] = (
        (CRAZYFLIE, quadrotor_flights, wild_flights),
        (MUSHR, car_drives, wild_drives),
    )
    figures: list[Figure] = []
    for robot, fly, wild in kinds:
        tests = (fly(TESTS, TEST_SEED), wild(TESTS, TEST_SEED))
        for engine in engines:
            for count in counts:
                figures += measured(engine, robot, fly(count, TRAIN_SEED), tests)
    report(f"search engines: {', '.join(engines)}", figures, [TRAIN_SEED, TEST_SEED], json)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
