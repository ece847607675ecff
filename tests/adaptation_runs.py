"""Small adaptations that several tests share: a windy quadrotor in MuJoCo, nominal equations, a narrow residual."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from sym2real.adaptation import Adaptation, Adapting, Progress, adapt
from sym2real.effects import effect
from sym2real.neural import Descent, ResidualTraining
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE
from sym2real.tasks import make_task

SMALL = Adapting(rounds=2, steps=200, samples=128, until_settled=False, seed=1)
NARROW = ResidualTraining(widths=(16,), steps=5, penalties=(1e-3, 1e-1), descent=Descent(steps=200))


def windy() -> MujocoPlant:
    """A quadrotor in a wind that its equations do not know, by MuJoCo's own means."""
    return MujocoPlant(CRAZYFLIE, [effect("wind", CRAZYFLIE).inject(fx=0.03, fy=-0.02)])


def adapted_to_wind(folder: Path | None, kill_at: str = "") -> Adaptation:
    """Nominal equations adapted to the wind; the process is killed in the middle of what it then says it does."""

    def watch(progress: Progress) -> None:
        if kill_at and progress.what.startswith(kill_at) and 2 * progress.done >= progress.total:
            os.kill(os.getpid(), signal.SIGKILL)

    task = make_task("circle", CRAZYFLIE)
    return adapt(CRAZYFLIE.nominal(), windy(), task, NARROW, SMALL, folder=folder, on_progress=watch)
