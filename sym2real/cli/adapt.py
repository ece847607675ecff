"""``sym2real adapt``: a model that learns from a simulator or from logs what it lacks, one trajectory at a time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from rich.console import Console

from sym2real.cli.numbers import Count, Memory, OptionalSamples, OptionalSeconds, Seed, steps_in
from sym2real.cli.of_logs import OfLogs
from sym2real.cli.positionals import HtmlFile, JsonFile, ModelPlace, OptionalTask, TargetPlace, TaskOptions
from sym2real.errors import ModelError
from sym2real.files import read_object

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sym2real.adaptation import Adaptation, Adapting
    from sym2real.adaptation.progress import OnProgress
    from sym2real.adaptation.training import Inform
    from sym2real.cli.adapt_target import Chosen
    from sym2real.dataset import Dataset
    from sym2real.neural import Model
    from sym2real.protocols import Learner, Plant
    from sym2real.tasks import Task

    Asked = tuple[Model, Plant | Sequence[Dataset], Task | None, Learner[Any, Any], Adapting]

FIGURE = "adaptation"


@dataclass(frozen=True, kw_only=True)
class AdaptVerb(ABC):
    """An ``adapt`` says what its target is, and has these options and its own."""

    model: ModelPlace
    out: Path
    """Folder of the adapted model and of every round."""
    rounds: Count = 10
    """Learn from at most so many trajectories; one more tests the last model."""
    all_rounds: bool = False
    """Go on to the last round, whether it helps or not."""
    seconds: OptionalSeconds = None
    """Length of an episode; the task's own by default."""
    samples: OptionalSamples = None
    learner: Literal["residual", "residual-paper", "residual-search", "fine-tune", "none"] = "residual"
    """What learns on top of the model: a network of 2 × 64 or the paper's 4 × 200, equations, or nothing (with
    --diagnose); fine-tune fits the model's own constants instead."""
    memory: Memory = "auto"
    """Past commands that the network sees, for a delay or a slow actuator: a number, off, or auto, as many as the logs
    ask for, counted behind the effects that --diagnose adds. A delay of 0.2 s in periods of 0.05 s
    asks for 4."""
    diagnose: bool = False
    """Put the physical effects that predict held-out pieces better into the equations first, provisional ones too; each
    round asks anew, with all logs. The learner gets what is left."""
    seed: Seed = 0
    """Of the start, MPPI's samples, noise and first weights."""
    dry_run: bool = False
    """Open and check model and target, say what would be done; fly, learn and write nothing."""
    report: HtmlFile = None
    json: JsonFile = None

    @abstractmethod
    def chosen(self, model: Model, console: Console) -> AbstractContextManager[Chosen]:
        """What to adapt to, open as long as it lasts; errors as of :func:`sym2real.cli.adapt_target.chosen_target`."""

    def run(self, console: Console) -> dict[str, Any]:
        """Adapt, print the table, write the figure."""
        from sym2real.cli.model import open_with_progress, require_another_folder

        require_another_folder(self.model, self.out)
        model = open_with_progress(self.model)
        with self.chosen(model, console) as chosen:
            return self._predicted(model, chosen, console) if self.dry_run else self._adapted(model, chosen, console)

    def _predicted(self, model: Model, chosen: Chosen, console: Console) -> dict[str, Any]:
        self._asked(model, chosen)  # refuses what cannot be, before anything flies
        self._inform(model, lambda _: None)
        most = self.rounds + 1
        if chosen.task is None or chosen.robot is None:
            amount = f"{min(most, len(chosen.target))} of {len(chosen.target)} logs"  # type: ignore[arg-type]
        else:
            seconds = self.seconds or chosen.task.duration
            amount = f"{most} episodes of {seconds:g} s of {chosen.task.name} by a {chosen.robot.title}"
        console.print(f"at most {amount}; nothing was flown, learned or written", markup=False)
        return {"dry_run": f"at most {amount}"}

    def _adapted(self, model: Model, chosen: Chosen, console: Console) -> dict[str, Any]:
        from sym2real.adaptation import adapt
        from sym2real.cli.output import title_of, write_report
        from sym2real.cli.progress import stage_one_progress
        from sym2real.report.html.pages import adaptation_page

        with stage_one_progress() as on_progress:
            adaptation = adapt(
                *self._asked(model, chosen),
                robot=chosen.robot,
                inform=self._inform(model, on_progress),
                folder=self.out,
                on_progress=on_progress,
                controller=chosen.controller,
            )
        result = self._tell(adaptation, console)
        if self.report:
            page = adaptation_page(adaptation, title_of(self.out, "adapted"))
            result["report"] = write_report(page, self.report, console)
        return result

    def _asked(self, model: Model, chosen: Chosen) -> Asked:
        """What distinguishes a run from another."""
        from sym2real.adaptation import Adapting
        from sym2real.experiments.learners import make_learner

        steps = Adapting.steps
        if chosen.task is not None and chosen.robot is not None:
            steps = steps_in(self.seconds or chosen.task.duration, chosen.robot.dt)
        settings = Adapting(
            rounds=self.rounds,
            steps=steps,
            samples=self.samples,
            until_settled=not self.all_rounds,
            seed=self.seed,
        )
        angles = () if chosen.robot is None else chosen.robot.recipe.angles
        learner = make_learner(self.learner, self.seed, memory=self.memory, angles=angles)
        return model, chosen.target, chosen.task, learner, settings

    def _inform(self, model: Model, on_progress: OnProgress) -> Inform | None:
        from sym2real.adaptation import Progress
        from sym2real.cli.results import plain_simulator
        from sym2real.experiments.informing import informing
        from sym2real.neural.model_folder import below
        from sym2real.symbolic import Equations

        if not self.diagnose:
            return None
        base = below(model)
        if not isinstance(base, Equations):
            raise ModelError(f"--diagnose: effects go into equations; {self.model} is made of networks")
        return informing(plain_simulator(base), lambda what: on_progress(Progress(f"diagnosing: {what}", 0, 0)))

    def _tell(self, adapted: Adaptation, console: Console) -> dict[str, Any]:
        """The table and the figure; what ``adaptation.json`` holds and where things are."""
        from sym2real.adaptation.rounds import ANSWER
        from sym2real.report.adaptation import rounds_figure, rounds_report
        from sym2real.report.style import save

        console.print(rounds_report(adapted.reports))
        figure = save(rounds_figure(adapted.reports), self.out, FIGURE)
        console.print(f"model of round {adapted.best}, {ANSWER} and figure in {self.out}", markup=False)
        return read_object(self.out / ANSWER, "an adaptation") | {"model": self.out, "figure": figure}


