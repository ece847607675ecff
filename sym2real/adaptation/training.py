"""The model of a round: the base, informed or as it is, with what a learner makes of all logs so far."""

import hashlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sym2real.adaptation.model_limits import beyond_limits
from sym2real.adaptation.progress import OnProgress, Progress
from sym2real.adaptation.round_report import Learned, RoundReport, best_of, lost
from sym2real.dataset import Dataset, Transitions
from sym2real.effects.inputs import with_inputs
from sym2real.errors import ModelError
from sym2real.neural.composed import Base
from sym2real.neural.model_folder import Model, below, content_of
from sym2real.protocols import Learner
from sym2real.robots import Robot
from sym2real.symbolic import Equations

Inform = Callable[[Dataset, Equations], Equations]


@dataclass(frozen=True)
class Training:
    """How the model of a round is made.

    Args:
        learner: trains what the base leaves.
        inform: puts into equations what logs establish; None leaves them as they are.
        robot: gives the limits that predictions must keep; None for no limits.
        seed: of the commands with which that is checked.
        on_progress: told that learning begins.
    """

    learner: Learner[Any, Any]
    inform: Inform | None
    robot: Robot | None
    seed: int
    on_progress: OnProgress

    def learn(
        self, given: Model, models: Sequence[Model], reports: Sequence[RoundReport], logs: Sequence[Dataset]
    ) -> tuple[Model, Learned]:
        """The model of the next round and how it came about.

        Args:
            given: the model of round 0; what it learned elsewhere is not learned from again.
            models: of the rounds so far.
            reports: of the rounds so far.
            logs: of the rounds so far, all of which are learned from.

        Returns:
            What was trained, or the best model so far with the reason why.
        """
        base = below(given)
        if not models:
            return given, Learned(base=digest_of(base), effects=effects_of(base))
        data = Dataset(piece for log in logs for piece in log)
        if lost(reports):
            return _best(models, reports, data.rows, 0.0, "two models in a row were surely worse than the best")
        number, started = len(models), time.perf_counter()
        self.on_progress(Progress(f"round {number}: learning from {data.rows} rows", 0, 0))
        if self.inform is not None and isinstance(base, Equations):
            base = unless_withdrawn(self.inform(data, base), models, reports)
        digest, before = digest_of(base), reports[-1].learned
        warm = digest == before.base and digest_of(models[-1]) not in (digest, digest_of(given))
        model, penalty, refused = self._trained(data, base, models[-1] if warm and number > 1 else None, below(given))
        seconds = time.perf_counter() - started
        if model is None:
            return _best(models, reports, data.rows, seconds, refused)
        return model, Learned(data.rows, seconds, digest, effects_of(base), penalty)

    def _trained(self, data: Dataset, base: Base, start: Model | None, sound: Base) -> tuple[Model | None, float, str]:
        """What the learner makes of the logs, λ, and why it must not be flown, held against a base that is sound."""
        fit = getattr(self.learner, "fit_reported", None)
        transitions, penalty = _transitions(data, base), float("nan")
        if not len(transitions):
            return None, penalty, "no log has two rows to learn from"
        try:
            if fit is None:
                model = self.learner.fit(transitions, base, start)
            else:
                model, report = fit(transitions, base, start)
                penalty = float("nan") if report.penalty is None else report.penalty
        except ModelError as error:
            return None, penalty, str(error)
        refused = "" if self.robot is None else beyond_limits(model, sound, list(data), self.robot, self.seed)
        return None if refused else model, penalty, refused


def _transitions(data: Dataset, base: Base) -> Transitions:
    """What is learned from, with the inputs of the base: effects may use what logs hold as a further column."""
    inputs = base.layouts.inputs
    return (with_inputs(inputs, data) if isinstance(base, Equations) else data).transitions()


def _best(
    models: Sequence[Model], reports: Sequence[RoundReport], rows: int, seconds: float, refused: str
) -> tuple[Model, Learned]:
    best = best_of(reports)
    return models[best], replace(reports[best].learned, rows=rows, seconds=seconds, refused=refused)


def unless_withdrawn(informed: Equations, models: Sequence[Model], reports: Sequence[RoundReport]) -> Equations:
    """The informed equations, or those of the best round where the same effects have once been surely worse than it.

    One log may support effects that the next one refutes: a set of effects that flew or predicted worse than the best
    model before it, beyond the interval, is not flown again while another set is the best.

    Args:
        informed: what the logs establish now.
        models: of the rounds so far.
        reports: of the rounds so far.
    """
    best = below(models[best_of(reports)])
    withdrawn = {frozenset(report.learned.effects) for report in reports if report.surely_worse}
    wanted = frozenset(effects_of(informed))
    if isinstance(best, Equations) and wanted in withdrawn and wanted != frozenset(effects_of(best)):
        return best
    return informed


def effects_of(model: Model) -> tuple[str, ...]:
    """Keys of the effects that the equations of a model have."""
    return tuple(key for key, _ in model.effects) if isinstance(model, Equations) else ()


def digest_of(model: Model) -> str:
    """What tells a model from another: all that its folder would hold of it."""
    digest = hashlib.sha256()
    for name, content in content_of(model).items():
        digest.update(name.encode() + content)
    return digest.hexdigest()
