"""Name the physical effect that a model misses, from logs: stages, each from one frozen value to the next."""

import time
from collections.abc import Collection
from dataclasses import replace
from functools import partial

from sym2real.dataset import Dataset, Logs
from sym2real.diagnosis.answer import Diagnosis, conclude, unscored
from sym2real.diagnosis.design.separation import untested_notes, with_advice
from sym2real.diagnosis.errors.regions import locate
from sym2real.diagnosis.estimate.preparation import Prepared, calibrate_base, estimate_covariance, refine_base
from sym2real.diagnosis.naming import doubts, instead, renamed
from sym2real.diagnosis.question import Examined, Question, check_data
from sym2real.diagnosis.score.finding import Scored, score
from sym2real.diagnosis.score.prediction_refit import refit_for_prediction
from sym2real.diagnosis.search.beam import SearchResult, search
from sym2real.diagnosis.unexplained.explaining import explain_rest
from sym2real.logs.conditions import Region
from sym2real.plants import MujocoPlant
from sym2real.stages import OnProgress, Stages
from sym2real.symbolic import Equations
from sym2real.threads import one_thread

RESCALED = 2  # times that the factor of a command in no known unit is taken from what a search found


def prepare(question: Question, stages: Stages) -> Prepared:
    """A model against checked data, ready for hypotheses.

    Raises:
        ShapeError: when no log is long enough to judge.
    """
    return _prepared(stages.run("checking the data", check_data, question), stages)


def _prepared(examined: Examined, stages: Stages) -> Prepared:
    base = stages.run("calibrating the base", refine_base, examined)
    whitened = stages.run("estimating the covariance of errors", estimate_covariance, base)
    return stages.run("calibrating effects", calibrate_base, whitened)


def _searched(stages: Stages, question: Question) -> tuple[SearchResult, Scored | None]:
    """What a search makes of a question, again where it knows a command's unit better; unscored if interrupted."""
    result = search(prepare(question, stages), stages)
    for _ in range(RESCALED):
        examined = result.prepared.examined
        gains = result.gains(examined.scaled) if examined.scaled and result.finished else {}
        if (exact := examined.rescaled(gains)) is None:
            break
        result = search(_prepared(exact, stages), stages)
    return result, stages.try_to("scoring on held-out data", score, result)


def _answer(stages: Stages, result: SearchResult, scored: Scored | None) -> Diagnosis:
    explained = scored and stages.try_to("explaining what is left", explain_rest, scored)
    return conclude(scored, *explained) if scored and explained else unscored(result)


@one_thread()
def diagnose(
    model: Equations,
    data: Logs,
    plant: MujocoPlant | None = None,
    *,
    calibrate: bool = True,
    held_out: Dataset | None = None,
    exclude: Collection[str] = (),
    horizon: float | None = None,
    region: Region | None = None,
    on_progress: OnProgress = lambda _: None,
    finish_on_interrupt: bool = False,
) -> Diagnosis:
    """Find the effects that a model misses.

    Args:
        model: the base's equations.
        data: logs with the model's columns and time step.
        plant: the robot's plain simulator, to calibrate the base and to try manoeuvres in; without one both are
            skipped. Effects that the model has already (``Equations.effects``) are put into it here.
        calibrate: whether the simulator calibrates the base.
        held_out: logs that score the ladder; by default every log by the fit without it, the last third of a single
            log by the fit to the rest.
        exclude: keys or patterns of effects that do not compete.
        horizon: the ladder's longest, in s.
        region: range of every column in the model's training, to say whether it fails inside or outside.
        on_progress: called with what is being done.
        finish_on_interrupt: Ctrl-C during the search, or behind it, ends the stage that runs, and the answer is made
            of what is done.

    Raises:
        ShapeError: when no log is long enough, columns differ, or the horizon is no step long.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> model, task = robot.nominal(), make_task("circle", robot)
        >>> target = MujocoPlant(robot, [effect("offset:steer", robot).inject(value=0.05)])
        >>> log = run_episode(target, MPPI(compile_model(model), robot, task), task, steps=100)
        >>> found = diagnose(model, log, exclude=["sensor_*", "*:speed"])
        >>> found.verdict, found.findings[0].provisional  # five seconds leave too few independent pieces for a test
        ('CANNOT_TELL', True)
    """
    started, stages = time.perf_counter(), Stages(on_progress, finish=finish_on_interrupt)
    result, scored = _searched(stages, Question(model, data, plant, calibrate, held_out, exclude, horizon=horizon))
    answer = _answer(stages, result, scored)
    for doubt in doubts(answer, result.prepared.library.base, result.prepared.checked.data):
        others = partial(instead, scored, partial(_searched, stages))
        if better := stages.try_to("trying what else may be in the place of what is in doubt", others, doubt):
            result, scored = better.result, better
            answer = renamed(_answer(stages, result, scored), exclude)
    prepared = result.prepared
    if scored and answer.established:
        answer = replace(answer, prediction=stages.try_to("refitting for prediction", refit_for_prediction, scored))
    advise = partial(with_advice, equations=prepared.model, whitening=prepared.whitening, plant=prepared.plant)
    findings = stages.try_to("looking for manoeuvres that would tell more", advise, answer.findings)
    where = stages.try_to("locating errors", partial(locate, prepared.model, region=region), prepared.checked.data)
    return replace(
        answer,
        findings=answer.findings if findings is None else findings,
        where=where or (),
        notes=(*answer.notes, *untested_notes(answer.findings, prepared.model, prepared.plant), *stages.notes),
        seconds=time.perf_counter() - started,
    )
