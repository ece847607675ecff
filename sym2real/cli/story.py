"""The story that ``sym2real demo`` ends with: compare, diagnose, fly what was found; by the verbs a user types."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from sym2real.cli.add import Add
from sym2real.cli.compare import Compare
from sym2real.cli.diagnose import Diagnose
from sym2real.cli.nominal import NominalQuadrotor
from sym2real.cli.progress import stages_progress
from sym2real.cli.run import Run
from sym2real.data import example_flight
from sym2real.experiments.learning import training_tasks
from sym2real.experiments.noisy_runs import HIDDEN, noisy_runs
from sym2real.logs import write_log
from sym2real.robots import CRAZYFLIE

FLIGHTS, KEPT, ROWS = 6, 2, 300
TASK = "circle"
SPEC = "crazyflie_battery_drag"


@dataclass(frozen=True)
class Story:
    """What is missing in a simulated robot, whose hidden effect the seed draws, and in a real one.

    Args:
        out: folder.
        samples: of MPPI; None for the robot's own number.
        seed: of the effect, the flights' noise, and the samples.
        seconds: of a flight with MPPI.
    """

    out: Path
    samples: int | None
    seed: int
    seconds: float

    def simulated(self, model: Path, console: Console) -> dict[str, Any]:
        """The learned quadrotor against a plant with an effect that nothing in the logs names."""
        console.rule("A hidden effect: which one, how much, and does it help to know?")
        key, values = HIDDEN[int(np.random.default_rng(self.seed).integers(len(HIDDEN)))]
        out = self.out / "hidden"
        with stages_progress() as on_progress:
            on_progress("flying the changed robot")
            flights = noisy_runs(
                CRAZYFLIE, training_tasks(CRAZYFLIE), [(key, values)], count=FLIGHTS, rows=ROWS, seed=self.seed
            )
            logs = {out / "logs" / f"{flight.name}.csv": flight for flight in flights}
        for log, trajectory in logs.items():
            write_log(trajectory, log)
        used, kept = [*logs][:-KEPT], [*logs][-KEPT:]
        compared = self._compare(model, used, None, out / "compare", console)
        found = self._diagnose(model, used, kept, None, out, console)
        typed = (key, *(f"{name}={value}" for name, value in values.items()))
        console.print(f"the hidden effect was {' '.join(typed)}", markup=False, style="bold")
        Add(str(model), typed, out / "truth").run(console)
        models = {"base": model, "with what was found": out / "model", "that knows the truth": out / "truth"}
        closed_loop, plant = {}, str(out / "truth" / "simulator")
        for label, folder in models.items():
            if folder.is_dir():
                _say(f"run {folder} {TASK} --plant {plant}", None, console)
                flight = Run(str(folder), TASK, plant, seconds=self.seconds, samples=self.samples, seed=self.seed)
                closed_loop[label] = flight.run(console)["tracking"]
        truth = [{"effect": key, "values": values}]
        return {"truth": truth, "compared": compared, "diagnosis": found, "closed_loop": closed_loop}

    def real(self, console: Console) -> dict[str, Any]:
        """First-principles equations at motor level against the log of a real Crazyflie."""
        console.rule("A real Crazyflie: first-principles equations at motor level against its log")
        folder, logs = self.out / "real_flight", [example_flight()]
        nominal = NominalQuadrotor(
            folder / "nominal", interface="motors", attitude="measured", fit_thrust=logs[0], spec=SPEC
        )
        nominal.run(console)
        compared = self._compare(folder / "nominal", logs, SPEC, folder / "compare", console)
        found = self._diagnose(folder / "nominal", logs, [], SPEC, folder, console)
        return {"compared": compared, "diagnosis": found}

    @staticmethod
    def _compare(model: Path, logs: Sequence[Path], spec: str | None, out: Path, console: Console) -> dict[str, Any]:
        _say(f"compare {model} {_names(logs)}", spec, console)
        return Compare(str(model), tuple(logs), spec=spec, out=out).run(console)

    @staticmethod
    def _diagnose(  # noqa: PLR0917 — the verb's own options
        model: Path, logs: Sequence[Path], kept: Sequence[Path], spec: str | None, out: Path, console: Console
    ) -> dict[str, Any]:
        _say(f"diagnose {model} {_names(logs)}" + (f" --held-out {_names(kept)}" if kept else ""), spec, console)
        return Diagnose(str(model), tuple(logs), held_out=tuple(kept), spec=spec, out=out).run(console)


def _say(command: str, spec: str | None, console: Console) -> None:
    options = f" --spec {spec}" if spec else ""
    console.print(f"\n$ sym2real {command}{options}", style="bold cyan", markup=False, soft_wrap=True)


def _names(logs: Sequence[Path]) -> str:
    return " ".join(map(str, logs))
