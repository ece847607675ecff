"""One question of the hidden-effect benchmark, and its answer."""

import os
import resource
from dataclasses import dataclass
from functools import partial

from answers import HORIZON, Record, answer_of
from bases import Base
from hidden_truth import error_of_the_truth
from repeated import Asked
from standard_set import Case, simulate_case

from sym2real.diagnosis import diagnose
from sym2real.effects import effect
from sym2real.experiments.study.sweep import Tell
from sym2real.plants import MujocoPlant
from sym2real.robots import ROBOTS


@dataclass(frozen=True)
class Question:
    """A case, and the effects that the diagnosis may not use."""

    case: Case
    exclude: tuple[str, ...] = ()

    @property
    def kind(self) -> str:
        """single, pair or null; removed or half: without the only effect in the library, or without one of two."""
        if self.exclude:
            return ("removed", "half")[len(self.case.effects) - 1]
        return ("null", "single", "pair")[min(len(self.case.effects), 2)]

    @property
    def title(self) -> str:
        """Unlike any other's."""
        return f"{self.kind}: {self.case.name}" + (f" without {self.exclude[0]}" if self.kind == "half" else "")

    @property
    def alike(self) -> object:
        """Same for questions that differ by their seed alone, and by the axes that it draws."""
        sizes = [sorted(round(abs(value), 9) for value in values.values()) for _, values in self.case.effects]
        return (self.kind, self.case.robot, self.case.keys, self.exclude, str(sizes), self.case.yaw)

    def job(self, base: Base) -> Asked:
        """For a sweep."""
        asked = {"case": self.case.name, "seed": self.case.seed, "without": list(self.exclude)}
        return Asked(self.title, asked, partial(self.answer, base))

    def answer(self, base: Base, tell: Tell) -> Record:
        """The case simulated and diagnosed; CPU seconds with those of the compiler, and the process's memory so far."""
        case, robot = self.case, ROBOTS[self.case.robot]
        tell("simulating")
        data, plant, before = simulate_case(case), MujocoPlant(robot), sum(os.times()[:4])
        tell("diagnosing")
        found = diagnose(base.equations, data, plant, exclude=self.exclude)
        cpu, memory = sum(os.times()[:4]) - before, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        return {
            "robot": case.robot,
            "kind": self.kind,
            "yaw": case.yaw,
            "truth": {key: dict(values) for key, values in case.effects},
            "null": {key: effect(key, robot).null for key in case.keys},
            "excluded": list(self.exclude),
            "error_of_truth": error_of_the_truth(case, data, HORIZON) if self.kind == "single" else None,
            **answer_of(found),
            **{"diagnosing": found.seconds, "cpu": cpu, "memory": memory},
        }
