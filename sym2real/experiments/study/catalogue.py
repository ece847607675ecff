"""The experiments of the paper by name: what each shows, its jobs, and what they come to."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from sym2real.errors import ModelError, UnknownNameError
from sym2real.experiments.study.case import load_suite, shipped_suites
from sym2real.experiments.study.effort import Effort
from sym2real.experiments.study.noisy_logs import noisy_jobs, noisy_outcome
from sym2real.experiments.study.outcome import Outcome
from sym2real.experiments.study.policy import policy_jobs, policy_outcome
from sym2real.experiments.study.scratch import scratch_jobs, scratch_outcome
from sym2real.experiments.study.suites import suite_jobs, suite_outcome
from sym2real.experiments.study.sweep import Job, Record
from sym2real.experiments.study.zero_shot import zero_shot_jobs, zero_shot_outcome


@dataclass(frozen=True)
class Experiment:
    """One experiment.

    Args:
        about: what it shows, in a sentence.
        jobs: for an effort.
        outcome: of the answers, for an effort.
    """

    about: str
    jobs: Callable[[Effort], list[Job]]
    outcome: Callable[[Effort, Mapping[str, Record]], Outcome]


EXPERIMENTS = {
    "scratch": Experiment("how many trajectories a base takes from nothing", scratch_jobs, scratch_outcome),
    "zero-shot": Experiment("a base where its training never was", zero_shot_jobs, zero_shot_outcome),
    "noisy-logs": Experiment("equations fitted straight to noisy logs, and what gets lost", noisy_jobs, noisy_outcome),
    "policy": Experiment("a PPO policy beside model-based control (--full)", policy_jobs, policy_outcome),
}


def experiment(name: str, cases: Sequence[str] = (), contestants: Sequence[str] = ()) -> Experiment:
    """The experiment of a name: one of :func:`experiment_names`, or cases of one's own in a TOML file.

    Args:
        name: of the experiment, or a path.
        cases, contestants: only these of a file's; all where none are named.

    Raises:
        UnknownNameError: when there is none, or no such case or contestant.
        ModelError: for cases or contestants of an experiment that has none.
        DataError: when the cases cannot be read.
    """
    if name in EXPERIMENTS:
        if cases or contestants:
            raise ModelError(f"{name} has no cases and contestants to choose from; {', '.join(shipped_suites())} have")
        return EXPERIMENTS[name]
    if name not in shipped_suites() and not name.endswith(".toml"):
        raise UnknownNameError("experiment: neither a file.toml nor", name, experiment_names())
    suite = load_suite(name).only(cases, contestants)
    return Experiment(suite.title, partial(suite_jobs, suite), lambda *given: suite_outcome(suite, *given))


def experiment_names() -> tuple[str, ...]:
    """Everything that comes with the package."""
    return (*shipped_suites(), *EXPERIMENTS)
