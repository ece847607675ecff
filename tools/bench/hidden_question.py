"""One question of the hidden-effect benchmark and its answer: a module of its own, which other processes import."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import torch
from answers import HORIZON, answer_of
from hidden_scores import Record
from hidden_truth import error_of_the_truth
from standard_set import Case, simulate_case

from sym2real.diagnosis import diagnose
from sym2real.effects import effect
from sym2real.plants import MujocoPlant
from sym2real.robots import ROBOTS
from sym2real.symbolic import Equations


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
    def name(self) -> str:
        """Key in the results file."""
        return f"{self.kind}: {self.case.name}" + (f" without {self.exclude[0]}" if self.kind == "half" else "")

    @property
    def alike(self) -> object:
        """Same for questions that differ by their seed alone, and by the axes that it draws."""
        sizes = [sorted(round(abs(value), 9) for value in values.values()) for _, values in self.case.effects]
        return (self.kind, self.case.robot, self.case.keys, self.exclude, str(sizes), self.case.yaw)


@lru_cache(maxsize=2)
def _equations(base: str) -> Equations:
    """One object per text, so that what is compiled from it is kept."""
    return Equations.from_json(base)


def answer(question: Question, base: str) -> Record:
    """One case simulated and diagnosed."""
    torch.set_num_threads(1)
    case, robot = question.case, ROBOTS[question.case.robot]
    equations, data = _equations(base), simulate_case(case)
    found = diagnose(equations, data, MujocoPlant(robot), exclude=question.exclude)
    return {
        "name": question.name,
        "robot": case.robot,
        "kind": question.kind,
        "yaw": case.yaw,
        "truth": {key: dict(values) for key, values in case.effects},
        "null": {key: effect(key, robot).null for key in case.keys},
        "excluded": list(question.exclude),
        "error_of_truth": error_of_the_truth(case, data, HORIZON) if question.kind == "single" else None,
        **answer_of(found),
    }
