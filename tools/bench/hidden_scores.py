"""What the answers of a diagnosis on the standard set are worth: right or wrong, how far off, how sure.

A record is a dictionary as it is kept: what was true, what was found, how long it took.
An answer is right when it is the true effect or a member of its group in ``sym2real.effects.groups``; in flights whose
heading turns, wind and a tilted mounting are not a group.
"""

from collections.abc import Sequence

from answers import Record, all_matched, names, parameter_error, same_group
from figures import Figure
from repeated import share, spread
from scipy import stats

# Of intervals below the quoted 95 %.
LEVELS = (0.5, 0.8)
PARAMETER_BARS = {"crazyflie": 0.03, "mushr": 0.05}
APART_WITH_YAW = {"wind", "mounting_tilt"}


def right(record: Record, truth: str, found: str) -> bool:
    """Whether a found effect counts as the true one."""
    if record["yaw"] and truth != found and {truth, found} <= APART_WITH_YAW:
        return False
    return same_group(truth, found)


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
    """Of every true effect that was found under its own name."""
    errors = []
    for truth, values in record["truth"].items():
        for finding in record["findings"]:
            if finding["effect"] == truth:
                said = {name: one["value"] for name, one in finding["parameters"].items()}
                errors.append(parameter_error(values, record["null"][truth], said))
    return errors


def covered(record: Record, level: float = 0.95) -> list[bool]:
    """Whether each parameter found under its own name is as near the truth as an interval of this level says.

    Intervals are of 95 %; other levels are those of a normal error with the same interval, to either side.
    """
    part = stats.norm.ppf(0.5 + 0.5 * level) / stats.norm.ppf(0.975)
    pairs = [
        (finding["parameters"][name], value)
        for truth, values in record["truth"].items()
        for finding in record["findings"]
        if finding["effect"] == truth
        for name, value in values.items()
        if name in finding["parameters"]
    ]
    return [
        part * (known["low"] - known["value"]) <= value - known["value"] <= part * (known["high"] - known["value"])
        for known, value in pairs
    ]


def calibration(records: Sequence[Record], robot: str) -> list[Figure]:
    """How often answers are as right as they say: intervals at further levels, findings by what is left beside them.

    Findings are those of single and pair cases, and of both without an effect that the library lacked: nothing in its
    place is right, and what is left over should say so.
    """
    kinds = ("single", "pair", "removed", "half")
    asked = [one for name in kinds for one in of_kind(records, robot, name)]
    single = of_kind(records, robot, "single")
    found: list[Figure] = []
    for level in LEVELS:
        inside = (one for record in single for one in covered(record, level))
        found += share(f"{robot}, {100 * level:.0f} % interval holds the truth", inside)
    for left, words in ((False, "nothing"), (True, "something")):
        beside = [record for record in asked if (record["leftover"] is not None) is left]
        flags = (true(record, name) for record in beside for name in names(record))
        found += share(f"{robot}, finding right where {words} is left over", flags)
    return found


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
    single, pair, null, removed, half = (
        of_kind(records, robot, kind) for kind in ("single", "pair", "null", "removed", "half")
    )
    lacking = f"{robot}, one of two effects not in the library"
    seconds = [record["diagnosing"] for record in records if record["robot"] == robot]
    return [
        *_singles(single, robot),
        *share(f"{robot}, pairs: both named", map(all_named, pair), ">= 0.90"),
        *share(f"{robot}, pairs: exact set", map(exact, pair)),
        *_nulls(null, robot),
        *share(f"{robot}, effect not in the library flagged", map(flagged, removed), ">= 0.90"),
        *share(f"{lacking}: the other is named", map(all_named, half)),
        *share(f"{lacking}: flagged", map(flagged, half)),
        *calibration(records, robot),
        *spread(f"{robot}, time", seconds, "s", "<= 30"),
        *(Figure(f"{robot}, time: longest", longest, "s") for longest in sorted(seconds)[-1:]),
    ]


def _singles(single: Sequence[Record], robot: str) -> list[Figure]:
    errors = [error for record in single for error in parameter_errors(record)]
    inside = (one for record in single for one in covered(record))
    sizes = [len(record["findings"][0]["group"]) for record in single if record["findings"]]
    falls = [one for record in single for one in fall(record)]
    ratios = [one for record in single for one in against_truth(record)]
    after = f"{robot}, 0.8 s held-out error after adding, of that of the simulator with the effect"
    return [
        *share(f"{robot}, first effect right", map(first_right, single), ">= 0.98"),
        *share(f"{robot}, exact set", map(exact, single), ">= 0.95"),
        *spread(f"{robot}, size of the group reported first", sizes, bar="<= 2"),
        *spread(f"{robot}, parameter error", errors, bar=f"<= {PARAMETER_BARS[robot]}"),
        *share(f"{robot}, 95 % interval holds the truth", inside, ">= 0.90"),
        *spread(after, ratios, bar="<= 1.3"),
        *spread(f"{robot}, fall of held-out 0.8 s position error", falls),
    ]


def _nulls(null: Sequence[Record], robot: str) -> list[Figure]:
    """False alarms: three in 300 are allowed, one in fewer."""
    if not null:
        return []
    allowed = max(1, len(null) // 100)
    alarms = Figure(f"{robot}, false alarms in {len(null)} null cases", sum(map(alarm, null)), "cases", f"<= {allowed}")
    return [alarms, *share(f"{robot}, rate of false alarms", map(alarm, null))]
