"""Equations fitted straight to noisy logs of a target: which dependences get lost, thrust in vz′ above all."""

from collections.abc import Mapping
from dataclasses import dataclass

from sym2real.control import mppi_controller
from sym2real.dataset import Dataset
from sym2real.experiments.models import cached_base
from sym2real.experiments.study.case import Case, load_suite
from sym2real.experiments.study.effort import Effort, OfStudy
from sym2real.experiments.study.outcome import Outcome
from sym2real.experiments.study.sweep import Job, Record, Tell
from sym2real.plants import MujocoPlant, run_episode
from sym2real.regression import BeamSearch, dependence
from sym2real.symbolic import Equations

CASES = ("cf-plain", "car-plain")
TRAJECTORIES = 3
PAPER = "paper: fitted to the robot's logs, the equation of vz′ lost thrust, and the drone could not keep its height"


@dataclass(frozen=True)
class NoisyFit(OfStudy):
    """Equations from logs of a case, as a job of the sweep.

    Args:
        case: target and task.
        clean: fly the plain simulator instead, to compare.
        seed: of the flights.
        effort: of the study.
        base: equations that fly, as JSON.
    """

    case: Case
    clean: bool
    seed: int
    effort: Effort
    base: str

    @property
    def name(self) -> str:
        """Of its file."""
        return f"{'clean' if self.clean else 'noisy'}-{self.case.name}_sr_{self.seed}"

    def run(self, tell: Tell) -> Record:
        """``dependence``: state, action, score and whether it holds."""
        robot, task, base = self.case.of_robot, self.case.of_task(), Equations.from_json(self.base)
        flown = []
        for number in range(TRAJECTORIES):
            tell(f"trajectory {number + 1} of {TRAJECTORIES}")
            seed = 1000 * self.seed + number
            plant = MujocoPlant(robot) if self.clean else self.case.plant(seed)
            controller = mppi_controller(base, robot, task, samples=self.effort.samples[robot.name], seed=seed)
            flown.append(run_episode(plant, controller, task, seed=seed, steps=self.effort.rows))
        transitions = Dataset(flown).transitions()
        tell("fitting")
        fitted = BeamSearch(angles=robot.recipe.angles).fit(transitions)
        rows = dependence(fitted, transitions, robot.recipe.dependencies)
        keys = ("state", "action", "score", "holds", "meaning")
        return {"dependence": [{key: getattr(row, key) for key in keys} for row in rows]}


def noisy_jobs(effort: Effort) -> list[Job]:
    """Both robots with every seed, noisy and clean."""
    cases = [case for case in load_suite("sim2real").cases if case.name in CASES]
    bases = {case.robot: cached_base(case.of_robot).to_json() for case in cases}
    return [
        NoisyFit(case, clean, seed, effort, bases[case.robot])
        for seed in effort.seeds
        for case in cases
        for clean in (True, False)
    ]


def noisy_outcome(effort: Effort, records: Mapping[str, Record]) -> Outcome:
    """Scores of every dependence, from clean logs and from noisy ones, seed by seed."""
    rows = []
    for name in CASES:
        runs = {
            kind: [records[key] for key in (f"{kind}-{name}_sr_{seed}" for seed in effort.seeds) if key in records]
            for kind in ("clean", "noisy")
        }
        if not (runs["clean"] and runs["noisy"]):
            continue
        for place, row in enumerate(runs["clean"][0]["dependence"]):
            cells = [", ".join(_score(run["dependence"][place]) for run in runs[kind]) for kind in ("clean", "noisy")]
            rows.append((name, f"{row['action']} in {row['state']}′", *cells, row["meaning"]))
    columns = ("target", "dependence", "clean logs", "noisy logs", "score")
    return Outcome("Equations fitted straight to noisy logs", columns, tuple(rows), (PAPER, "(lost): below its bar"))


def _score(row: Mapping[str, object]) -> str:
    score = row["score"]
    text = f"{score:.3g}" if isinstance(score, float) else "–"
    return text if row["holds"] else f"{text} (lost)"
