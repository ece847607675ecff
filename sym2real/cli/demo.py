"""``sym2real demo``: the whole path on both robots, and what a model is missing in simulated and real flights."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sym2real.cli.numbers import OptionalSamples, Seed
from sym2real.cli.positionals import JsonFile
from sym2real.cli.terminal import Report

SHOWN = ("crazyflie", "mushr")
STEPS = 400
SECONDS = 5.0


@dataclass(frozen=True)
class Demo:
    """Learn, fly, compare, diagnose: both robots from their description files, then what a model is missing.

    The last two acts are the package's main story, on simulated flights with an effect that the seed draws and on a
    real flight. Everything that is printed is also written under OUT: models, logs (CSV), figures (PNG).
    """

    out: Path = Path("runs/demo")
    """Folder for models, logs and figures."""
    samples: OptionalSamples = None
    seed: Seed = 0
    """Of starts, commands, disturbances and samples."""
    json: JsonFile = None

    def run(self, console: Report) -> dict[str, Any]:
        """Run the four acts."""
        from sym2real.cli.story import Story

        started = time.perf_counter()
        robots = {}
        for name in SHOWN:
            robots[name] = self._robot(name, console)
            console.release()  # what an act says stands beside files that are written
        story = Story(self.out, self.samples, self.seed, SECONDS)
        hidden = story.simulated(self.out / "crazyflie" / "model", console)
        console.release()
        real = story.real(console)
        seconds = time.perf_counter() - started
        console.print(f"\neverything is in {self.out}; {seconds:.0f} s", markup=False)
        return {"robots": robots, "hidden_effect": hidden, "real_flight": real, "seconds": seconds}

    def _robot(self, name: str, console: Report) -> dict[str, Any]:
        """Learn its base and fly it, by the verbs a user types."""
        from sym2real.cli.learn import Learn
        from sym2real.cli.run import Run
        from sym2real.robots import ROBOTS

        robot, out = ROBOTS[name], self.out / name
        console.rule(f"{robot.title}: from description file to equations")
        shared: dict[str, Any] = {"samples": self.samples, "seed": self.seed}
        learn = Learn(name, out / "model", episodes=robot.recipe.episodes, steps=STEPS, **shared)
        learned = learn.run(console)
        flights = [
            Run(str(out / "model"), task, seconds=SECONDS, out=out, **shared).run(console)
            for task in dict.fromkeys(task for task, _ in robot.recipe.tasks)
        ]
        return {"model": learned["model"], "nodes": learned["nodes"], "flights": flights}
