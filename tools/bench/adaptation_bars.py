"""Bars of the adaptation study, from the answers that its sweeps have kept."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from figures import Figure
from scipy import stats

from sym2real.experiments.study.case import Case, Suite
from sym2real.experiments.study.curves import CONFIDENCE, Curve, Ratio, curve_of, ratio
from sym2real.experiments.study.effort import Effort
from sym2real.experiments.study.scratch import trajectories_to_converge
from sym2real.experiments.study.suites import reference_errors
from sym2real.experiments.study.sweep import Record
from sym2real.robots import ROBOTS
from sym2real.trajectory import Array

Answers = Mapping[str, Record]
FAR = 1.2  # of MuJoCo's own error: a case from which something can be gained
JUDGED = ("sr-nn", "sr-effect", "sr-effect-nn")
SCRATCH_BARS = {"crazyflie": "<= 3", "mushr": "<= 5"}


class Bars:
    """Figures of one effort.

    Args:
        answers: by name.
        effort: of the study.
    """

    def __init__(self, answers: Answers, effort: Effort) -> None:
        self.answers, self.effort = answers, effort

    def curve(self, case: Case, contestant: str) -> Curve | None:
        """What a contestant reached; None where it was not asked."""
        return curve_of(self.answers, case.name, contestant, self.effort.seeds)

    def pairs(self, cases: Iterable[Case], *contestants: str) -> list[tuple[Case, list[Curve]]]:
        """Cases that all of the contestants have answered."""
        found = [(case, [self.curve(case, name) for name in contestants]) for case in cases]
        return [(case, [one for one in curves if one]) for case, curves in found if all(curves)]

    def against_mujoco(self, suite: Suite) -> list[Figure]:
        """SR*+NN in the end over MPPI that plans with MuJoCo itself, and how soon it gets there."""
        figures, needed = [], {}
        for case, (curve,) in self.pairs(suite.cases, "sr-nn"):
            best = reference_errors(self.answers, case)
            if best is None:
                continue
            found = ratio(curve.final, best)
            figures.append(_figure(f"{case.title}: SR*+NN over MuJoCo", found, "<= 1.15"))
            if ratio(curve.zero_shot, best).value > FAR:
                needed[case.title] = curve.trajectories
        if needed:
            said = ", ".join(f"{title} {count}" for title, count in needed.items())
            counts = list(needed.values())
            figures.append(Figure(f"trajectories to 10 %, median ({said})", float(np.median(counts)), "", "<= 3"))
            figures.append(Figure("trajectories to 10 %, worst", max(counts), "", "<= 5"))
        return figures

    def effect_at_once(self, cases: Iterable[Case]) -> list[Figure]:
        """SR*+effect after one trajectory over SR*+NN after five."""
        figures, logs = [], []
        for case, (effect, network) in self.pairs(cases, "sr-effect", "sr-nn"):
            found = ratio(effect.after(1), network.after(5))
            logs.append(np.log(found.value))
            figures.append(_figure(f"{case.title}: SR*+effect after 1 over SR*+NN after 5", found, "<= 1.05"))
        if logs:
            figures.append(Figure("the same in the geometric mean", float(np.exp(np.mean(logs))), "ratio", "< 1"))
        return figures

    def no_harm(self, cases: Iterable[Case]) -> list[Figure]:
        """SR*+effect+NN over SR*+NN where no effect covers what differs."""
        return [
            _figure(f"{case.title}: SR*+effect+NN over SR*+NN", ratio(both.final, network.final), "<= 1.05")
            for case, (both, network) in self.pairs(cases, "sr-effect-nn", "sr-nn")
        ]

    def safety(self, cases: Sequence[Case]) -> list[Figure]:
        """Crashes behind the first round, and runs that ended surely worse than they began."""
        curves = [(case, name, curve) for name in JUDGED for case, (curve,) in self.pairs(cases, name)]
        if not curves:
            return []
        crashes = sum(int(curve.crashes[:, 2:].sum()) for _, _, curve in curves)
        worse = [f"{case.title} {name}" for case, name, curve in curves if surely_above(curve.final, curve.zero_shot)]
        said = f" ({', '.join(worse)})" if worse else ""
        figures = [
            Figure(f"crashes behind the first round, {len(curves)} cases × contestants", crashes, "", "<= 0"),
            Figure(f"surely worse than zero-shot{said}", len(worse), "", "<= 0"),
        ]
        for case, (curve,) in self.pairs(cases, JUDGED[0]):
            best = reference_errors(self.answers, case)
            if best is not None and ratio(best, curve.zero_shot).value > 1.0:
                over = ratio(best, curve.zero_shot).value
                figures.append(Figure(f"{case.title}: MuJoCo's own over zero-shot", over, "ratio"))
        return figures

    def delay(self, suite: Suite) -> list[Figure]:
        """The late car: a residual that sees past commands, and the effect, over the memoryless residual."""
        figures = []
        for other, bar in (("sr-memory", "<= 0.5"), ("sr-effect", "<= 0.3")):
            for case, (curve, memoryless) in self.pairs(suite.cases, other, "sr-nn"):
                found = ratio(curve.final, memoryless.final)
                figures.append(_figure(f"{case.title}: {other} over sr-nn", found, bar))
        for case, (memoryless,) in self.pairs(suite.cases, "sr-nn"):
            best = reference_errors(self.answers, case)
            if best is not None:
                figures.append(Figure(f"{case.title}: MuJoCo's own", ratio(best, memoryless.final).value, "ratio"))
        return figures

    def scratch(self) -> list[Figure]:
        """Trajectories that equations take from nothing, the worst of the seeds."""
        figures = []
        for robot, bar in SCRATCH_BARS.items():
            runs = [self.answers.get(f"scratch-{robot}_sr_{seed}") for seed in self.effort.seeds]
            counts = [trajectories_to_converge(np.array(run["errors"]).mean(axis=1)) for run in runs if run]
            if counts:
                said = ", ".join(map(str, counts))
                name = f"{ROBOTS[robot].title} from scratch, SR: trajectories to 110 % (seeds: {said})"
                figures.append(Figure(name, max(counts), "", bar))
        return figures

    def training(self) -> list[Figure]:
        """The longest training on the 400 rows of a first round."""
        names = [name for name in self.answers if "_sr-nn_" in name]
        seconds = [self.answers[name]["rounds"][1]["learning"] for name in names]
        return [Figure("training on 400 rows, longest", max(seconds), "s", "<= 10")] if seconds else []


def surely_above(first: Array, second: Array) -> bool:
    """Whether errors are larger in the mean, beyond the 95 % interval of their paired differences.

    Args:
        first, second: ``# (seeds, episodes)``, the same starts and noise in the same places.
    """
    differences = (first - second).ravel()
    if len(differences) < 2:
        return False
    half = float(stats.t.ppf(0.5 + CONFIDENCE / 2, len(differences) - 1)) * stats.sem(differences)
    return bool(differences.mean() - half > 0)


def _figure(name: str, found: Ratio, bar: str) -> Figure:
    """A ratio, with its interval in the name where there is one."""
    _, opened, interval = str(found).partition("(")
    return Figure(f"{name} {opened}{interval or '(one seed)'}", found.value, "ratio", bar)