@dataclass(frozen=True, kw_only=True)
class Adapt(OfLogs, AdaptVerb):
    """Adapt a model to a target: an episode with the present model, training on all so far, and again.

    The model stays frozen, and what is learned goes on top of it, unless its own constants are asked for. The model of
    every round is tested on a trajectory that it has not seen, and compared there with the best one before; the run
    ends by itself when two rounds in a row bring nothing. A model whose predictions leave the robot's limits does not
    fly: the best one so far flies again.

    TARGET is a robot's name (its plain simulator), the folder of a simulator that `add` or `diagnose` wrote, that of a
    model for the plain robot that it is of, or a folder of logs. With logs nothing flies: they come in the order of
    their names, one a round.

    A model that was adapted before flies as it is in round 0; the rounds learn on its equations from their own logs.

    OUT holds the best model, which every verb opens, adaptation.json and a figure, and in rounds/NN the model of every
    round, which they open too, and its log. An interrupted run continues there.

    For example:
      sym2real add runs/base wind fx=0.02 --out runs/windy
      sym2real adapt runs/base runs/windy/simulator circle speed=0.8 --out runs/adapted
      sym2real adapt runs/base flights --spec flight.toml --out runs/adapted
    """

    target: TargetPlace
    """What to adapt to: a robot's name, the folder of a simulator or of a model, or a folder of logs."""
    task: OptionalTask = None
    """What is flown: hover, circle, lemniscate, track, park, reverse_circle or, of any robot, regulate; with logs
    nothing."""
    options: TaskOptions = ()
    noise: bool = False
    """Sensor noise in the simulator, as of `simulate`; without it errors of any size count for --diagnose."""

    def chosen(self, model: Model, console: Console) -> AbstractContextManager[Chosen]:
        """A simulator, or logs."""
        from sym2real.cli.adapt_target import chosen_target
        from sym2real.neural.model_folder import below

        task = () if self.task is None else (self.task, *self.options)
        return nullcontext(
            chosen_target(below(model), self.model, self.target, task, spec=self.naming, noise=self.noise)
        )
