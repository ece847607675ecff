"""What the answers of a diagnosis on the standard set are worth: right or wrong, how far off, how sure.

A record is a dictionary as it is kept: what was true, what was found, how long it took.
An answer is right when it is the true effect or a member of its group in ``sym2real.effects.groups``; in flights whose
heading turns, wind and a tilted mounting are not a group.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from answers import Record, all_matched, names
from figures import Figure
from scipy import stats

from sym2real.effects import same_group

# Of intervals below the quoted 95 %.
LEVELS = (0.5, 0.8)
PARAMETER_BARS = {"crazyflie": 0.03, "mushr": 0.05}
APART_WITH_YAW = {"wind", "mounting_tilt"}


def right(record: Record, truth: str, found: str) -> bool:
    """Whether a found effect counts as the true one."""
    if record["yaw"] and truth != found and {truth, found} <= APART_WITH_YAW:
        return False
    return bool(same_group(truth, found))


def true(record: Record, found: str) -> bool:
    """Whether an effect is one of those that could be found."""
    return any(right(record, truth, found) for truth in record["truth"] if truth not in record["excluded"])


def first_right(record: Record) -> bool:
    """Whether the first finding is one of the true effects."""
    found = names(record)
    return bool(found) and true(record, found[0])


def all_named(record: Record) -> bool:
    """Whether every true effect that could be found has a finding of its own."""
    asked = [truth for truth in record["truth"] if truth not in record["excluded"]]
    return all_matched([[right(record, truth, found) for found in names(record)] for truth in asked])


def exact(record: Record) -> bool:
    """Whether the findings are the true effects, no fewer and no more: one for each."""
    asked = [truth for truth in record["truth"] if truth not in record["excluded"]]
    return all_named(record) and len(record["findings"]) == len(asked)


def alarm(record: Record) -> bool:
    """Whether a null case was said to miss something."""
    return record["verdict"] in ("EFFECT", "UNEXPLAINED")


def flagged(record: Record) -> bool:
    """Whether something was said to be outside the library."""
    return record["verdict"] == "UNEXPLAINED" or record["leftover"] is not None


def parameter_errors(record: Record) -> list[float]:
    """|found − true| / |true − null| of every true effect that was found under its own name, over its parameters.

    A parameter that a finding leaves out stays at its null value.
    """
    errors = []
    for truth, values in record["truth"].items():
        for finding in record["findings"]:
            if finding["effect"] == truth:
                null = record["null"][truth]
                said = {**null, **{name: one["value"] for name, one in finding["parameters"].items()}}
                off = [said[name] - value for name, value in values.items()]
                size = [value - null[name] for name, value in values.items()]
                errors.append(float(np.linalg.norm(off) / np.linalg.norm(size)))
    return errors


def covered(record: Record, level: float = 0.95) -> list[bool]:
    """Whether each parameter found under its own name is as near the truth as an interval of this level says.

    Intervals are of 95 %; other levels are those of a normal error with the same interval.
    """
    part = stats.norm.ppf(0.5 + 0.5 * level) / stats.norm.ppf(0.975)
    return [
        abs(finding["parameters"][name]["value"] - value)
        <= part * 0.5 * (finding["parameters"][name]["high"] - finding["parameters"][name]["low"])
        for truth, values in record["truth"].items()
        for finding in record["findings"]
        if finding["effect"] == truth
        for name, value in values.items()
        if name in finding["parameters"]
    ]


def calibration(records: Sequence[Record], robot: str) -> list[Figure]:
    """How often answers are as right as they say: intervals at further levels, findings by what is left beside them.

    Findings are those of single and pair cases, and of both without an effect that the library lacked: nothing in its
    place is right, and what is left over should say so.
    """
    kinds = ("single", "pair", "removed", "half")
    asked = [one for name in kinds for one in of_kind(records, robot, name)]
    single = of_kind(records, robot, "single")
    answers = {
        f"{100 * level:.0f} % interval holds the truth": [one for record in single for one in covered(record, level)]
        for level in LEVELS
    }
    for left, words in ((False, "nothing"), (True, "something")):
        answers[f"finding right where {words} is left over"] = [
            true(record, name) for record in asked if (record["leftover"] is not None) is left for name in names(record)
        ]
    return [Figure(f"{robot}, {name}, of {len(flags)}", _share(flags), "") for name, flags in answers.items() if flags]


def fall(record: Record) -> list[float]:
    """Part of the held-out 0.8 s position error that the findings take away."""
    ladder = record["position_error"]
    return [1.0 - ladder[-1] / ladder[0]] if len(ladder) > 1 and ladder[0] > 0 else []


def against_truth(record: Record) -> list[float]:
    """0.8 s position error after adding, as a multiple of that of the simulator with the true effect."""
    truth = record.get("error_of_truth")
    return [record["position_error"][-1] / truth] if truth else []


def of_kind(records: Sequence[Record], robot: str, kind: str) -> list[Record]:
    """Records of a robot of one kind: single, pair, null, removed or half."""
    return [record for record in records if record["robot"] == robot and record["kind"] == kind]


def figures(records: Sequence[Record], robot: str) -> list[Figure]:
    """One figure per bar for a robot; kinds that were not run have none."""
    single, pair = of_kind(records, robot, "single"), of_kind(records, robot, "pair")
    null, removed = of_kind(records, robot, "null"), of_kind(records, robot, "removed")
    found: list[Figure] = []
    if single:
        found += _singles(single, robot)
    if pair:
        found += [
            Figure(
                f"{robot}, pairs: both named, of {len(pair)}", _share(all_named(one) for one in pair), "", ">= 0.90"
            ),
            Figure(f"{robot}, pairs: exact set", _share(exact(one) for one in pair), ""),
        ]
    if null:
        found += _nulls(null, robot)
    if removed:
        share = _share(flagged(one) for one in removed)
        found.append(Figure(f"{robot}, effect not in the library flagged, of {len(removed)}", share, "", ">= 0.90"))
    half = of_kind(records, robot, "half")
    if half:
        name = f"{robot}, one of two effects not in the library, of {len(half)}"
        found.append(Figure(f"{name}: the other is named", _share(all_named(one) for one in half), ""))
        found.append(Figure(f"{name}: flagged", _share(flagged(one) for one in half), ""))
    found += calibration(records, robot)
    seconds = [record["diagnosing"] for record in records if record["robot"] == robot]
    if seconds:
        found.append(Figure(f"{robot}, time: median", float(np.median(seconds)), "s", "<= 30"))
        found.append(Figure(f"{robot}, time: largest", max(seconds), "s"))
    return found


def _singles(single: Sequence[Record], robot: str) -> list[Figure]:
    errors = [error for record in single for error in parameter_errors(record)]
    inside = [one for record in single for one in covered(record)]
    sizes = [len(record["findings"][0]["group"]) for record in single if record["findings"]]
    falls = [one for record in single for one in fall(record)]
    share = _share(first_right(one) for one in single)
    found = [
        Figure(f"{robot}, first effect right, of {len(single)}", share, "", ">= 0.98"),
        Figure(f"{robot}, exact set", _share(exact(one) for one in single), "", ">= 0.95"),
    ]
    if sizes:
        found.append(Figure(f"{robot}, group reported first: median size", float(np.median(sizes)), "", "<= 2"))
    if errors:
        bar = f"<= {PARAMETER_BARS[robot]}"
        found += [
            Figure(f"{robot}, parameter error: median of {len(errors)}", float(np.median(errors)), "", bar),
            Figure(f"{robot}, parameter error: p90", float(np.quantile(errors, 0.9)), ""),
            Figure(f"{robot}, 95 % interval holds the truth, of {len(inside)}", _share(inside), "", ">= 0.90"),
        ]
    ratios = [one for record in single for one in against_truth(record)]
    if ratios:
        name = f"{robot}, 0.8 s held-out error after adding, of that of the simulator with the effect"
        found.append(Figure(f"{name}: median of {len(ratios)}", float(np.median(ratios)), "", "<= 1.3"))
        found.append(Figure(f"{name}: p90", float(np.quantile(ratios, 0.9)), ""))
    if falls:
        found.append(Figure(f"{robot}, fall of held-out 0.8 s position error: median", float(np.median(falls)), ""))
    return found


def _nulls(null: Sequence[Record], robot: str) -> list[Figure]:
    """False alarms with their exact (Clopper–Pearson) 95 % interval; three in 300 are allowed, one in fewer."""
    alarms = sum(alarm(record) for record in null)
    interval = stats.binomtest(alarms, len(null)).proportion_ci(0.95, method="exact")
    name = f"{robot}, false alarms in {len(null)} null cases"
    return [
        Figure(name, alarms, "cases", f"<= {max(1, len(null) // 100)}"),
        Figure(f"{name}, rate: low", float(interval.low), ""),
        Figure(f"{name}, rate: high", float(interval.high), ""),
    ]


def _share(flags: Any) -> float:
    return float(np.mean(list(flags)))
