"""The answer of a diagnosis as a bench keeps it, and what it is worth against one truth or another answer."""

from collections.abc import Collection, Mapping, Sequence
from fnmatch import fnmatch
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from sym2real.dataset import Logs
from sym2real.diagnosis import Diagnosis, add, compare
from sym2real.effects.groups import GROUPS, others_of
from sym2real.errors import Sym2RealError, reason
from sym2real.json_objects import plain
from sym2real.neural.model_folder import Model
from sym2real.symbolic import Equations

Record = dict[str, Any]
HORIZON = 0.8  # s
REFUSED, CRASHED = "REFUSED", "CRASHED"
# What a program raises that nobody foresaw; an answer too, and one that a table must show.
UNFORESEEN = (ArithmeticError, LookupError, RuntimeError, TypeError, ValueError)
# Pairs of parameters that are components along the world's axes.
ALONG_THE_WORLD = (("fx", "fy"), ("gx", "gy"))


def answer_of(found: Diagnosis) -> Record:
    """Verdict, findings, faults and what is left, as JSON holds them."""
    return {
        "verdict": found.verdict,
        "findings": found.to_dict()["findings"],
        "faults": plain(found.faults),
        "leftover": plain(found.leftover),
        # Of the place, whatever a robot's place is.
        "position_error": [next(iter(stage.horizons[stage.nearest(HORIZON)].values())).value for stage in found.ladder],
        "notes": list(found.notes),
        "misfit": list(found.misfit),
        "seconds": found.seconds,
    }


def error_ahead(model: Model, logs: Logs, seconds: float) -> float:
    """Root mean square position error in m so far ahead of measured starts."""
    return float(compare(model, logs, (seconds,), start="measured").at(seconds).errors["position"].value)


def refusal(error: Exception) -> Record:
    """In place of an answer: logs that nobody could judge, and why; or a crash, which says nothing of the logs."""
    empty: Record = {"findings": [], "faults": [], "leftover": None, "position_error": [], "notes": [], "misfit": []}
    if isinstance(error, Sym2RealError):
        return {**empty, "verdict": REFUSED, "error": reason(error), "seconds": 0.0}
    return {**empty, "verdict": CRASHED, "crash": f"{type(error).__name__}: {error}", "seconds": 0.0}


def with_findings(equations: Equations, answer: Record) -> Equations:
    """The model that a diagnosis leaves."""
    found = [
        (one["effect"], {name: estimate["value"] for name, estimate in one["parameters"].items()})
        for one in answer["findings"]
    ]
    return add(equations, found) if found else equations


def sentences(answer: Record) -> list[str]:
    """What an answer says of the data: faults with evidence and remedy, remedies, remarks, the reason of a refusal."""
    faults = [f"{fault['effect']} {fault['evidence']} {fault['fix']}" for fault in answer["faults"]]
    remedies = [finding.get("fix", "") for finding in answer["findings"]]
    return [*faults, *remedies, *answer["notes"], *([answer["error"]] if "error" in answer else [])]


def in_form_of_the_answer(record: Record) -> Record:
    """The truth with a delay of all commands as part of each command's own, where the answer has none of all."""
    truth, found = record["truth"], [finding["effect"] for finding in record["findings"]]
    own = [key for key in found if key.startswith("delay:")]
    if "delay" not in truth or "delay" in found or not own:
        return record
    of_all = truth["delay"]["value"]
    parts = {key: {"value": of_all + truth.get(key, {"value": 0.0})["value"]} for key in own}
    return {**record, "truth": {key: value for key, value in truth.items() if key != "delay"} | parts}


def names(answer: Record) -> list[str]:
    """Effects found, the most important first."""
    return [finding["effect"] for finding in answer["findings"]]


def first(answer: Record) -> str:
    """The most important finding; the verdict where there is none."""
    return next(iter(names(answer)), answer["verdict"])


def stands_for(finding: Record, key: str) -> bool:
    """Whether a finding is this effect, or one that physics takes for it.

    The group that an answer reports of itself does not count: a larger one would make any answer right.
    """
    return same_group(finding["effect"], key)


def same_group(key: str, other: str) -> bool:
    """Whether two keys may stand for each other."""
    return key == other or any(fnmatch(other, member) for member in others_of(key, GROUPS))


def named(answer: Record, key: str) -> bool:
    """Whether any finding stands for an effect."""
    return any(stands_for(finding, key) for finding in answer["findings"])


def all_named(answer: Record, keys: Collection[str]) -> bool:
    """Whether every effect has a finding that stands for it, no finding for two of them."""
    return all_matched([[stands_for(finding, key) for finding in answer["findings"]] for key in keys])


def all_matched(matches: Sequence[Sequence[bool]]) -> bool:
    """Whether every row can have a column of its own that holds for it."""
    table = np.array(matches, dtype=int)
    return not matches or (table.size > 0 and int(table[linear_sum_assignment(-table)].sum()) == len(matches))


def parameter_error(truth: Mapping[str, float], null: Mapping[str, float], found: Mapping[str, float]) -> float:
    """|found − true| / |true − null| over the parameters of the true effect; those not found are at null."""
    off = [found.get(name, null[name]) - value for name, value in truth.items()]
    return float(np.linalg.norm(off) / np.linalg.norm([value - null[name] for name, value in truth.items()]))


def same_first(one: Record, other: Record) -> bool:
    """Whether two answers begin with the same effect, or with members of one group of physics; or both with none."""
    if not (one["findings"] and other["findings"]):
        return first(one) == first(other)
    return stands_for(one["findings"][0], first(other))


def within_both(one: Record, other: Record, angle: float = 0.0) -> list[bool]:
    """Per parameter of effects that both found: whether each answer's value is in the other's interval.

    Args:
        one, other: answers.
        angle: by which the other's world was turned to the left, rad.
    """
    theirs = {finding["effect"]: turned(finding["parameters"], -angle) for finding in other["findings"]}
    return [
        _holds(mine, theirs[finding["effect"]][name]) and _holds(theirs[finding["effect"]][name], mine)
        for finding in one["findings"]
        if finding["effect"] in theirs
        for name, mine in finding["parameters"].items()
        if name in theirs[finding["effect"]]
    ]


def _holds(interval: Mapping[str, float], of: Mapping[str, float]) -> bool:
    return interval["low"] <= of["value"] <= interval["high"]


def turned(parameters: Mapping[str, Record], angle: float) -> dict[str, Record]:
    """Estimates in a world turned to the left by ``angle`` rad; half-widths as of independent components."""
    result = dict(parameters)
    cosine, sine = np.cos(angle), np.sin(angle)
    for pair in ALONG_THE_WORLD:
        if not all(name in parameters for name in pair):
            continue
        values = np.array([parameters[name]["value"] for name in pair])
        halves = np.array([0.5 * (parameters[name]["high"] - parameters[name]["low"]) for name in pair])
        matrix = np.array([[cosine, -sine], [sine, cosine]])
        for name, value, half in zip(pair, matrix @ values, np.sqrt(matrix**2 @ halves**2), strict=True):
            bounds = {"value": float(value), "low": float(value - half), "high": float(value + half)}
            result[name] = {**parameters[name], **bounds}
    return result
