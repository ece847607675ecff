"""A suite of cases as jobs, and its answers as a table and a figure in the paper's layout."""

from collections.abc import Iterator, Mapping

import numpy as np

from sym2real.experiments.models import cached_base
from sym2real.experiments.study.adapting import Adapted
from sym2real.experiments.study.case import Case, Suite
from sym2real.experiments.study.contestants import CONTESTANTS, Contestant
from sym2real.experiments.study.curves import Curve, Ratio, curve_of, ratio
from sym2real.experiments.study.effort import Effort
from sym2real.experiments.study.judged import Reference, has_reference
from sym2real.experiments.study.outcome import Line, Outcome, Panel
from sym2real.experiments.study.sweep import Job, Record

COLUMNS = (
    "case", "model", "zero-shot, m", "after 1", "after 5", "final", "over MuJoCo", "to 10 %", "crashes", "cost",
)  # fmt: skip


def suite_jobs(suite: Suite, effort: Effort) -> list[Job]:
    """The reference controller on every case, then every contestant with every seed, seed by seed."""
    bases = {robot.name: cached_base(robot).to_json() for robot in {case.of_robot for case in suite.cases}}
    jobs: list[Job] = [
        Adapted(case, contestant, seed, effort, bases[case.robot])
        for seed in effort.seeds
        for case in suite.cases
        for contestant in contestants_of(case, suite, effort)
    ]
    return [*(Reference(case, effort) for case in suite.cases if has_reference(case)), *jobs]


def contestants_of(case: Case, suite: Suite, effort: Effort) -> list[str]:
    """Who is asked on a case: what is dear where the effort allows it, a true effect where there is one."""
    return [
        name
        for name in suite.contestants
        if (CONTESTANTS[name].effects != "true" or case.truth)
        and (effort.everywhere or _cheap(CONTESTANTS[name], case))
    ]


def _cheap(contestant: Contestant, case: Case) -> bool:
    """Whether even a quick study asks a contestant on a case."""
    return contestant.learner != "fine-tune" and (contestant.base == "sr" or case.ensemble)


def suite_outcome(suite: Suite, effort: Effort, records: Mapping[str, Record]) -> Outcome:
    """The table and the figure of the answers that are there."""
    rows: list[tuple[str, ...]] = []
    panels, undecided = [], []
    for case in suite.cases:
        curves = dict(_curves(case, suite, effort, records))
        if not curves:
            continue
        best = reference_errors(records, case)
        title = case.title
        for label, curve in curves.items():
            over = None if best is None else ratio(curve.final, best)
            rows.append((title, label, *_figures(curve, over)))
            title = ""
        panels.append(_panel(case, curves, records))
        undecided += _undecided(case, curves)
    notes = [f"{case.title}, paper: {case.paper}" for case in suite.cases if case.paper]
    return Outcome(
        suite.title,
        COLUMNS,
        tuple(rows),
        (*notes, *undecided, *_not_asked(suite, effort)),
        "trajectories",
        "mean cost of an episode",
        tuple(panels),
    )


def _curves(case: Case, suite: Suite, effort: Effort, records: Mapping[str, Record]) -> Iterator[tuple[str, Curve]]:
    for name in suite.contestants:
        curve = curve_of(records, case.name, name, effort.seeds)
        if curve is not None:
            yield CONTESTANTS[name].title, curve


def reference_errors(records: Mapping[str, Record], case: Case) -> np.ndarray | None:
    """What MPPI with MuJoCo itself as its model reached ``# (episodes,)``; None where it was not asked."""
    record = records.get(Reference.name_of(case))
    return None if record is None else np.array(record["errors"])


def _figures(curve: Curve, over: Ratio | None) -> tuple[str, ...]:
    errors = [part.mean() for part in (curve.zero_shot, curve.after(1), curve.after(min(5, curve.rounds)), curve.final)]
    return (
        *(f"{error:.4f}" for error in errors),
        "–" if over is None else str(over),
        str(curve.trajectories),
        str(int(curve.crashes.sum())),
        f"{curve.costs[:, -3:].mean():.3g}",
    )


def _panel(case: Case, curves: Mapping[str, Curve], records: Mapping[str, Record]) -> Panel:
    lines = {}
    for label, curve in curves.items():
        by_seed = curve.costs.mean(axis=2)
        lines[label] = Line(np.arange(by_seed.shape[1], dtype=np.float64), by_seed.mean(axis=0), by_seed.std(axis=0))
    record = records.get(Reference.name_of(case))
    return Panel(case.title, lines, None if record is None else float(np.mean(record["costs"])), case.paper)


def _undecided(case: Case, curves: Mapping[str, Curve]) -> list[str]:
    """Pairs with SR*+NN that so many seeds do not tell apart."""
    first, *others = curves.items()
    sentences = []
    for label, curve in others:
        compared = ratio(curve.final, first[1].final)
        if compared.undecided(1.0):
            seeds = f"{len(curve.errors)} seed{'s' if len(curve.errors) > 1 else ''}"
            sentences.append(f"{case.title}: {seeds} cannot tell {label} from {first[0]} ({compared} of its error)")
    return sentences


def _not_asked(suite: Suite, effort: Effort) -> list[str]:
    """What only --full asks, and where."""
    notes = []
    for name in suite.contestants:
        contestant = CONTESTANTS[name]
        dear = [case.title for case in suite.cases if not effort.everywhere and not _cheap(contestant, case)]
        if dear:
            where = "everywhere" if len(dear) == len(suite.cases) else ", ".join(dear)
            notes.append(f"{contestant.title} takes --full: {where}")
    return notes
