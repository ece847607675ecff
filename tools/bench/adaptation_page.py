"""The study's results as a page of the docs, written by the bench from the answers that it has kept."""

from collections.abc import Sequence

from adaptation_bars import Bars
from figures import Figure, machine

from sym2real.experiments.study.case import Suite
from sym2real.experiments.study.curves import Curve
from sym2real.experiments.study.suites import reference_errors

CONTESTANTS = {
    "sr-nn": "SR\\*+NN",
    "sr-memory": "SR\\*+memory",
    "sr-effect": "SR\\*+effect",
    "sr-effect-nn": "SR\\*+effect+NN",
}
VERDICTS = {None: "", True: "holds", False: "**missed**"}
PAGE = """# Results of the adaptation study

Written by `python tools/bench/adaptation.py --page docs/adaptation_figures.md`; what the words mean stands in
[adaptation.md](adaptation.md). Seeds {seeds}; {processor}, {cores} cores.

Mean position error of five evaluation episodes in m, mean over as many seeds as were run, for the model that was
given, after one and after five trajectories, and of rounds 8 to 10. "MuJoCo" is MPPI that plans with the target's own
simulator; – where that was not run.

| case | contestant | seeds | zero-shot | after 1 | after 5 | rounds 8–10 | MuJoCo |
|---|---|---:|---:|---:|---:|---:|---:|
{errors}

| figure | value | unit | bar | |
|---|---:|---|---|---|
{bars}
"""


def page(bars: Bars, suites: Sequence[Suite], figures: Sequence[Figure]) -> str:
    """The page as Markdown.

    Args:
        bars: of the answers.
        suites: whose cases are listed, as far as they are answered.
        figures: with their bars.
    """
    about = machine()
    return PAGE.format(
        seeds=", ".join(map(str, bars.effort.seeds)),
        processor=about["processor"],
        cores=about["cores"],
        errors="\n".join(row for suite in suites for row in _rows(bars, suite)),
        bars="\n".join(_bar(figure) for figure in figures),
    )


def _rows(bars: Bars, suite: Suite) -> list[str]:
    rows = []
    for case in suite.cases:
        best = reference_errors(bars.answers, case)
        level = "–" if best is None else f"{best.mean():.4f}"
        for name, words in CONTESTANTS.items():
            if (curve := bars.curve(case, name)) is not None:
                rows.append(f"| {case.title} | {words} | {len(curve.errors)} | {_errors(curve)} | {level} |")
    return rows


def _errors(curve: Curve) -> str:
    parts = (curve.zero_shot, curve.after(1), curve.after(5), curve.final)
    return " | ".join(f"{part.mean():.4f}" for part in parts)


def _bar(figure: Figure) -> str:
    name = figure.name.replace("*", "\\*")
    return f"| {name} | {figure.value:.4g} | {figure.unit} | {figure.bar} | {VERDICTS[figure.holds]} |"
