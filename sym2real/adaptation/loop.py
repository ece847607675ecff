"""Stages II and III of the paper: an episode in the target with the present model → train → repeat.

The model of round k was trained on the logs of the rounds before and flies log k, so that every log is held out to the
model that flew it, and to all before. On it the newest model is held against the best one so far. The run ends when two
rounds in a row have brought no improvement beyond its interval (:mod:`sym2real.adaptation.paired_gain`). Round 0 is the
model that was given, zero-shot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, is_dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sym2real.adaptation.paired_gain import Improvement, improvement
from sym2real.adaptation.predictions import STRIDE, horizon_errors, in_shares, one_step_error
from sym2real.adaptation.progress import OnProgress, Progress, silent
from sym2real.adaptation.round_report import Learned, RoundReport, best_of, settled
from sym2real.adaptation.rounds import Rounds
from sym2real.adaptation.target import Flights, MakeController, Recordings, Target, reference_errors
from sym2real.adaptation.training import Inform, Training, digest_of
from sym2real.control import mppi_controller
from sym2real.dataset import Dataset, logs_in
from sym2real.errors import ModelError
from sym2real.layout import unit_of_place
from sym2real.logs.equal_steps import equal_steps
from sym2real.neural.model_folder import Model
from sym2real.protocols import Learner, Plant
from sym2real.robots import Robot
from sym2real.tasks import Task
from sym2real.trajectory import Trajectory, require_finite
from sym2real.upward import upward

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HORIZON = 0.8  # s, over which predictions are scored where no MPPI flies, as a diagnosis judges them


@dataclass(frozen=True)
class Adapting:
    """How the loop runs.

    Args:
        rounds: at most so many trajectories are learned from; one more tests the last model.
        steps: control steps an episode at most (paper: 400).
        samples: MPPI samples; the robot's own number by default.
        until_settled: stop before ``rounds`` when another trajectory brings no improvement.
        seed: of starts, MPPI's noise and the plant.

    Raises:
        ModelError: without a round, or with an episode too short to learn from.

    Examples:
        >>> Adapting(rounds=3, steps=200).until_settled
        True
    """

    rounds: int = 10
    steps: int = 400
    samples: int | None = None
    until_settled: bool = True
    seed: int = 0

    def __post_init__(self) -> None:
        if self.rounds < 1 or self.steps < 2:
            raise ModelError(
                f"adapting needs at least one round of two steps, found {self.rounds} rounds of {self.steps}"
            )


@dataclass(frozen=True)
class Adaptation:
    """What an adaptation has led to.

    Args:
        models: of every round; the first is the one that was given.
        logs: of every round.
        reports: of every round.
    """

    models: tuple[Model, ...]
    logs: tuple[Dataset, ...]
    reports: tuple[RoundReport, ...]

    @property
    def best(self) -> int:
        """Number of the round whose model is the best."""
        return best_of(self.reports)

    @property
    def model(self) -> Model:
        """The best model."""
        return self.models[self.best]

    @property
    def settled(self) -> bool:
        """Whether further trajectories brought no improvement."""
        return settled(self.reports)

    def plot(self) -> Figure:
        """Error of the episodes and of the predictions by round: a figure of matplotlib."""
        return upward("adaptation_plot")(self)


def adapt(
    base: Model,
    target: Plant | Sequence[Dataset | Trajectory],
    task: Task | None,
    learner: Learner[Any, Any],
    settings: Adapting | None = None,
    *,
    robot: Robot | None = None,
    inform: Inform | None = None,
    folder: Path | None = None,
    on_progress: OnProgress = silent,
    controller: MakeController | None = None,
) -> Adaptation:
    """Adapt a model to a target, one trajectory at a time.

    Args:
        base: equations, or any model; it is never changed.
        target: a plant to fly in, or recordings, one a round, with which nothing flies: training uses the first k and
            recording k + 1 is scored. They are cut at gaps, and brought to equal steps.
        task: what is flown; None with recordings.
        learner: trains what the base leaves.
        settings: of the loop.
        robot: gives limits and MPPI's sampling; the plant's own by default. Without one, nothing is known of limits.
        inform: gives equations with what the logs establish in them; the learner then trains on those.
        folder: keeps every round as it happens; a second call continues there.
        on_progress: told of every control step and every finished round.
        controller: makes what flies a model; MPPI by default.

    Raises:
        ModelError: without a task to fly, with fewer than two recordings, or when the folder holds another run.
        ShapeError: for a recording with values that are no finite number.
        DataError: when what the folder holds cannot be read, or nothing can be written there.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> model, task = robot.nominal(), make_task("circle", robot)
        >>> target = MujocoPlant(robot, [effect("offset:steer", robot).inject(value=0.05)])
        >>> learner, settings = ResidualTraining(widths=(8,), steps=2, penalties=(0.1,)), Adapting(rounds=1, steps=60)
        >>> adapted = adapt(model, target, task, learner, settings)
        >>> len(adapted.models), adapted.best in (0, 1)
        (2, True)
    """
    settings = settings or Adapting()
    robot = robot or getattr(target, "robot", None)
    source = source_of(target, task, robot, settings, on_progress, controller=controller)
    rounds = Rounds(folder, source.layouts)
    rounds.claim(  # what tells a run from another; with more rounds than before it is continued
        {
            "model": digest_of(base),
            "learner": repr(learner) if is_dataclass(learner) else type(learner).__name__,
            "diagnose": inform is not None,
            "seed": settings.seed,
            **source.about,
        }
    )
    training = Training(learner, inform, robot, settings.seed, on_progress)
    return _Loop(base, source, robot, training, settings, rounds, on_progress).run()


def source_of(
    target: Plant | Sequence[Dataset | Trajectory],
    task: Task | None,
    robot: Robot | None,
    settings: Adapting,
    on_progress: OnProgress,
    *,
    controller: MakeController | None = None,
) -> Target:
    """Where logs come from; arguments and errors as of :func:`adapt`."""
    if isinstance(target, Sequence):
        if len(target) < 2:
            raise ModelError(f"expected at least two logs, one to learn from and one that scores, found {len(target)}")
        recordings = tuple(_at_equal_steps(recording, robot) for recording in target)
        if all(recording.rows < 2 for recording in recordings):
            raise ModelError("expected logs of at least two rows, found none")
        return Recordings(recordings)
    if task is None or robot is None:
        raise ModelError("expected a robot and a task to fly in a plant")
    made = controller or mppi_controller
    return Flights(target, robot, task, settings.steps, settings.samples, settings.seed, on_progress, made)


def _at_equal_steps(recording: Dataset | Trajectory, robot: Robot | None) -> Dataset:
    """The pieces of a recording; a single row between two gaps is none, as no step follows it."""
    dt, pieces = robot.dt if robot else None, list[Trajectory]()
    for log in logs_in(recording):
        require_finite(log)
        pieces += equal_steps(log, dt)
    return Dataset([piece for piece in pieces if len(piece) > 1] or pieces)


@dataclass(frozen=True)
class _Loop:
    base: Model
    target: Target
    robot: Robot | None
    training: Training
    settings: Adapting
    rounds: Rounds
    on_progress: OnProgress

    def run(self) -> Adaptation:
        """Rounds until nothing gets better; errors as of :func:`adapt`."""
        models: list[Model] = []
        logs: list[Dataset] = []
        reports: list[RoundReport] = []
        for number in range(int(min(self.settings.rounds + 1, self.target.logs))):
            model, how = self.rounds.model(number, partial(self.training.learn, self.base, models, reports, logs))
            models.append(model)
            fly = partial(self.target.log, number, model)
            logs.append(fly() if self.target.recorded else self.rounds.log(number, fly))
            reports.append(self.rounds.report(number, partial(self._score, models, logs, reports, how)))
            self.rounds.put_on_top(models[best_of(reports)], reports)
            self.on_progress(Progress("rounds", number + 1, self.settings.rounds + 1, reports[-1]))
            if self.settings.until_settled and settled(reports):
                break
        return Adaptation(tuple(models), tuple(logs), tuple(reports))

    def _score(
        self, models: Sequence[Model], logs: Sequence[Dataset], reports: Sequence[RoundReport], how: Learned
    ) -> RoundReport:
        number, model, log = len(reports), models[-1], logs[-1]
        horizon = HORIZON if self.robot is None or self.target.recorded else self.robot.mppi.horizon
        steps = round(horizon / self.target.dt)
        errors, best = horizon_errors(model, log, steps), best_of(reports) if reports else 0
        gain = tracking = Improvement()
        if number and not how.refused:
            earlier = horizon_errors(models[best], log, steps)
            before, after = in_shares(earlier, earlier), in_shares(errors, earlier)
            gain = improvement(before, after, round(horizon / STRIDE))
        if number and not how.refused and not self.target.recorded and logs[best].rows == log.rows:
            tracking = improvement(reference_errors(logs[best]), reference_errors(log), steps)
        crashed, error, cost = self.target.judged(log)
        return RoundReport(
            number=number,
            log=log[0].name,
            rows=log.rows,
            flown=not self.target.recorded,
            crashed=crashed,
            error=error,
            cost=cost,
            one_step=one_step_error(model, log),
            horizon=horizon,
            prediction=float(np.linalg.norm(errors, axis=1).mean()) if len(errors) else float("nan"),
            best_before=best,
            best_crashed=number > 0 and reports[best].crashed,
            gain=gain,
            tracking=tracking,
            learned=how,
            unit=unit_of_place(log.layouts.state),
        )
