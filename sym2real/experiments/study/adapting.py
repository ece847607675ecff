"""One contestant adapts to one case with one seed: ten rounds, each of whose models is judged in the same episodes."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from torch import nn

from sym2real.adaptation import Adaptation, Adapting, Progress, adapt
from sym2real.experiments.learners import make_learner
from sym2real.experiments.study.case import Case
from sym2real.experiments.study.contestants import CONTESTANTS, informing
from sym2real.experiments.study.effort import Effort, OfStudy
from sym2real.experiments.study.judged import Judged, judge, planning_with
from sym2real.experiments.study.neural_base import cached_ensemble
from sym2real.experiments.study.sweep import Record, Tell
from sym2real.symbolic import Equations


@dataclass(frozen=True)
class Adapted(OfStudy):
    """An adaptation as a :class:`~sym2real.experiments.study.sweep.Job`.

    Args:
        case: target and task.
        contestant: key of :data:`~sym2real.experiments.study.contestants.CONTESTANTS`.
        seed: of the run.
        effort: of the study.
        base: the equations that it begins with, as JSON, so that all begin alike wherever they run.
    """

    NAME = "{case.name}_{contestant}_{seed}"

    case: Case
    contestant: str
    seed: int
    effort: Effort
    base: str

    def run(self, tell: Tell) -> Record:
        """``rounds``, one row each: how it was judged, and how its model came about."""
        began = time.perf_counter()
        adaptation = self._adapt(tell)
        adapted = time.perf_counter() - began
        judged = self._judged(adaptation, tell)
        rounds = [
            {
                **outcome._asdict(),
                "flown": report.error,
                "crashed": report.crashed,
                "prediction": report.prediction,
                "effects": list(report.learned.effects),
                "refused": report.learned.refused,
                "learning": report.learned.seconds,
            }
            for outcome, report in zip(judged, adaptation.reports, strict=True)
        ]
        spent = {"adapting": adapted, "judging": time.perf_counter() - began - adapted}
        return {"rounds": rounds, "best": adaptation.best, "spent": spent}

    def _adapt(self, tell: Tell) -> Adaptation:
        contestant, robot = CONTESTANTS[self.contestant], self.case.of_robot
        equations = Equations.from_json(self.base)
        settings = Adapting(
            rounds=self.effort.rounds,
            steps=self.effort.rows,
            samples=self.effort.samples[robot.name],
            until_settled=False,
            seed=self.seed,
        )
        return adapt(
            equations if contestant.base == "sr" else cached_ensemble(robot, self.effort),
            self.case.plant(self.seed),
            self.case.of_task(),
            make_learner(contestant.learner, self.seed, memory=contestant.commands, angles=robot.recipe.angles),
            settings,
            inform=informing(contestant, robot, self.case.truth, tell),
            on_progress=_lines(tell),
        )

    def _judged(self, adaptation: Adaptation, tell: Tell) -> list[Judged]:
        """Of every round's model; one that is that of the round before is judged as that."""
        judged: list[Judged] = []
        before: Equations | nn.Module | None = None
        for number, model in enumerate(adaptation.models):
            message = f"round {number} of {self.effort.rounds}"
            make = planning_with(model, self.effort)
            judged.append(judged[-1] if model is before else judge(self.case, make, self.effort, _named(tell, message)))
            before = model
        return judged


def _named(tell: Tell, first: str) -> Tell:
    return lambda text: tell(f"{first}: {text}")


def _lines(tell: Tell) -> Callable[[Progress], None]:
    """The loop's progress as lines; not of every single step."""

    def show(progress: Progress) -> None:
        if progress.done in (0, 1) or progress.report is not None:
            tell(progress.what)

    return show
